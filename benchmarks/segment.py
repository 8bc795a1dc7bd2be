"""CPU cost of a packet on a segment in virtual time, with 2 and with 252 SACs, at 1 Mbaud.

``segment_packet``: a packet where a master on a tap sends commands to each of 252 nodes in turn, and each is
acknowledged; it may take a tenth longer than with 2 nodes. ``segment_packet_of_two``: the same where it talks
to two of the 252, whose objects stay in the processor's caches. ``segment_to_all_velocity``, ``_nothing``: a
command to all 252, for each node, at most 3 us; beside it in the JSON file, if python-can is installed, its
virtual bus with as many nodes that only receive. Every answer is counted.
"""

import statistics
import time
from collections.abc import Callable, Mapping
from functools import partial

from _report import check_work, is_quick, report

from device_profiles.sac.packet import PacketDecoder, encode
from hil.testing import Bench

BAUD = 1_000_000
COUNT = 200 if is_quick() else 1000
TO_ALL = 20 if is_quick() else 100
TO_ALL_LIMIT_US = 3.0
RUNS = 5
MASTER, ALL = 1, 0
CHARACTER_MS = 10 / BAUD * 1e3
COMMANDS = {"velocity": b"v150", "nothing": b"zz"}


def nodes(count: int) -> tuple[Bench, list[int]]:
    """A bench with SACs at their addresses and at the speed, edges not recorded."""
    addresses = list(range(4, 4 + count))
    names = [f"s{address}" for address in addresses]
    segment = {"stations": names, "taps": {"m": {"port": "memory"}}, "baud": BAUD}
    bench = Bench(
        {
            "bench": "segment",
            "devices": {name: {"profile": "sac"} for name in names},
            "segments": {"bus0": segment},
        }
    )
    bench.run(1100)
    for lines, wait_ms in (("$CM{address}", 50), ("$Cn{baud}", 50), ("$R", 1200)):
        for name, address in zip(names, addresses, strict=True):
            bench.port(name).write(f"{lines.format(address=address, baud=BAUD)}\r".encode())
        bench.run(wait_ms)
    return bench, addresses


def one_by_one_us(bench: Bench, addresses: list[int]) -> float:
    """CPU time of a packet: half of a command with its ACK."""
    tap = bench.tap("bus0.m")
    tap.read()
    start_s = time.process_time()
    for i in range(COUNT):
        tap.write(encode(addresses[i % len(addresses)], MASTER, b"v150"))
        bench.run((10 + 2 + 7 + 2) * CHARACTER_MS)
    spent_s = time.process_time() - start_s
    if (acks := len(PacketDecoder().feed(tap.read()))) != COUNT:
        raise SystemExit(f"{acks} answers to {COUNT} commands")
    return spent_s / (2 * COUNT) * 1e6


def to_all_us(bench: Bench, addresses: list[int], data: bytes) -> float:
    """CPU time of a command to all, for each node."""
    tap, packets = bench.tap("bus0.m"), bench.segment("bus0").stats.packets
    start_s = time.process_time()
    for _ in range(TO_ALL):
        tap.write(encode(ALL, MASTER, data))
        bench.run(20 * CHARACTER_MS)
    spent_s = time.process_time() - start_s
    check_work("commands to all", bench.segment("bus0").stats.packets - packets, TO_ALL)
    return spent_s / TO_ALL / len(addresses) * 1e6


def python_can_us(count: int) -> float | None:
    """CPU time of a frame on python-can's virtual bus, received by so many; None: it is not installed."""
    try:
        import can  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        return None
    buses = [can.Bus("segment", interface="virtual") for _ in range(count + 1)]
    message = can.Message(arbitration_id=1, data=b"v150", is_extended_id=False)
    start_s = time.process_time()
    for _ in range(TO_ALL):
        buses[0].send(message)
        for bus in buses[1:]:
            if bus.recv(0) is None:
                raise SystemExit("a frame was lost")
    spent_s = time.process_time() - start_s
    for bus in buses:
        bus.shutdown()
    return spent_s / TO_ALL * 1e6


def medians(works: Mapping[str, Callable[[], float]]) -> dict[str, float]:
    """Median of each, in turns."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(RUNS):
        for name, work in works.items():
            found[name].append(work())
    return {name: statistics.median(runs) for name, runs in found.items()}


def main() -> None:
    few, (bench, addresses) = nodes(2), nodes(252)
    works = {
        "of 2": partial(one_by_one_us, *few),
        "of 252": partial(one_by_one_us, bench, addresses),
        "two of 252": partial(one_by_one_us, bench, addresses[:2]),
    }
    found = medians(works | {name: partial(to_all_us, bench, addresses, COMMANDS[name]) for name in COMMANDS})
    about = {"reference": "a segment of 2 nodes"}
    report("segment_packet", found["of 252"], "us", found["of 2"], 1.1, {**about})
    report("segment_packet_of_two", found["two of 252"], "us", found["of 2"], 1.1, {**about})
    for name in COMMANDS:
        each = {"reference": "3 us for each node", "python_can_us": python_can_us(len(addresses))}
        report(f"segment_to_all_{name}", found[name], "us", TO_ALL_LIMIT_US, 1.0, each)


main()
