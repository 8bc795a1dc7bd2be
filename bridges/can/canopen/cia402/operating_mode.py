"""Contract between a drive's state machine and its modes of operation, and what modes wait for."""

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402_words import HALT
from hil.vocab.time import FOREVER

WATCH_NS, IDLE_NS = 1_000_000, 10_000_000
"""Time from one look at the axis to the next: in motion, and at rest."""
AT_ONCE = 3
"""Option code: stop at once."""


class OperatingMode:
    """Mode of operation. It is told of what is written only while operation is enabled and it is in force;
    what moves the axis raises ``VerbRefused``. ``targets``: objects of which each write counts."""

    targets: tuple[int, ...] = ()
    checks_position = True
    """True if the shaft has to be near the set-point."""
    obeys_limits = True
    """True if a limit switch stops it; if not, it looks after them itself."""

    def __init__(self, context: DriveContext) -> None:
        self.context = context
        self.is_halted = False
        self.due_ns: int = FOREVER
        """Next exact time at which it wants ``step``."""

    @property
    def watch_ns(self) -> int:
        """Time until the axis has to be looked at again."""
        return WATCH_NS

    def begin(self, word: int, now_ns: int) -> None:
        """Begin where the axis is. ``word``: the controlword."""

    def control(self, word: int, before: int, now_ns: int) -> None:
        """Take a controlword after another one."""
        if (word ^ before) & HALT:
            self.is_halted = bool(word & HALT)
            if self.is_halted:
                self.halt(now_ns)
            else:
                self.go_on(now_ns)

    def halt(self, now_ns: int) -> None:
        """Come to rest by the halt option code."""
        self.stop(self.context.value(0x605D), now_ns)

    def stop(self, option: int, now_ns: int) -> None:
        """Come to rest: 1 by the mode's ramp, 2 by the quick one, 3 at once."""
        context = self.context
        context.mover.stop(self.ramp(is_quick=option != 1), now_ns, at_once=option == AT_ONCE)
        context.forget()

    def ramp(self, *, is_quick: bool) -> float:
        """Deceleration of a stop, deg/s2."""
        return self.context.ramp(is_quick=is_quick)

    def go_on(self, now_ns: int) -> None:
        """Go on after a halt."""

    def written(self, index: int, now_ns: int) -> None:
        """Take one of ``targets``, which has its new value."""

    def synced(self, now_ns: int) -> None:
        """Take the targets of a SYNC."""

    def step(self, now_ns: int) -> None:
        """Do what is due, and look at the axis."""

    def block(self, now_ns: int) -> None:
        """Come to rest: a limit switch ahead is active."""
        self.stop(2, now_ns)

    def end(self, now_ns: int) -> None:
        """Leave the axis to another mode."""

    def status(self, now_ns: int) -> int:
        """Bits 10, 12 and 13 of the statusword."""
        return 0


class TimeWindow:
    """Condition that counts once it has held for a time."""

    def __init__(self) -> None:
        self._since_ns: int | None = None

    def holds(self, is_so: bool, for_ns: int, now_ns: int) -> bool:
        """Take in whether it is so now; answers True if it has been for so long."""
        if not is_so:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns >= for_ns

    def assume(self) -> None:
        """Take it that it has been so forever."""
        self._since_ns = -FOREVER

    def clear(self) -> None:
        """Begin again."""
        self._since_ns = None
