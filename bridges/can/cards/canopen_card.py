"""A CANopen node of a bench: the interface card of an axis, on a bus in its board's time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from bridges.can.bus.bus_events import CanFilter, MailboxesFull, NodeState
from bridges.can.canopen.node.application import Application
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.communication_entries import Identity
from bridges.can.canopen.node.eds import eds_text
from bridges.can.cards.bench_bus import BenchBus
from bridges.can.frames.can_frame import STANDARD_ID_MAX, CanFrame
from bridges.can.frames.slcan import encode
from hil.sim.firmware_guard import place_of
from hil.sim.twin import Twin
from hil.vocab.time import FOREVER, Clock, SimTimeNs

MAILBOXES = 256
"""Frames that may wait: a block of SDO has 127, and what is more urgent goes before."""


@dataclass(frozen=True)
class CardSpec:
    """Node that a card is. ``section``: name of what it keeps in its board's memory."""

    node_id: int
    make_application: Callable[[CanOpenNode], Application]
    identity: Identity
    section: str


class CanOpenCard:
    """Node ``name`` on a bus. Its board powers it: it is silent while the board is off, and boots with
    each power-up.

    The node is asked only when a frame that it wants has come, or when it is due.
    """

    def __init__(self, name: str, of: BenchBus, device: Twin, clock: Clock, spec: CardSpec) -> None:
        self.name, self.wire, self.device = name, of, device
        self.faults = None
        self.listeners: list[Callable[[SimTimeNs, bytes], None]] = []
        """Called with each frame that it gives to its controller, as text of slcan."""
        self.lost = 0
        """Number of frames for which no mailbox was free."""
        self._bus, self._clock, self._section = of.bus, clock, spec.section
        self._node_id, self._identity = spec.node_id, spec.identity
        self._has_begun = False
        """True once it was powered up."""
        self._has_raised = False
        """True if the node has raised an error: it is silent until the next power-up."""
        self._timer_ns: int = FOREVER
        """Earliest time at which the clock calls."""
        self.node = CanOpenNode(
            spec.node_id,
            of.bus.bit_rate,
            spec.make_application,
            spec.identity,
            self._send,
            kept=device.nvm.get(spec.section, b""),
            keep=self._keep,
            use_bit_rate=self._use_bit_rate,
        )
        self._ids: Sequence[int] = ()
        self._bus.join(name, self, filters=(), mailboxes=MAILBOXES, is_on=False)
        device.power.listeners.append(self._power)
        self._ups = device.power.ups
        # Not at once: faults of the configuration, which may take the power, come behind this.
        clock.at(clock.now_ns, self._start)

    @property
    def node_id(self) -> int:
        """Node id: the one in use, 255 if LSS has to give one; before the first boot, as configured."""
        return self.node.node_id if self._has_begun else self._node_id

    def counters(self) -> dict[str, Any]:
        """State and statistics, for JSON."""
        state = {"state": "failed"} if self._has_raised else {}
        return {"id": self.node_id, **self.node.counters(), **state, "lost": self.lost}

    def eds(self) -> str:
        """Write the node's electronic data sheet."""
        return eds_text(self.node.dictionary, self._identity, f"{self.device.profile}.eds")

    # ---- power ----

    def _start(self, now_ns: SimTimeNs) -> None:
        """Boot with the bench, unless a fault of the configuration has the power, or had it."""
        if self.device.power.is_there and self.device.power.ups == self._ups:
            self._power_up(now_ns)

    def _power(self, is_there: bool) -> None:
        self._bus.switch_off(self.name)
        self._timer_ns = FOREVER
        if is_there:
            self._power_up(self._clock.now_ns)
        else:
            self.node.power_off()

    def _power_up(self, now_ns: SimTimeNs) -> None:
        self._has_raised, self._has_begun = False, True
        self._bus.switch_on(self.name)
        self._do(self.node.power_up, now_ns)

    # ---- bridges.can.bus.bus_events.CanListener ----

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        if self._has_raised:
            return
        try:
            node = self.node
            node.hear(frame, end_ns)
            if node.due_ns < self._timer_ns or node.can_ids is not self._ids:  # asked here: mostly not
                self._plan(end_ns)
        except Exception as error:
            self._fail(error)

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Do nothing: a node does not ask."""

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        node = self.node
        told = {NodeState.BUS_OFF: node.bus_off, NodeState.PASSIVE: node.bus_passive}.get(state, node.bus_on)
        self._do(told, at_ns)

    # ---- the node ----

    def _do(self, call: Callable[[int], None], now_ns: SimTimeNs) -> None:
        if not self._has_raised:
            self._call(call, now_ns)

    def _call(self, call: Callable[[int], None], now_ns: SimTimeNs) -> None:
        try:
            call(now_ns)
            self._plan(now_ns)
        except Exception as error:  # what it acts on may be a board's own: nobody else stops for its mistake
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self._has_raised = True
        self.node.power_off()
        self.device.power.fail(f"its CANopen node: {type(error).__name__}: {error}{place_of(error)}")

    def _plan(self, now_ns: int) -> None:
        """Be there when the node is due, and hear what it wants."""
        due_ns = self.node.due_ns
        if due_ns < self._timer_ns:
            self._timer_ns = max(due_ns, now_ns)
            self._clock.at(self._timer_ns, self._due)
        if self.node.can_ids is not self._ids:
            self._ids = self.node.can_ids
            self._bus.set_filters(self.name, [CanFilter(each, STANDARD_ID_MAX) for each in self._ids])

    def _due(self, now_ns: SimTimeNs) -> None:
        if now_ns != self._timer_ns:
            return  # an earlier time was asked for since, or the power went
        self._timer_ns = FOREVER
        if self._has_raised:
            return
        if self.node.due_ns > now_ns:
            self._plan(now_ns)  # what was due has been put off, as by each SYNC
        else:
            self._call(self.node.step, now_ns)

    # ---- what the node does ----

    def _send(self, frame: CanFrame) -> None:
        for listener in self.listeners:
            listener(self._clock.now_ns, encode(frame))
        try:
            self._bus.send(self.name, frame)
        except MailboxesFull:
            self.lost += 1

    def _use_bit_rate(self, bit_rate: int) -> None:
        self._bus.switch_on(self.name, bit_rate)

    def _keep(self, section: bytes, stored: Callable[[bool, int], None]) -> None:
        def ended(durable: bool) -> None:
            self._call(partial(stored, durable), self._clock.now_ns)  # also if it has raised: it has a memory

        self.device.keep(self._section, section, ended)
