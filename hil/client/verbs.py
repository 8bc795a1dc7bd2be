"""The verbs of devices as methods, for both kinds of client. Units and limits: ``hil axis DEVICE``."""

from typing import Any, Generic, Literal, TypeVar

MOTION_S = 600.0
"""How long ``wait=True`` waits."""
Answer_co = TypeVar("Answer_co", covariant=True)
Stop = Literal["grace", "prejudice"]


class AxisVerbs(Generic[Answer_co]):
    """What a board can do is in its table; a method that a board has no verb for is refused there."""

    def do(self, verb: str, *, wait: bool = False, timeout_s: float = MOTION_S, **given: object) -> Answer_co:
        """Carry out a verb by its name; ``wait``: until the motion that it begins has ended."""
        raise NotImplementedError

    def _do(self, verb: str, wait: bool = False, /, **given: Any) -> Answer_co:
        return self.do(verb, wait=wait, **{name: value for name, value in given.items() if value is not None})

    def position(self, position_deg: float) -> Answer_co:
        return self._do("position", position_deg=position_deg)

    def velocity(self, velocity_rpm: float) -> Answer_co:
        return self._do("velocity", velocity_rpm=velocity_rpm)

    def torque(self, effort_count: float) -> Answer_co:
        return self._do("torque", effort_count=effort_count)

    def mode(self, mode: Literal["position", "velocity", "torque", "hybrid"]) -> Answer_co:
        return self._do("mode", mode=mode)

    def enable(self) -> Answer_co:
        return self._do("enable")

    def disable(self) -> Answer_co:
        return self._do("disable")

    def gains(self, **gains: float) -> Answer_co:
        return self._do("gains", False, **gains)

    def calibrate(self) -> Answer_co:
        return self._do("calibrate")

    def move_abs(
        self,
        position_deg: float,
        velocity_rpm: float | None = None,
        *,
        acceleration_rpm_per_s: float | None = None,
        acceleration: float | None = None,
        deceleration: float | None = None,
        wait: bool = False,
    ) -> Answer_co:
        """``acceleration_rpm_per_s`` is a Mechaduino's, ``acceleration`` and ``deceleration`` are a SAC's."""
        return self._do(
            "move_abs",
            wait,
            position_deg=position_deg,
            velocity_rpm=velocity_rpm,
            acceleration_rpm_per_s=acceleration_rpm_per_s,
            acceleration=acceleration,
            deceleration=deceleration,
        )

    def move_rel(
        self,
        angle_deg: float,
        velocity_rpm: float | None = None,
        *,
        acceleration_rpm_per_s: float | None = None,
        acceleration: float | None = None,
        deceleration: float | None = None,
        wait: bool = False,
    ) -> Answer_co:
        """As ``move_abs``."""
        return self._do(
            "move_rel",
            wait,
            angle_deg=angle_deg,
            velocity_rpm=velocity_rpm,
            acceleration_rpm_per_s=acceleration_rpm_per_s,
            acceleration=acceleration,
            deceleration=deceleration,
        )

    def stop(self, how: Stop = "grace", *, wait: bool = False) -> Answer_co:
        return self._do("stop", wait, how=how)

    def pulses(self, count: int, rate_Hz: float | None = None, direction: str | None = None) -> Answer_co:
        return self._do("pulses", count=count, rate_Hz=rate_Hz, direction=direction)

    def queue(
        self, position: int, steps: int, velocity_rpm: int | None = None, **attributes: float
    ) -> Answer_co:
        said = {"position": position, "steps": steps, "velocity_rpm": velocity_rpm, **attributes}
        return self._do("queue", False, **said)

    def loop(self, first: int, last: int, passes: int = 1, *, wait: bool = False) -> Answer_co:
        return self._do("loop", wait, first=first, last=last, passes=passes)

    def sync(self) -> Answer_co:
        return self._do("sync")

    def run(self, position: int, *, wait: bool = False) -> Answer_co:
        return self._do("run", wait, position=position)

    def pulse(self, direction: Literal["cw", "ccw"] = "cw") -> Answer_co:
        return self._do("pulse", direction=direction)

    def pin(self, pin: str, level: int) -> Answer_co:
        return self._do("pin", pin=pin, level=level)

    def type(self, text: str) -> Answer_co:
        r"""At the board's serial interface; ``\r`` and ``\xHH`` may be written with a backslash."""
        return self._do("type", text=text)

    def reset(self) -> Answer_co:
        return self._do("reset")
