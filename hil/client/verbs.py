# mypy: disable-error-code="empty-body"
"""The verbs of devices as methods, for both kinds of client. Units and limits: ``hil axis DEVICE``."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, Generic, Literal, TypeVar

MOTION_S = 600.0
"""Maximum wait of ``wait=True``."""
Answer_co = TypeVar("Answer_co", covariant=True)
Stop = Literal["grace", "prejudice"]
Direction = Literal["cw", "ccw"]
Verbs = TypeVar("Verbs")


def _verb(method: Callable[..., Any]) -> Callable[..., Any]:
    """Make a method that asks for the verb of its name with what was given; None stands for the rest."""
    signature = inspect.signature(method)
    more = [name for name, each in signature.parameters.items() if each.kind is each.VAR_KEYWORD]

    @wraps(method)
    def ask(self: "AxisVerbs[Any]", *values: Any, **named: Any) -> Any:
        bound = signature.bind(self, *values, **named)
        bound.apply_defaults()
        _, *given = bound.arguments.items()
        parameters = {name: value for name, value in given if name not in more and value is not None}
        for name in more:
            parameters |= bound.arguments[name]
        return self.do(method.__name__, wait=parameters.pop("wait", False), **parameters)

    return ask


def _asking(cls: type[Verbs]) -> type[Verbs]:
    for name, method in list(vars(cls).items()):
        if name != "do" and not name.startswith("_"):
            setattr(cls, name, _verb(method))
    return cls


@_asking
class AxisVerbs(Generic[Answer_co]):
    """Verbs as methods. A board refuses those that its table does not have."""

    def do(self, verb: str, *, wait: bool = False, timeout_s: float = MOTION_S, **given: object) -> Answer_co:
        """Carry out a verb by its name; ``wait``: until the motion that it begins has ended."""
        raise NotImplementedError

    def position(self, position_deg: float) -> Answer_co: ...
    def velocity(self, velocity_rpm: float) -> Answer_co: ...
    def torque(self, effort_count: float) -> Answer_co: ...
    def mode(self, mode: Literal["position", "velocity", "torque", "hybrid"]) -> Answer_co: ...
    def enable(self) -> Answer_co: ...
    def disable(self) -> Answer_co: ...
    def gains(self, **gains: float) -> Answer_co: ...
    def calibrate(self) -> Answer_co: ...

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
        """Move to a position: ``acceleration_rpm_per_s`` is a Mechaduino's, ``acceleration`` and
        ``deceleration`` are a SAC's."""

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
        """Move by an angle, as ``move_abs``."""

    def stop(self, how: Stop = "grace", *, wait: bool = False) -> Answer_co: ...
    def pulses(self, count: int, rate_Hz: float | None = None, direction: str | None = None) -> Answer_co: ...
    def queue(
        self, position: int, steps: int, velocity_rpm: int | None = None, **attributes: float
    ) -> Answer_co: ...
    def loop(self, first: int, last: int, passes: int = 1, *, wait: bool = False) -> Answer_co: ...
    def sync(self) -> Answer_co: ...
    def run(self, position: int, *, wait: bool = False) -> Answer_co: ...
    def pulse(self, direction: Direction = "cw") -> Answer_co: ...
    def pin(self, pin: str, level: int) -> Answer_co: ...

    def type(self, text: str) -> Answer_co:
        r"""Type at the board's serial interface; ``\r`` and ``\xHH`` may be written with a backslash."""

    def reset(self) -> Answer_co: ...

    def zero(self) -> Answer_co:
        """Let the shaft's angle, ``position_deg``, be 0 here: nothing turns, and the board knows nothing of
        it."""
