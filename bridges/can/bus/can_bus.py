"""A CAN bus with nodes: bit times, arbitration, acknowledgement, errors and their confinement, and faults.

Pure: integer nanoseconds of simulated time come in as arguments. A frame that nothing disturbs is the unit of
work; where something does, bits are. Both give the same (``native``).

Not modelled: the cable's length (all see one level at a time), sample points and the tolerance of oscillators
(nodes of one rate are in step), CAN FD. A node that begins to listen, or comes back to the wire, waits for 11
recessive bits.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from bridges.can.bus._bit_wire import BitWire
from bridges.can.bus.bus_events import (
    MAILBOXES,
    BusEvent,
    CanFilter,
    CanListener,
    MailboxesFull,
    NodeState,
)
from bridges.can.bus.bus_nodes import BusNews, BusNode, BusNodes, Mailboxes
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import FOREVER, NS_PER_S, Clock, SimTimeNs


class BusLine:
    """Wire on a clock. ``tell(wire, now_ns)`` is called whenever something has happened on it."""

    def __init__(
        self,
        clock: Clock,
        rate: int,
        tell: Callable[[BitWire, SimTimeNs], None],
        beside: "BusLine | None" = None,
    ) -> None:
        self.wire: BitWire = BitWire(rate, beside.wire if beside else None)
        self._ahead = BitWire(rate, self.wire)
        self._clock = clock
        self._tell = tell
        self._next_ns: int = FOREVER
        """Time of what happens next, as far as is known."""
        self._is_telling = False
        self._waiting: dict[BusNode, None] = {}
        """Nodes whose next frame has changed since it could matter."""

    def offer(self, loader: BusNode) -> None:
        """Have a controller's next frame loaded: now, or when the frame on the wire is over."""
        if self._is_telling:
            self._waiting[loader] = None
            return
        now_ns = self._clock.now_ns
        # Nothing can come of it before the frame on the wire has ended: a look ahead would be for nothing.
        if self._next_ns < FOREVER and now_ns > self._ahead.decided_ns:
            self._waiting[loader] = None
            return
        wire = self.wire
        wire.advance(now_ns)
        wire.wake(now_ns)
        loader.load(wire)
        self._look_ahead()

    @contextmanager
    def change(self) -> Iterator[BitWire]:
        """Let the wire be changed as it is now."""
        now_ns = self._clock.now_ns
        if self._next_ns == now_ns:  # what happens now comes first
            self._reach(now_ns)
        wire = self.now()
        wire.wake(now_ns)
        self._load()
        yield wire
        if not self._is_telling:
            self._look_ahead()

    def now(self) -> BitWire:
        """Answer the wire as it is now. To look at it changes nothing."""
        self.wire.advance(self._clock.now_ns)
        return self.wire

    def _load(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for loader in waiting:
            loader.load(self.wire)

    def _look_ahead(self) -> None:
        ahead = self._ahead
        ahead.copy(self.wire)
        at_ns = ahead.run()
        if at_ns < 0:
            self._next_ns = FOREVER
            return
        self._next_ns = at_ns
        self._clock.at(at_ns, self._reach)

    def _reach(self, now_ns: SimTimeNs) -> None:
        if now_ns != self._next_ns:  # something came before
            return
        # What was looked ahead at has come true; the other is room for the next look.
        self.wire, self._ahead = self._ahead, self.wire
        self._next_ns = FOREVER
        self._is_telling = True
        try:
            self._tell(self.wire, now_ns)
        finally:
            self._is_telling = False
        if self._waiting:
            self._load()
        self._look_ahead()


LEAST_BIT_RATE, MOST_BIT_RATE = 10_000, 1_000_000
"""Bits per second."""


class CanBus:
    """Bus at a rate in bits per second. All that happens here happens at times of ``clock``.

    Raises:
        ValueError: a rate beyond 10 kbit/s to 1 Mbit/s.

    Long because it is the face of the bus in C, one short method for each thing that can be done to it.
    """

    def __init__(self, clock: Clock, bit_rate: int) -> None:
        if not LEAST_BIT_RATE <= bit_rate <= MOST_BIT_RATE:
            raise ValueError(f"{bit_rate} bit/s; a bus has {LEAST_BIT_RATE} to {MOST_BIT_RATE}")
        self.bit_rate = bit_rate
        self.nodes = BusNodes()
        self.news = BusNews(self.nodes, lambda node: self.line_of(node.name).offer(node))
        self.switched_on: Callable[[BusNode], None] = lambda node: None
        """Called when a node has got power, with a controller that knows of no fault."""
        self._clock = clock
        self._main = BusLine(clock, bit_rate, self.news.tell)
        self._cut: dict[str, BusLine] = {}
        """Lines of the nodes that are cut off, each alone on its own."""

    # ---- nodes ----

    def join(
        self,
        name: str,
        listener: CanListener,
        *,
        filters: Sequence[CanFilter] | None = None,
        mailboxes: int = MAILBOXES,
        is_listening: bool = False,
        recovers: bool = True,
        is_on: bool = True,
    ) -> None:
        """Put a node on the bus. ``is_listening``: it never drives the wire, not even to acknowledge.
        ``recovers``: it comes back from bus-off by itself. ``is_on``: it has power (``switch_on``).

        Raises:
            ValueError: the name is taken, or there are 256 nodes.
        """
        index = self.nodes.free_index(name)
        node = BusNode(name, index, listener, Mailboxes(mailboxes), filters, is_listening, recovers, is_on)
        self.nodes.join(node)
        if is_on:
            with self._main.change() as wire:
                wire.add(node.index, is_listening, recovers)

    def leave(self, name: str) -> None:
        """Take a node off the bus, in the middle of a frame too."""
        node = self.nodes[name]
        node.mailboxes.clear()
        with self._cut.pop(name, self._main).change() as wire:
            wire.remove(node.index)
        self.nodes.leave(name)

    def set_filters(self, name: str, filters: Sequence[CanFilter] | None) -> None:
        self.nodes[name].filters = filters
        self.nodes.changed()

    def set_listening(self, name: str, is_listening: bool) -> None:
        """Set whether a node never drives the wire. What it has to send waits meanwhile, except a frame that
        is on the wire."""
        node = self.nodes[name]
        node.is_listening = is_listening
        with self.changed(name) as wire:
            wire.set_listening(node.index, is_listening)
            node.load(wire)

    def set_recovery(self, name: str, recovers: bool) -> None:
        """Set whether a node comes back from bus-off, as a driver asks for it."""
        self.nodes[name].recovers = recovers
        with self.changed(name) as wire:
            wire.set_recovery(self.nodes[name].index, recovers)

    def switch_on(self, name: str, bit_rate: int = 0) -> None:
        """Start a node's controller again, with its error counters at 0; then it waits for 11 recessive bits.
        ``bit_rate``: its own, in bits per second; 0: the bus's."""
        node = self.nodes[name]
        node.is_on, node.bit_rate, node.state = True, bit_rate, NodeState.ACTIVE
        with self.changed(name) as wire:
            wire.remove(node.index)
            wire.add(node.index, node.is_listening, node.recovers)
            if bit_rate not in (0, self.bit_rate):
                wire.set_rate(node.index, bit_rate)
        self.switched_on(node)

    def switch_off(self, name: str) -> None:
        """Take the power from a node's controller, in the middle of a frame too: what it has to send is lost,
        and it neither hears nor acknowledges."""
        node = self.nodes[name]
        node.is_on = False
        node.mailboxes.clear()
        with self.changed(name) as wire:
            wire.remove(node.index)

    def send(self, name: str, frame: CanFrame) -> None:
        """Send a frame from a node when the bus lets it, again and again until somebody acknowledges it.

        Raises:
            MailboxesFull: too many wait already.
            ValueError: the frame cannot be sent.
        """
        node = self.nodes[name]
        try:
            is_first = node.mailboxes.put(frame)
        except MailboxesFull:
            node.stats.refused += 1
            raise
        if is_first:
            (self._cut.get(name, self._main) if self._cut else self._main).offer(node)

    def drop(self, name: str) -> None:
        """Drop all frames of a node that wait; one that is on the wire goes on, once."""
        node = self.nodes[name]
        node.mailboxes.clear()
        self.line_of(name).offer(node)

    # ---- what it counts ----

    @property
    def watchers(self) -> list[Callable[[BusEvent], None]]:
        """Callables that are told of all that happens."""
        return self.news.watchers

    @property
    def frames(self) -> int:
        """Number of frames that were sent."""
        return self.news.frames

    @property
    def errors(self) -> Mapping[str, int]:
        """Errors by kind, each once for a bit, however many have found it."""
        return self.news.errors

    def state(self, name: str) -> NodeState:
        return self.nodes[name].state_in(self.line_of(name).now())

    def free_mailboxes(self, name: str) -> int:
        """Number of frames that a node may give to its controller now."""
        mailboxes = self.nodes[name].mailboxes
        return mailboxes.size - len(mailboxes)

    def waiting(self, name: str) -> int:
        """Number of frames of a node that are not sent yet."""
        return len(self.nodes[name].mailboxes)

    def tally(self, name: str) -> tuple[int, int]:
        """Number of errors that a node has found, and how often it has given way to a more urgent frame."""
        node = self.nodes[name]
        lost = self.line_of(name).now().look(node.index)[3]
        return sum(node.stats.errors.values()), lost

    def error_counters(self, name: str) -> tuple[int, int]:
        """Transmit and receive error counter of a node."""
        _, transmit_errors, receive_errors, _ = self.line_of(name).now().look(self.nodes[name].index)
        return transmit_errors, receive_errors

    def busy_ns(self) -> int:
        """Time in which the wire was not free, the three bits behind each frame with it."""
        wire = self._main.now()
        held_ns = self._clock.now_ns - wire.now_ns if wire.is_held else 0
        return wire.busy_bits * NS_PER_S // self.bit_rate + held_ns

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""
        return {
            "load_percent": 100 * self.busy_ns() / elapsed_ns if elapsed_ns > 0 else 0.0,
            "frames": self.frames,
            "errors": dict(self.errors),
            "nodes": {name: node.counters(self.line_of(name).now()) for name, node in self.nodes.items()},
        }

    # ---- for faults (can_faults.py) ----

    def line_of(self, name: str) -> BusLine:
        return self._cut.get(name, self._main)

    @property
    def main_line(self) -> BusLine:
        return self._main

    @property
    def clock(self) -> Clock:
        return self._clock

    def changed(self, name: str) -> AbstractContextManager[BitWire]:
        """Let the wire that a node is on be changed."""
        return self.line_of(name).change()

    def set_cut(self, name: str, is_cut: bool) -> None:
        """Cut the wire to a node, which goes on alone; or join it again."""
        if is_cut == (name in self._cut):
            return
        index = self.nodes[name].index
        if is_cut:
            line = self._cut[name] = BusLine(self._clock, self.bit_rate, self.news.tell, self._main)
            with self._main.change() as main, line.change() as own:
                own.take_over(main, index, True)
                main.remove(index)
            return
        line = self._cut.pop(name)
        with self._main.change() as main, line.change() as own:
            main.take_over(own, index, False)
            own.remove(index)
            # To take a controller over starts it, and this one has no power.
            if not self.nodes[name].is_on:
                main.remove(index)
