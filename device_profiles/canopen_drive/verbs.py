"""Verbs of the drive, for everybody: its node of a CAN bus moves it by the same."""

from collections.abc import Mapping

from device_profiles.canopen_drive.firmware import CanOpenServo
from hil.firmware.closed_loop_drive import duration_of
from hil.vocab.parameters import Parameter
from hil.vocab.path import Path
from hil.vocab.verbs import HOW_TO_STOP, Effect, Verb, VerbRefused

ANGLE_DEG, RPM, RPM_PER_S = 1e6, (0.001, 3000.0), (0.01, 1e6)
Answer = Mapping[str, float | str | int]
_ACCELERATION = Parameter("acceleration_rpm_per_s", "of the ramps", "rpm/s", *RPM_PER_S, 600.0)
_MOVE = (Parameter("velocity_rpm", "speed on the way", "rpm", *RPM, 60.0), _ACCELERATION)


def enable(board: CanOpenServo) -> Answer:
    board.must_be_sound()
    board.switch_on()
    return {"set_point": board.axis.get("r")}


def disable(board: CanOpenServo) -> None:
    board.switch_off()


def clear_fault(board: CanOpenServo) -> None:
    board.must_be_ready()
    board.clear_fault()


def position(board: CanOpenServo, position_deg: float) -> None:
    board.must_be_on()
    board.step_to(position_deg)


def torque(board: CanOpenServo, effort_count: float) -> None:
    board.must_be_on()
    board.push(effort_count)


def move_abs(
    board: CanOpenServo, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float
) -> Answer:
    board.must_be_on()
    return duration_of(board.move(position_deg, velocity_rpm, acceleration_rpm_per_s))


def move_rel(
    board: CanOpenServo, angle_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float
) -> Answer:
    board.must_be_on()
    target_deg = board.target_deg + angle_deg
    if not abs(target_deg) <= ANGLE_DEG:
        raise VerbRefused("bad_parameter", f"angle_deg: it would lead to {target_deg:.10g} deg")
    return move_abs(board, target_deg, velocity_rpm, acceleration_rpm_per_s)


def stop(board: CanOpenServo, how: str, acceleration_rpm_per_s: float) -> Answer | None:
    """Stop: ``grace`` with a ramp; ``prejudice`` holds at once where the shaft is."""
    if not board.is_on:
        return None
    if how == "grace":
        return duration_of(board.ramp_down(acceleration_rpm_per_s))
    board.hold()
    return None


def follow(board: CanOpenServo, path: Path, start_ns: int) -> None:
    """Follow a run's path."""
    board.must_be_on()
    board.follow(path, start_ns)


VERBS = (
    Verb(
        "position",
        "set-point of the position; the loop has to be on",
        (Parameter("position_deg", "the angle", "deg", -ANGLE_DEG, ANGLE_DEG),),
        position,
        Effect.ENDS,
    ),
    Verb(
        "torque",
        "set-point of the effort; the loop has to be on",
        (Parameter("effort_count", "8.63 mA each", "count", -255.0, 255.0),),
        torque,
        Effect.ENDS,
    ),
    Verb(
        "enable", "start the control loop, which holds the shaft where it is", run=enable, effect=Effect.ENDS
    ),
    Verb("disable", "stop the control loop and take the current off", run=disable, effect=Effect.ENDS),
    Verb("clear_fault", "clear the fault; the loop stays off", run=clear_fault, effect=Effect.ENDS),
    Verb(
        "move_abs",
        "go to an angle with ramps",
        (Parameter("position_deg", "where to", "deg", -ANGLE_DEG, ANGLE_DEG), *_MOVE),
        move_abs,
        Effect.ENDS,
    ),
    Verb(
        "move_rel",
        "go by an angle with ramps, from where the last motion leads",
        (Parameter("angle_deg", "how far", "deg", -ANGLE_DEG, ANGLE_DEG), *_MOVE),
        move_rel,
        Effect.ENDS,
    ),
    Verb(
        "stop",
        "end all motion: with a ramp, or at once",
        (HOW_TO_STOP, _ACCELERATION),
        stop,
        Effect.ENDS,
    ),
)
