"""A calibrated Mechaduino on the virtual clock, holding its position: where every example begins."""

from hil.testing import Bench


def holding(**device: object) -> Bench:
    """Bench with its board in position mode, loop on, still, at 0 degrees. ``device``: keys of its
    configuration."""
    settings = {"profile": "mechaduino", "flash": {"table": "identity"}} | device
    bench = Bench({"bench": "examples", "devices": {"m1": settings}})
    bench.run(ms=4500)  # the board's start
    bench.port("m1").write(b"xy")
    bench.run(ms=500)
    for level in (1, 0):  # the firmware learns of the direction input at its edges alone; now it is low
        bench.device("m1").pin("D0", level)
    move_to(bench, 0)
    bench.run(ms=500)
    bench.port("m1").read()
    return bench


def move_to(bench: Bench, degrees: float) -> None:
    """Type a set-point; the board jumps to it."""
    bench.port("m1").write(f"r{degrees:.2f}\n".encode())
    bench.run(ms=1)
