"""A CAN bus alone on a clock of its own, what its nodes were told, and a slow bus to compare with."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import Any, NamedTuple

from bridges.can.bus.bus_events import BusEvent, NodeState
from bridges.can.bus.can_bus import CanBus
from bridges.can.bus.can_faults import CanFaults
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.faults import Fault

RATE = 500_000
BIT_NS = 10**9 // RATE
READY_NS = 100_000
"""Time at which nodes that join at 0 are ready to send."""


class Timeline:
    """Simulated time, as a group has it."""

    def __init__(self) -> None:
        self.now_ns: Any = 0
        self._calls: list[tuple[int, int, Callable[[Any], None]]] = []
        self._count = 0

    def at(self, at_ns: int, call: Callable[[Any], None]) -> None:
        assert at_ns >= self.now_ns
        self._count += 1
        heappush(self._calls, (at_ns, self._count, call))

    def run(self, until_ns: int) -> None:
        while self._calls and self._calls[0][0] <= until_ns:
            self.now_ns, _, call = heappop(self._calls)
            call(self.now_ns)
        self.now_ns = max(self.now_ns, until_ns)


class Told(NamedTuple):
    """Frame with its times."""

    start_ns: int
    end_ns: int
    frame: CanFrame


@dataclass
class Ear:
    """A listener that keeps what it is told."""

    got: list[Told] = field(default_factory=list)
    out: list[Told] = field(default_factory=list)
    states: list[tuple[int, NodeState]] = field(default_factory=list)

    def hear(self, frame: CanFrame, start_ns: int, end_ns: int) -> None:
        self.got.append(Told(start_ns, end_ns, frame))

    def sent(self, frame: CanFrame, start_ns: int, end_ns: int) -> None:
        self.out.append(Told(start_ns, end_ns, frame))

    def changed(self, state: NodeState, at_ns: int) -> None:
        self.states.append((at_ns, state))


class Bench(CanBus):
    """Nodes by their names, ready at ``READY_NS``."""

    def __init__(self, *names: str, rate: int = RATE, leaps: bool = True) -> None:
        self.timeline = Timeline()
        super().__init__(self.timeline, rate)
        self.main_line.wire.leaps = leaps
        self.ears = {name: Ear() for name in names}
        self.events: list[BusEvent] = []
        self.watchers.append(self.events.append)
        self.faults = CanFaults(self)
        for name, ear in self.ears.items():
            self.join(name, ear)

    def run(self, until_ns: int = READY_NS) -> None:
        self.timeline.run(until_ns)

    def later(self, by_ns: int) -> None:
        self.timeline.run(self.timeline.now_ns + by_ns)

    def inject(self, number: int, kind: str, node: str = "", **parameters: float) -> Fault:
        fault = Fault(kind, node or "can0", {"seed": 0, "rate": 1.0} | parameters)
        self.faults.inject(number, fault, node)
        return fault

    def everything(self) -> object:
        """All that can be seen of it."""
        return (
            {name: (ear.got, ear.out, ear.states) for name, ear in self.ears.items()},
            self.events,
            self.counters(self.timeline.now_ns),
        )


# ---- slow and simple: nobody makes an error ----


def plain(frame: CanFrame) -> list[int]:
    """Bits of a frame from its start to its CRC, by the book: fields as text."""
    remote = "1" if frame.is_remote else "0"
    if frame.is_extended:
        digits = f"{frame.id:029b}"
        text = "0" + digits[:11] + "11" + digits[11:] + remote + "00"
    else:
        text = "0" + f"{frame.id:011b}" + remote + "00"
    text += f"{frame.dlc:04b}" + "".join(f"{byte:08b}" for byte in frame.data)
    return [int(digit) for digit in text + f"{remainder(text):015b}"]


def remainder(text: str) -> int:
    """Remainder of a division of polynomials, on paper."""
    divisor = 0b1100010110011001
    value = int(text, 2) << 15
    for place in range(value.bit_length() - 1, 14, -1):
        if value >> place & 1:
            value ^= divisor << place - 15
    return value


def stuffed(bits: Iterable[int]) -> list[int]:
    out: list[int] = []
    for bit in bits:
        out.append(bit)
        if len(out) >= 5 and len(set(out[-5:])) == 1 and _run(out) == 5:
            out.append(1 - bit)
    return out


def _run(bits: list[int]) -> int:
    count = 0
    while count < len(bits) and bits[-1 - count] == bits[-1]:
        count += 1
    return count


def _head(frame: CanFrame) -> list[int]:
    """Bits by which frames of one node are in order: to the last that tells whose turn it is."""
    return plain(frame)[: 33 if frame.is_extended else 14]


class Offer(NamedTuple):
    """Frame that a node has to send from a bit on."""

    bit: int
    node: int
    frame: CanFrame


def play(offers: Iterable[Offer]) -> list[tuple[int, int, int, CanFrame]]:
    """Play frames of nodes on a bus whose bits all see, one after the other: start, end, node, frame. Of one
    node the lowest identifier goes first, of those the oldest. No two nodes have one identifier."""
    waiting = sorted(offers)
    done: list[tuple[int, int, int, CanFrame]] = []
    bit = 0
    while waiting:
        bit = max(bit, waiting[0].bit)
        contending: dict[int, Offer] = {}
        for offer in waiting:
            if offer.bit <= bit:
                best = contending.get(offer.node)
                if best is None or _head(offer.frame) < _head(best.frame):
                    contending[offer.node] = offer
        sending = {node: [*stuffed(plain(offer.frame)), *[1] * 10] for node, offer in contending.items()}
        at = 0
        while True:
            level = min(bits[at] for bits in sending.values())
            sending = {node: bits for node, bits in sending.items() if bits[at] == level}
            at += 1
            if len(sending) == 1 and at == len(next(iter(sending.values()))):
                break
        winner = contending[next(iter(sending))]
        done.append((bit, bit + at, winner.node, winner.frame))
        waiting.remove(winner)
        bit += at + 3
    return done
