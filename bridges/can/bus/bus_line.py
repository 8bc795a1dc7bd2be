"""Bits of a CAN wire, joined to the time of a clock.

The wire is known up to the last time at which something happened. The line looks ahead for what comes next if
nobody does anything; that becomes true at its time. A caller that does something before takes the wire to
that time first, and the line looks ahead again.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bridges.can.bus._bit_wire import BitWire
from bridges.can.bus.bus_nodes import BusNode
from hil.vocab.time import FOREVER, Clock, SimTimeNs


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
        """Those whose next frame has changed since it could matter."""

    def offer(self, loader: BusNode) -> None:
        """Have a controller's next frame loaded: now, or when the frame on the wire is over."""
        now_ns = self._clock.now_ns
        if self._is_telling or (self._next_ns < FOREVER and now_ns > self._ahead.decided_ns):
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
