"""Verbs of the arm's axes."""

from collections.abc import Mapping

from hil.firmware.set_point_paths import to_rest
from hil.vocab.parameters import Parameter
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.verbs import Effect, Verb

from .firmware import Arm


def position(arm: Arm, axis: str, position_deg: float) -> Mapping[str, float]:
    arm.axes[axis].set("r", position_deg)
    return {"set_point": position_deg}


def stop(arm: Arm, axis: str, how: str, acceleration_rpm_per_s: float) -> None:
    at = arm.axes[axis]
    here_deg = at.get("yw")
    if how == "prejudice" or not at.get("following"):
        at.set("r", here_deg)
    else:
        at.follow(
            to_rest(at.get("r"), at.get("velocity_rpm") * DEG_PER_S, acceleration_rpm_per_s * DEG_PER_S)
        )


def follow(arm: Arm, path: Path, start_ns: int, axis: str) -> None:
    arm.axes[axis].follow(path, start_ns)


def starve(arm: Arm, policy: str, acceleration_rpm_per_s: float, axis: str) -> None:
    stop(arm, axis, "grace" if policy == "decelerate" else "prejudice", acceleration_rpm_per_s)


VERBS = (
    Verb(
        "position",
        "set the angle of an axis",
        (Parameter("position_deg", "where to", "deg", -1e6, 1e6),),
        position,
        Effect.STREAM,
        is_of_axis=True,
    ),
    Verb(
        "stop",
        "stop an axis",
        (
            Parameter("how", "on a ramp or at once", choices=("grace", "prejudice"), default="grace"),
            Parameter("acceleration_rpm_per_s", "of the ramp", "rpm/s", 0.01, 1e6, 600.0),
        ),
        stop,
        Effect.ENDS,
        is_of_axis=True,
    ),
)
