"""A segment full of nodes, ready to be talked to."""

from collections.abc import Callable

from hil.testing.bench import Bench

NODE = "sac"
COLD_START_MS = 1100


def segment_of(make: Callable[..., Bench], nodes: int, *, baud: int, first: int, seed: int) -> Bench:
    """A bench of SACs on ``bus0`` with a tap ``bus0.master``; each has its address and the line's speed.

    Raises:
        ValueError: addresses do not fit: they are 4 to 255.
    """
    if nodes < 1 or first < 4 or first + nodes > 256:
        raise ValueError(f"{nodes} nodes from address {first} on do not fit: addresses are 4 to 255")
    names = {f"s{address}": address for address in range(first, first + nodes)}
    bench = make(
        {
            "bench": "nodes",
            "devices": {name: {"profile": NODE} for name in names},
            "segments": {
                "bus0": {"stations": list(names), "taps": {"master": {"port": "memory"}}, "baud": baud}
            },
        },
        seed,
    )
    bench.run(ms=COLD_START_MS)
    for line in (b"$CM%d\r", b"$Cn" + str(baud).encode() + b"\r", b"$R\r"):
        for name, address in names.items():
            bench.port(name).write(line % address if b"%" in line else line)
        bench.run(ms=100)
    for name in names:
        bench.port(name).read()
    bench.tap("bus0.master").read()
    return bench
