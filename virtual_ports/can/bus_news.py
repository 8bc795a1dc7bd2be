"""News of a CAN bus: what its wires say has happened, told to nodes and watchers, and counted."""

from collections.abc import Callable

from hil.vocab.time import SimTimeNs
from hil.wire.can.can_bus_protocol import BusEvent
from hil.wire.can.can_frame import CanFrame
from virtual_ports.can._bit_wire import BitWire
from virtual_ports.can.bus_node import BusNode
from virtual_ports.can.bus_nodes import BusNodes

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
