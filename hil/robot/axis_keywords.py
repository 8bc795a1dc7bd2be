"""Keywords of time, of axes and of packets."""

from datetime import timedelta

from robot.api import Failure

from hil.operations.table import OPERATIONS
from hil.robot.bench_kind import AtBench, refusals
from hil.testing.waiting import state_test

_SECOND = timedelta(seconds=1)
LOOK_S = 0.001
"""Simulated time between two looks at an axis."""


class AxisKeywords(AtBench):
    """Keywords of time, axes and packets."""

    def pass_time(self, duration: timedelta) -> None:
        """Let simulated time pass.

        | Pass Time    200 ms
        """
        self._kind.pass_time(duration.total_seconds())

    def simulated_time(self) -> float:
        """Answer the seconds of simulated time since the bench's start, which is before the boards answer."""
        return self._kind.now_s

    def field_should_be(self, axis: str, field: str, value: float, tolerance: float = 0.0) -> None:
        """Compare a field of an axis with a value, now.

        | Field Should Be    m1    position_deg    90    tolerance=0.5
        """
        is_value = self._field(axis, field)
        if not _is_near(is_value, value, tolerance):
            raise Failure(f"{axis}: {field} is {is_value:g}, not {value:g} within {tolerance:g}")

    def axis_should_reach(
        self,
        axis: str,
        value: float,
        within: timedelta = _SECOND,
        tolerance: float = 0.5,
        field: str = "position_deg",
    ) -> None:
        """Wait until the angle of an axis, or another field, is near a value.

        No time passes after that: use `Pass Time` and `Field Should Be` for an axis that stays there.

        | Do Verb    m1    move_abs    position_deg=90
        | Axis Should Reach    m1    90    within=2 s    tolerance=0.1
        """
        end_s = self._kind.now_s + within.total_seconds()
        while not _is_near(is_value := self._field(axis, field), value, tolerance):
            if self._kind.now_s >= end_s:
                raise Failure(
                    f"{axis}: {field} is {is_value:g} after {within.total_seconds():g} s,"
                    f" not {value:g} within {tolerance:g}"
                )
            self._kind.pass_time(LOOK_S)

    def wait_until(self, axis: str, condition: str, within: timedelta = _SECOND) -> None:
        """Wait until a condition on fields of an axis, or of a board, holds, as `hil wait` does.

        No time passes after that.

        | Wait Until    m1    position_deg > 89 and loop_on == 1    within=2 s
        | Wait Until    r1    heater == 0
        """
        with refusals():
            holds = state_test(axis, condition)
            end_s = self._kind.now_s + within.total_seconds()
            while not holds(state := self._kind.ask(OPERATIONS["state"], axis, {})):
                if self._kind.now_s >= end_s:
                    told = ", ".join(f"{name} {value}" for name, value in state.items() if name in condition)
                    raise Failure(
                        f"{axis}: {condition} did not hold within {within.total_seconds():g} s; {told}"
                    )
                self._kind.pass_time(LOOK_S)

    def _field(self, axis: str, field: str) -> float:
        with refusals():
            state = self._kind.ask(OPERATIONS["state"], axis, {})
            if field not in state:
                raise ValueError(f"{axis} has no field {field!r}; there are {', '.join(state)}")
        return float("nan") if state[field] is None else float(state[field])

    def packets_should_be(self, segment: str, *packets: str) -> None:
        """Compare the packets on a segment since this keyword was used last, or since the boards answered.

        Each is as ``hil capture`` writes it.

        | Packets Should Be    bus0    4 -> 86 v    86 -> 4 ACK
        """
        with refusals():
            came = self._kind.packets(segment)
        if came != [*packets]:
            raise Failure("\n".join([f"{segment}: not these packets; what came:", *(came or ["nothing"])]))


def _is_near(value: float, wanted: float, tolerance: float) -> bool:
    return abs(value - wanted) <= tolerance
