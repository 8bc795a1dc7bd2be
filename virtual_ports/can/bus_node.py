"""Node of a CAN bus: what it has to send, what it hears of others, what it counts."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs
from hil.wire.can._wire_bits import wire_bits
from hil.wire.can.can_bus_protocol import CanFilter, CanListener, MailboxesFull, NodeState
from hil.wire.can.can_frame import CanFrame, check, urgency
from virtual_ports.can._bit_wire import BitWire

PASSIVE_FROM = 128
_BUS_OFF = 2


class Mailbox(NamedTuple):
    """Frame that waits, the most urgent first, of one urgency the oldest first."""

    urgency: int
    number: int
    frame: CanFrame
    bits: bytes


@dataclass
class NodeStats:
    """Counters of a node; ``errors`` that it has found, by kind; ``refused``: frames without a mailbox."""

    sent: int = 0
    heard: int = 0
    refused: int = 0
    errors: dict[str, int] = field(default_factory=dict)


class Mailboxes:
    """Frames of a node that wait, and the one that is being sent."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._waiting: list[Mailbox] = []
        self._count = 0
        self._slots: list[Mailbox | None] = [None, None]
        """Frames that were loaded last into each of the controller's two places."""

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def first(self) -> Mailbox | None:
        """The most urgent."""
        return self._waiting[0] if self._waiting else None

    def put(self, frame: CanFrame) -> bool:
        """Put a frame into a mailbox; True if none that waits is more urgent.

        Raises:
            MailboxesFull: there is no free one.
            ValueError: the frame cannot be sent.
        """
        check(frame)
        if len(self._waiting) >= self.size:
            raise MailboxesFull(f"all {self.size} mailboxes are full")
        self._count += 1
        mailbox = Mailbox(urgency(frame), self._count, frame, wire_bits(frame))
        heappush(self._waiting, mailbox)
        return self._waiting[0] is mailbox

    def load(self, wire: BitWire, index: int) -> None:
        if not self._waiting:
            wire.unload(index)
            return
        first = self._waiting[0]
        self._slots[wire.load(index, first.bits, first.urgency)] = first

    def sent(self, slot: int) -> CanFrame:
        """Take out the frame of a controller's place, as it has been sent."""
        mailbox = self._slots[slot]
        assert mailbox
        if self._waiting and self._waiting[0] is mailbox:
            heappop(self._waiting)
        elif mailbox in self._waiting:
            self._waiting.remove(mailbox)
            heapify(self._waiting)
        return mailbox.frame

    def clear(self) -> None:
        self._waiting.clear()


@dataclass(eq=False)
class BusNode:
    """Node on a bus, under its name. ``filters``: frames that it is told of; None: of all."""

    name: str
    index: int
    listener: CanListener
    mailboxes: Mailboxes
    filters: Sequence[CanFilter] | None = None
    is_listening: bool = False
    recovers: bool = True
    is_on: bool = True
    bit_rate: int = 0
    """Its own, in bits per second; 0: the bus's."""
    stats: NodeStats = field(default_factory=NodeStats)
    state: NodeState = NodeState.ACTIVE
    wire_faults: dict[int, Fault] = field(default_factory=dict)
    """Faults by number, the oldest first."""

    def load(self, wire: BitWire) -> None:
        if self.is_listening or not self.is_on:
            wire.unload(self.index)
        else:
            self.mailboxes.load(wire, self.index)

    def wants(self, frame: CanFrame) -> bool:
        return self.filters is None or any(each.wants(frame) for each in self.filters)

    def state_in(self, wire: BitWire) -> NodeState:
        """State that the node has on a wire now."""
        if not self.is_on:
            return NodeState.OFF
        state, transmit_errors, receive_errors, _ = wire.look(self.index)
        if state == _BUS_OFF:
            return NodeState.BUS_OFF
        is_passive = max(transmit_errors, receive_errors) >= PASSIVE_FROM
        return NodeState.PASSIVE if is_passive else NodeState.ACTIVE

    def note_state(self, wire: BitWire, now_ns: SimTimeNs) -> bool:
        """Tell the listener of the state, if it is another than before; answers whether it is."""
        state = self.state_in(wire)
        if state is self.state:
            return False
        self.state = state
        self.listener.changed(state, now_ns)
        return True

    def counters(self, wire: BitWire) -> dict[str, Any]:
        """Counters since the node joined, for JSON."""
        _, transmit_errors, receive_errors, lost = wire.look(self.index)
        return {
            **vars(self.stats),
            "errors": dict(self.stats.errors),
            "arbitrations_lost": lost,
            "waiting": len(self.mailboxes),
            "state": self.state_in(wire).value,
            "transmit_errors": transmit_errors,
            "receive_errors": receive_errors,
        }
