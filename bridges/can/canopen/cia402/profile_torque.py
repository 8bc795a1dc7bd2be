"""Profile torque mode: a target torque, reached with a slope."""

from math import copysign

from bridges.can.canopen.cia402.drive_context import DriveContext
from bridges.can.canopen.cia402.operating_mode import WATCH_NS, OperatingMode
from bridges.can.canopen.cia402_words import TARGET_REACHED
from hil.vocab.path import DEG_PER_S
from hil.vocab.time import FOREVER, NS_PER_S


class ProfileTorque(OperatingMode):
    """Mode 4. The torque changes in steps of a millisecond."""

    targets = (0x6071, 0x6072)
    checks_position = False

    def __init__(self, context: DriveContext) -> None:
        super().__init__(context)
        self._at_ns = 0
        self._is_reached = False

    def begin(self, word: int, now_ns: int) -> None:
        self.is_halted = False
        self.context.torque_demand = 0.0
        self._at_ns = now_ns
        self._give(0.0)
        self.due_ns = FOREVER
        super().control(word, 0, now_ns)
        self._change(now_ns)

    def written(self, index: int, now_ns: int) -> None:
        self._change(now_ns)

    def halt(self, now_ns: int) -> None:
        self._change(now_ns)

    def go_on(self, now_ns: int) -> None:
        self._change(now_ns)

    def _change(self, now_ns: int) -> None:
        if self.due_ns == FOREVER:
            self._at_ns, self.due_ns = now_ns, now_ns + WATCH_NS
        self._is_reached = False

    def stop(self, option: int, now_ns: int) -> None:
        """Stop the shaft from the speed that it has."""
        self.end(now_ns)
        super().stop(option, now_ns)

    def end(self, now_ns: int) -> None:
        self._give(0.0)
        look = self.context.look(now_ns)
        self.context.mover.begin(look, look.velocity_rpm * DEG_PER_S)
        self.due_ns = FOREVER

    def block(self, now_ns: int) -> None:
        """Make no torque towards the limit switch."""
        self._give(0.0)

    def step(self, now_ns: int) -> None:
        context = self.context
        target, demand = self._target(now_ns), context.torque_demand
        most = context.value(0x6087) * (now_ns - self._at_ns) / NS_PER_S
        self._at_ns = now_ns
        if target != demand:
            change = target - demand
            self._give(target if abs(change) <= most else demand + copysign(most, change))
        self._is_reached = context.torque_demand == target
        self.due_ns = FOREVER if self._is_reached else now_ns + WATCH_NS

    def _target(self, now_ns: int) -> float:
        """Torque that is wanted, in thousandths, within its limits."""
        context = self.context
        asked = 0 if self.is_halted else context.value(0x6071)
        most = context.value(0x6072)
        limited = max(-most, min(most, asked))
        is_ahead = context.is_blocked(limited, now_ns) or self._is_beyond(limited, now_ns)
        context.is_limited = limited != asked or is_ahead
        return 0.0 if is_ahead else float(limited)

    def _is_beyond(self, torque: float, now_ns: int) -> bool:
        bound_deg = self.context.bound_ahead_deg(torque) if torque else None
        return bound_deg is not None and (bound_deg - self.context.look(now_ns).position_deg) * torque <= 0

    def _give(self, demand: float) -> None:
        context = self.context
        context.torque_demand = demand
        context.axis.torque(demand / 1000 * context.axis.rated_current_A)
        context.forget()

    def status(self, now_ns: int) -> int:
        return TARGET_REACHED if self._is_reached else 0
