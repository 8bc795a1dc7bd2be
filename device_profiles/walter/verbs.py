"""Verbs of the arm: what can be asked of it beside typing at its command port.

They act in the firmware at once, as its own MOVETO does, and send nothing over the UART. Who wants the whole
way a program takes types ``MOVETO`` (``hil monitor``, the verb ``type``, a serial program).
"""

from collections.abc import Mapping

from device_profiles.walter.arm_parts import PARTS, STEPPERS
from device_profiles.walter.firmware import Cortex
from device_profiles.walter.float32 import f32
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import HOW_TO_STOP, Effect, Role, Verb, VerbRefused

_NUMBERS = {part.name: part.number for part in PARTS}
_MOST_DEG, _LEAST_MS, _MOST_MS = 360.0, 20, 9999
_DEG_PER_S_OF_RPM = 6.0


def _check_can_move(cortex: Cortex, axis: str) -> int:
    number = _NUMBERS[axis]
    if not cortex.is_started:
        raise VerbRefused("not_now", "it is still setting itself up")
    if not cortex.controller.is_powered and number < len(STEPPERS):
        raise VerbRefused("not_now", "the motors have no power; type POWER on and ENABLE")
    return number


def move_to(cortex: Cortex, axis: str, position_deg: float, duration_ms: float) -> Mapping[str, float]:
    """Let a joint go to an angle within a time, as MOVETO does for all."""
    number = _check_can_move(cortex, axis)
    cortex.controller.move(number, f32(position_deg), round(duration_ms))
    return {"set_point": cortex.controller.cut(number, position_deg), "ends_after_ns": duration_ms * 1e6}


def move_abs(cortex: Cortex, axis: str, position_deg: float, velocity_rpm: float) -> Mapping[str, float]:
    """Let a joint go to an angle at a speed, as one ramp of MOVETO."""
    number = _check_can_move(cortex, axis)
    way_deg = abs(cortex.controller.cut(number, position_deg) - cortex.controller.to_be_deg(number))
    duration_ms = max(_LEAST_MS, min(_MOST_MS, way_deg / (velocity_rpm * _DEG_PER_S_OF_RPM) * 1000))
    return move_to(cortex, axis, position_deg, duration_ms)


def position(cortex: Cortex, axis: str, position_deg: float) -> Mapping[str, float]:
    """Let a joint go to an angle within a tenth of a second, one set-point of a stream."""
    return move_to(cortex, axis, position_deg, 100.0)


def stop(cortex: Cortex, axis: str, how: str) -> None:
    """Stop a joint where its ramp is now; the board knows no ramp down."""
    number = _NUMBERS[axis]
    cortex.controller.move(number, cortex.controller.to_be_deg(number), _LEAST_MS)


def starve(cortex: Cortex, policy: str, acceleration_rpm_per_s: float, axis: str) -> None:
    """Stop a joint whose set-points have ended."""
    stop(cortex, axis, "grace")


def lights(cortex: Cortex) -> Mapping[str, int]:
    return cortex.light_levels()


_ANGLE = Parameter("position_deg", "where to", "deg", -_MOST_DEG, _MOST_DEG)
VERBS = (
    Verb(
        "move_to",
        "go to an angle within a time, within the limits, as MOVETO does",
        (
            _ANGLE,
            Parameter("duration_ms", "how long it takes", "ms", _LEAST_MS, _MOST_MS, 1000.0, is_whole=True),
        ),
        move_to,
        Effect.ENDS,
        is_of_axis=True,
    ),
    Verb(
        "move_abs",
        "go to an angle at a speed, within the limits; a ramp takes 10 s at most",
        (_ANGLE, Parameter("velocity_rpm", "how fast the joint turns", "rpm", 0.01, 40.0, 5.0)),
        move_abs,
        Effect.ENDS,
        is_of_axis=True,
    ),
    Verb(
        "position",
        "go to an angle within 100 ms: one set-point of a stream of ten a second",
        (_ANGLE,),
        position,
        Effect.STREAM,
        is_of_axis=True,
    ),
    Verb("stop", "stop where the ramp is now", (HOW_TO_STOP,), stop, Effect.ENDS, is_of_axis=True),
    Verb("lights", "tell the LED and the channels of the light driver", run=lights, role=Role.VIEWER),
)
