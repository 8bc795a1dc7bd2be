"""Speed of the segment and its codec in virtual time, without boards: packets a second, and the CPU time of a
collision and of a line that is never idle.

At least 50,000 are wanted. A master sends to one node after the other, each answers; 2 and 252 nodes.

Beside it, if python-can is installed, its virtual bus, which knows no time: one message a turn.
"""

import statistics
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from heapq import heappop, heappush

from device_profiles.sac.framing import FRAMING
from device_profiles.sac.packet import encode
from hil.vocab.segment import HeardCharacter
from hil.vocab.time import SimTimeNs
from virtual_ports.rs485.segment import Rs485Segment

BAUD = 1_000_000
TURNS = 2_000 if "--quick" in sys.argv else 20_000
RUNS = 5


class Timeline:
    """Simulated time."""

    def __init__(self) -> None:
        self.now_ns = SimTimeNs(0)
        self._calls: list[tuple[int, int, Callable[[SimTimeNs], None]]] = []
        self._count = 0

    def at(self, at_ns: int, call: Callable[[SimTimeNs], None]) -> None:
        self._count += 1
        heappush(self._calls, (at_ns, self._count, call))

    def run(self, until_ns: int) -> None:
        while self._calls and self._calls[0][0] <= until_ns:
            at_ns, _, call = heappop(self._calls)
            self.now_ns = SimTimeNs(at_ns)
            call(self.now_ns)
        self.now_ns = SimTimeNs(until_ns)


class Ear:
    """A receiver that counts."""

    baud_now = BAUD

    def __init__(self) -> None:
        self.heard = 0

    def hear(self, start_ns: SimTimeNs, data: bytes, baud: int, packets: object = None) -> None:
        self.heard += 1

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        return

    def retract(self, after_ns: SimTimeNs) -> None:
        return


def packets_a_second(nodes: int) -> float:
    timeline = Timeline()
    segment = Rs485Segment(timeline, FRAMING)
    ears = {f"s{address}": Ear() for address in range(4, 4 + nodes)}
    for name, ear in ears.items():
        segment.join(name, ear)
        segment.set_address(name, int(name[1:]))
    segment.join("master", Ear())
    numbers = [(name, int(name[1:])) for name in ears]
    turns = [(name, encode(node, 1, b"m3000"), encode(1, node, b"\6")) for name, node in numbers]
    at_ns = 0
    start = time.perf_counter()
    for turn in range(TURNS):
        name, command, ack = turns[turn % nodes]
        timeline.run(at_ns)
        segment.transmit("master", timeline.now_ns, command, BAUD)
        timeline.run(at_ns + 130_000)
        segment.transmit(name, timeline.now_ns, ack, BAUD)
        at_ns += 220_000
    timeline.run(at_ns)
    seconds = time.perf_counter() - start
    assert segment.stats.packets == 2 * TURNS
    assert sum(ear.heard for ear in ears.values()) == TURNS
    return 2 * TURNS / seconds


def collision_ms(nodes: int) -> float:
    """CPU time of a collision in which so many nodes acknowledge at once."""
    timeline = Timeline()
    segment = Rs485Segment(timeline, FRAMING)
    names = [f"s{address}" for address in range(4, 4 + nodes)]
    for name in names:
        segment.join(name, Ear())
    start_s = time.process_time()
    for address, name in enumerate(names, 4):
        segment.transmit(name, timeline.now_ns, encode(1, address, b"\6"), BAUD)
    timeline.run(10**9)
    assert segment.stats.collisions == nodes - 1
    return (time.process_time() - start_s) * 1e3


def busy_s(seconds: int) -> float:
    """CPU time of the last second of a line of 38400 baud on which two stations never stop."""
    timeline = Timeline()
    segment = Rs485Segment(timeline, FRAMING)
    for name in "abcd":
        ear = Ear()
        ear.baud_now = 38400
        segment.join(name, ear)

    def speak(name: str, now_ns: SimTimeNs) -> None:
        segment.transmit(name, now_ns, bytes(range(now_ns % 200, now_ns % 200 + 20)), 38400)
        timeline.at(now_ns + 5_000_000, partial(speak, name))

    timeline.at(0, partial(speak, "a"))
    timeline.at(2_345_678, partial(speak, "b"))
    timeline.run((seconds - 1) * 10**9)
    start_s = time.process_time()
    timeline.run(seconds * 10**9)
    return time.process_time() - start_s


def python_can() -> float | None:
    try:
        import can
    except ImportError:
        return None
    with can.Bus("x", interface="virtual") as sender, can.Bus("x", interface="virtual") as receiver:
        message = can.Message(arbitration_id=5, data=b"m3000", is_extended_id=False)
        start = time.perf_counter()
        for _ in range(TURNS):
            sender.send(message)
            assert receiver.recv(0), "a frame was lost"
        return TURNS / (time.perf_counter() - start)


def main() -> None:
    found: dict[str, list[float]] = {"2 nodes": [], "252 nodes": [], "python-can": []}
    for _ in range(RUNS):
        found["2 nodes"].append(packets_a_second(2))
        found["252 nodes"].append(packets_a_second(252))
        if (rate := python_can()) is not None:
            found["python-can"].append(rate)
    for name, rates in found.items():
        print(
            f"{name:12} {statistics.median(rates):10,.0f} a second" if rates else f"{name:12} not installed"
        )
    for nodes in (64, 252):
        least_ms = min(collision_ms(nodes) for _ in range(RUNS))
        print(f"{nodes} nodes that answer at once: {least_ms:.1f} ms, wanted at most 20")
    for seconds in (2, 5):
        print(f"second {seconds} of a line that is never idle: {busy_s(seconds):.2f} s")


main()
