"""CPU cost of a packet on a segment in virtual time, with 2 and with 252 SACs, at 1 Mbaud.

A master on a tap sends commands to one node after the other and each is acknowledged; then commands to all.
Prints the CPU time of a packet, which 252 nodes may make a tenth longer than 2, and that of a command to all
for each node, at most 8 us. Every answer is counted. Beside it, if python-can is installed, its virtual bus
with as many nodes that only receive.
"""

import statistics
import sys
import time
from collections.abc import Callable
from functools import partial

from _report import check_work

from device_profiles.sac.packet import PacketDecoder, encode
from hil.testing import Bench

BAUD = 1_000_000
COUNT = 200 if "--quick" in sys.argv else 1000
TO_ALL = 20 if "--quick" in sys.argv else 100
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


def show(about: str, measure: Callable[[], float]) -> float:
    runs = [measure() for _ in range(RUNS)]
    print(f"{about:42} median {statistics.median(runs):8.2f} us  least {min(runs):8.2f} us")
    return statistics.median(runs)


def main() -> None:
    packet_us = {}
    for count in (2, 252):
        bench, addresses = nodes(count)
        packet_us[count] = show(
            f"{count:3} nodes, a packet to or from one", partial(one_by_one_us, bench, addresses)
        )
        for name, data in COMMANDS.items():
            show(f"{count:3} nodes, to all, for each: {name}", partial(to_all_us, bench, addresses, data))
        if (can_us := python_can_us(count)) is not None:
            print(f"{count:3} nodes on python-can's virtual bus: {can_us / count:.2f} us a frame and node")
    print(f"252 nodes to 2 nodes, a packet: {packet_us[252] / packet_us[2]:.2f}, wanted at most 1.1")


main()
