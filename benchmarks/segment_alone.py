"""How many packets a second the segment and its codec carry in virtual time, without boards.

At least 50,000 are wanted. A master sends to one node after the other, each answers; 2 and 252 nodes.

Beside it, if python-can is installed, its virtual bus, which knows no time: one message a turn.
"""

import statistics
import sys
import time
from collections.abc import Sequence

from hil.vocab.segment import HeardCharacter
from hil.vocab.time import SimTimeNs
from hil.wire.packet import encode
from virtual_ports.rs485.segment import Segment

BAUD = 1_000_000
TURNS = 2_000 if "--quick" in sys.argv else 20_000
RUNS = 5


class Ear:
    """A receiver that counts."""

    baud_now = BAUD

    def __init__(self) -> None:
        self.heard = 0

    def hear(self, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        self.heard += 1

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        return

    def retract(self, after_ns: SimTimeNs) -> None:
        return


def packets_a_second(nodes: int) -> float:
    segment = Segment()
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
        segment.transmit("master", SimTimeNs(at_ns), command, BAUD)
        segment.transmit(name, SimTimeNs(at_ns + 130_000), ack, BAUD)
        at_ns += 220_000
    seconds = time.perf_counter() - start
    segment.settle(at_ns)
    assert segment.stats.packets == 2 * TURNS
    assert sum(ear.heard for ear in ears.values()) == TURNS
    return 2 * TURNS / seconds


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
            receiver.recv(0)
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


main()
