"""Profile velocity mode: a target speed, reached by ramps."""

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.operating_mode import IDLE_NS, WATCH_NS, OperatingMode, TimeWindow
from bridges.can.canopen.cia402_words import STANDS, TARGET_REACHED
from hil.vocab.path import DEG_PER_S


class ProfileVelocity(OperatingMode):
    """Mode 3. A software limit ahead ends the motion at the limit."""

    targets = (0x60FF, 0x6083, 0x6084)

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._asked = 0.0
        self._is_reached = False
        self._stands = True
        self._reached, self._turning = TimeWindow(), TimeWindow()

    @property
    def watch_ns(self) -> int:
        is_at_rest = self._is_reached and not self._asked
        return IDLE_NS if is_at_rest else WATCH_NS

    def begin(self, word: int, now_ns: int) -> None:
        self.is_halted = False
        self._reached.clear()
        self._turning.clear()
        self._stands = True
        super().control(word, 0, now_ns)
        if not self.is_halted:
            self.go_on(now_ns)

    def written(self, index: int, now_ns: int) -> None:
        if not self.is_halted:
            self.go_on(now_ns)

    def go_on(self, now_ns: int) -> None:
        context = self.context
        rate = context.value(0x60FF) * context.units.deg_per_s
        rules = context.rules(abs(rate))
        rate = rules.speed if rate > 0 else -rules.speed
        context.is_limited = context.is_blocked(rate, now_ns)
        bound_deg = context.bound_ahead_deg(rate)
        if bound_deg is not None and (bound_deg - context.mover.where(now_ns).deg) * rate <= 0:
            context.is_limited = True
        self._asked = 0.0 if context.is_limited else rate
        self._is_reached = False
        self._reached.clear()
        context.mover.turn(self._asked, rules, now_ns, bound_deg if self._asked else None)
        context.forget()

    def halt(self, now_ns: int) -> None:
        super().halt(now_ns)
        self._asked, self._is_reached = 0.0, False
        self._reached.clear()

    def block(self, now_ns: int) -> None:
        super().block(now_ns)
        self._asked, self._is_reached = 0.0, False

    def step(self, now_ns: int) -> None:
        context = self.context
        speed = context.look(now_ns).velocity_rpm * DEG_PER_S
        if self._asked and context.bound_ahead_deg(self._asked) is not None:
            context.is_limited = context.mover.is_over(now_ns)
        unit = abs(context.units.deg_per_s)
        is_near = abs(speed - self._asked) <= context.value(0x606D) * unit
        self._is_reached = self._reached.holds(is_near, context.ms(0x606E), now_ns)
        is_fast = abs(speed) > context.value(0x606F) * unit
        self._stands = not self._turning.holds(is_fast, context.ms(0x6070), now_ns)

    def status(self, now_ns: int) -> int:
        return (TARGET_REACHED if self._is_reached else 0) | (STANDS if self._stands else 0)
