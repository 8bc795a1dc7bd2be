"""A CANopen node of a bench: the interface card of an axis, on a bus in its board's time."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from hil.sim.can.bench_bus import BenchBus
from hil.sim.device import Device
from hil.sim.raised_at import place_of
from hil.vocab.time import FOREVER, Clock, SimTimeNs
from hil.wire.can.can_bus_protocol import CanFilter, MailboxesFull, NodeState
from hil.wire.can.can_frame import STANDARD_ID_MAX, CanFrame
from hil.wire.can.slcan import encode


class CardNode(Protocol):
    """What a card runs: a CANopen node, which knows no axis and no bus."""

    node_id: int

    @property
    def can_ids(self) -> Sequence[int]:
        """Identifiers that it wants to hear."""

    @property
    def due_ns(self) -> int:
        """Next time at which it wants ``step``; FOREVER if none."""

    def hear(self, frame: CanFrame, now_ns: int) -> None:
        """Take a frame."""

    def step(self, now_ns: int) -> None:
        """Do what is due."""

    def power_up(self, now_ns: int) -> None:
        """Begin, as with power."""

    def bus_off(self, now_ns: int) -> None:
        """Note that its controller is bus-off."""

    def bus_on(self, now_ns: int) -> None:
        """Note that its controller has come back from bus-off."""

    def counters(self) -> dict[str, Any]:
        """State and statistics, for JSON."""


MakeNode = Callable[[Callable[[CanFrame], None]], CardNode]
"""Makes a node that sends by a call."""


class CanOpenCard:
    """Node ``name`` on a bus. It has its power from its board: without it it is silent, and with each
    power-up it boots.

    The node is asked only when a frame that it wants has come, or when it is due.
    """

    def __init__(self, name: str, of: BenchBus, device: Device, clock: Clock, make: MakeNode) -> None:
        self.name, self.of, self.device = name, of, device
        self.listeners: list[Callable[[SimTimeNs, bytes], None]] = []
        """Called with each frame that it gives to its controller, as text of slcan."""
        self._bus, self._clock = of.bus, clock
        self._seen: Counter[str] = Counter()
        self._has_raised = False
        """True if the node has raised an error: it is silent until the next power-up."""
        self._timer_ns: int = FOREVER
        """Earliest time at which the clock calls."""
        self._node = make(self._send)
        self._ids: Sequence[int] = ()
        self._bus.join(name, self, filters=(), is_on=False)
        device.power.listeners.append(self._power)
        if device.power.is_there:
            clock.at(clock.now_ns, self._power_up)

    def counters(self) -> dict[str, Any]:
        """State and statistics, for JSON."""
        return {"id": self._node.node_id, **self._node.counters(), "lost": self._seen["lost"]}

    # ---- power ----

    def _power(self, is_there: bool) -> None:
        self._bus.switch_off(self.name)
        self._timer_ns = FOREVER
        if is_there:
            self._power_up(self._clock.now_ns)

    def _power_up(self, now_ns: SimTimeNs) -> None:
        self._has_raised = False
        self._bus.switch_on(self.name)
        self._do(self._node.power_up, now_ns)

    # ---- hil.wire.can.can_bus_protocol.CanListener ----

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        if not self._has_raised:
            try:
                self._node.hear(frame, end_ns)
                self._plan()
            except Exception as error:
                self._fail(error)

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Do nothing: a node does not ask."""

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        if state is NodeState.BUS_OFF:
            self._do(self._node.bus_off, at_ns)
        elif state is NodeState.ACTIVE:
            self._do(self._node.bus_on, at_ns)

    # ---- the node ----

    def _do(self, call: Callable[[int], None], now_ns: SimTimeNs) -> None:
        if self._has_raised:
            return
        try:
            call(now_ns)
            self._plan()
        except Exception as error:  # what it acts on may be a board's own: nobody else stops for its mistake
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self._has_raised = True
        self.device.power.fail(f"its CANopen node: {type(error).__name__}: {error}{place_of(error)}")

    def _plan(self) -> None:
        """Be there when the node is due, and hear what it wants."""
        due_ns = self._node.due_ns
        if due_ns < self._timer_ns:
            self._timer_ns = due_ns
            self._clock.at(due_ns, self._due)
        ids = self._node.can_ids
        if ids is not self._ids:
            self._ids = ids
            self._bus.set_filters(self.name, [CanFilter(each, STANDARD_ID_MAX) for each in ids])

    def _due(self, now_ns: SimTimeNs) -> None:
        if now_ns != self._timer_ns:
            return  # an earlier time was asked for since, or the power went
        self._timer_ns = FOREVER
        if self._node.due_ns <= now_ns:
            self._do(self._node.step, now_ns)
        else:
            self._plan()

    def _send(self, frame: CanFrame) -> None:
        for listener in self.listeners:
            listener(self._clock.now_ns, encode(frame))
        try:
            self._bus.send(self.name, frame)
        except MailboxesFull:
            self._seen["lost"] += 1
