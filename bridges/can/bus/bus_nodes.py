"""Nodes of a CAN bus by their names, by their numbers on the wire, and by what they want to hear; and what
its wires say has happened, told to them and to watchers, and counted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

from bridges.can.bus._bit_wire import BitWire
from bridges.can.bus.bus_events import BusEvent, CanFilter, CanListener, MailboxesFull, NodeState
from bridges.can.frames._wire_bits import wire_bits
from bridges.can.frames.can_frame import CanFrame, check, urgency
from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs

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


@dataclass(eq=False, slots=True)
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


MOST_NODES = 256
_KEPT_IDENTIFIERS = 4096


class BusNodes(dict[str, BusNode]):
    """Nodes by name. Only ``join`` and ``leave`` change which there are."""

    def __init__(self) -> None:
        super().__init__()
        self._of: list[BusNode | None] = []
        self._wanting: dict[tuple[int, bool], list[BusNode]] = {}
        """Nodes that want an identifier, as far as it was asked for."""

    def free_index(self, name: str) -> int:
        """Number for a new node.

        Raises:
            ValueError: the name is taken, or all numbers are.
        """
        if name in self:
            raise ValueError(f"{name} is on the bus already")
        index = next((at for at, node in enumerate(self._of) if node is None), len(self._of))
        if index >= MOST_NODES:
            raise ValueError(f"a bus has at most {MOST_NODES} nodes")
        return index

    def join(self, node: BusNode) -> None:
        self[node.name] = node
        # A slice: the place may be the one behind the last.
        self._of[node.index : node.index + 1] = [node]
        self.changed()

    def leave(self, name: str) -> None:
        self._of[self.pop(name).index] = None
        self.changed()

    def changed(self) -> None:
        """Note that what nodes want may have changed."""
        self._wanting.clear()

    def at(self, index: int) -> BusNode | None:
        """Node of a number."""
        return self._of[index]

    def wanting(self, frame: CanFrame) -> Sequence[BusNode]:
        """Nodes that want a frame, by its identifier."""
        key = frame.id, frame.is_extended
        found = self._wanting.get(key)
        if found is None:
            # A client may send ever new identifiers, of which 29 bits make half a billion.
            if len(self._wanting) >= _KEPT_IDENTIFIERS:
                self._wanting.clear()
            found = self._wanting[key] = [node for node in self._of if node and node.wants(frame)]
        return found


ERRORS = ("", "bit", "stuff", "CRC", "form", "acknowledgement")
"""Kinds of errors, by the numbers of the wire."""
_SENT, _HEARD, _ERROR, _CHANGED = 1, 2, 4, 8


class BusNews:
    """News of the nodes of one bus. ``offer``: called with a node that has sent, and may have more."""

    def __init__(self, nodes: BusNodes, offer: Callable[[BusNode], None]) -> None:
        self.frames = 0
        self.errors: dict[str, int] = {}
        """Errors by kind, each once for a bit, however many have found it."""
        self.watchers: list[Callable[[BusEvent], None]] = []
        self._nodes = nodes
        self._offer = offer

    def tell(self, wire: BitWire, now_ns: SimTimeNs) -> None:
        """Tell what has just happened on a wire."""
        if wire.sender >= 0:
            sender = self._nodes.at(wire.sender)
            assert sender
            self._tell_frame(wire, sender, now_ns)
            return
        counted = set()
        for index, what, error in wire.events():
            node = self._nodes.at(index)
            if node is None:
                continue
            if what & _ERROR:
                self._tell_error(node, wire, error, now_ns, error not in counted)
                counted.add(error)
            if what & _SENT:
                self._be_sent(node, wire, node.mailboxes.sent(wire.sent_slot(index)), now_ns)
            if what & _HEARD:
                frame = CanFrame(*wire.heard(index))
                if node.wants(frame):
                    node.stats.heard += 1
                    node.listener.hear(frame, SimTimeNs(wire.started_ns(index)), now_ns)
            if what & _CHANGED:
                self.note_state(node, wire, now_ns)

    def note_state(self, node: BusNode, wire: BitWire, now_ns: SimTimeNs) -> None:
        """Report a node's state if it has changed."""
        if node.note_state(wire, now_ns):
            for watcher in self.watchers:
                watcher(BusEvent(now_ns, now_ns, node.name, state=node.state.value))

    def _tell_frame(self, wire: BitWire, sender: BusNode, now_ns: SimTimeNs) -> None:
        """Report a frame that one node has sent and the others have received."""
        frame = sender.mailboxes.sent(wire.sent_slot(sender.index))
        start_ns = SimTimeNs(wire.started_ns(sender.index))
        for node in self._nodes.wanting(frame):
            if wire.has_heard(node.index):
                node.stats.heard += 1
                node.listener.hear(frame, start_ns, now_ns)
        self._be_sent(sender, wire, frame, now_ns)

    def _be_sent(self, node: BusNode, wire: BitWire, frame: CanFrame, now_ns: SimTimeNs) -> None:
        start_ns = SimTimeNs(wire.started_ns(node.index))
        self.frames += 1
        node.stats.sent += 1
        self._offer(node)
        for watcher in self.watchers:
            watcher(BusEvent(start_ns, now_ns, node.name, frame))
        node.listener.sent(frame, start_ns, now_ns)

    def _tell_error(self, node: BusNode, wire: BitWire, error: int, now_ns: SimTimeNs, is_new: bool) -> None:
        kind = ERRORS[error]
        node.stats.errors[kind] = node.stats.errors.get(kind, 0) + 1
        if is_new:
            self.errors[kind] = self.errors.get(kind, 0) + 1
        for watcher in self.watchers:
            watcher(BusEvent(SimTimeNs(wire.started_ns(node.index)), now_ns, node.name, error=kind))
