"""Verbs of the drive for everybody but a Modbus master. What they do stands in its registers too."""

from device_profiles.modbus_drive import registers
from device_profiles.modbus_drive.firmware import ModbusDrive
from device_profiles.modbus_drive.registers import ANGLE_DEG, RPM, RPM_PER_S, SIGNED_RPM, Answer
from hil.firmware.closed_loop_drive import duration_of
from hil.vocab.parameters import Parameter
from hil.vocab.path import Path
from hil.vocab.verbs import HOW_TO_STOP, Effect, Verb, VerbRefused

GAINS = ("pKp", "pKi", "pKd", "pLPF")
_MOVE = (
    Parameter("velocity_rpm", "speed; left out: the register's", "rpm", *RPM, is_optional=True),
    Parameter(
        "acceleration_rpm_per_s",
        "acceleration; left out: the register's",
        "rpm/s",
        *RPM_PER_S,
        is_optional=True,
    ),
    Parameter(
        "deceleration_rpm_per_s",
        "deceleration; left out: as the acceleration",
        "rpm/s",
        *RPM_PER_S,
        is_optional=True,
    ),
)


def position(board: ModbusDrive, position_deg: float) -> None:
    board.must_be_on()
    board.step_to(position_deg)
    board.tell()


def enable(board: ModbusDrive) -> Answer:
    board.must_be_sound()
    board.switch_on(follows=bool(board.bits["follow"]))
    board.tell()
    return {"set_point": board.axis.get("r")}


def disable(board: ModbusDrive) -> None:
    board.switch_off()
    board.tell()


def clear_fault(board: ModbusDrive) -> None:
    board.must_be_ready()
    board.clear_fault()
    board.tell()


def gains(board: ModbusDrive, **given: float) -> Answer:
    for name, value in given.items():
        board.axis.set(name, value)
    return {name: board.axis.get(name) for name in GAINS}


def move_abs(
    board: ModbusDrive,
    position_deg: float,
    velocity_rpm: float | None = None,
    acceleration_rpm_per_s: float | None = None,
    deceleration_rpm_per_s: float | None = None,
) -> Answer:
    board.must_be_on()
    ramp = board.acceleration_rpm_per_s if acceleration_rpm_per_s is None else acceleration_rpm_per_s
    down = board.deceleration_rpm_per_s if deceleration_rpm_per_s is None else deceleration_rpm_per_s
    speed_rpm = abs(board.velocity_rpm) if velocity_rpm is None else velocity_rpm
    if not speed_rpm:
        raise VerbRefused("not_now", "its speed is 0; set another one first")
    if down is None:
        path = board.move(position_deg, speed_rpm, ramp)
    else:
        path = board.go(position_deg, speed_rpm, ramp, down)
    board.bits["follow"] = 0
    board.tell()
    return duration_of(path)


def move_rel(
    board: ModbusDrive,
    angle_deg: float,
    velocity_rpm: float | None = None,
    acceleration_rpm_per_s: float | None = None,
    deceleration_rpm_per_s: float | None = None,
) -> Answer:
    target_deg = board.target_deg + angle_deg
    if not abs(target_deg) <= ANGLE_DEG:
        raise VerbRefused("bad_parameter", f"angle_deg: it would lead to {target_deg:.10g} deg")
    return move_abs(board, target_deg, velocity_rpm, acceleration_rpm_per_s, deceleration_rpm_per_s)


def stop(board: ModbusDrive, how: str, acceleration_rpm_per_s: float | None = None) -> Answer | None:
    """Stop: ``grace`` with a ramp; ``prejudice`` holds at once where the shaft is. The drive follows no
    set-points afterwards."""
    answer = None
    if board.is_on and how == "prejudice":
        board.hold()
    elif board.is_on:
        own = board.deceleration_rpm_per_s or board.acceleration_rpm_per_s
        kept_deg = board.set_point_deg if board.is_running else None
        answer = duration_of(
            board.ramp_down(own if acceleration_rpm_per_s is None else acceleration_rpm_per_s)
        )
        board.set_point_deg = board.set_point_deg if kept_deg is None else kept_deg
    board.bits["follow"] = 0
    board.tell()
    return answer


def starve(board: ModbusDrive, policy: str, acceleration_rpm_per_s: float) -> bool:
    """Stop as the policy says: no set-point came for the time-out. A target that was written and not followed
    is no stream."""
    if not board.is_streamed:
        return False
    if policy == "torque_off":
        disable(board)
        return True
    try:
        stop(board, "grace" if policy == "decelerate" else "prejudice", acceleration_rpm_per_s)
    except VerbRefused:  # it would take centuries
        stop(board, "prejudice")
    return True


def follow(board: ModbusDrive, path: Path, start_ns: int) -> None:
    """Follow a run's path."""
    board.must_be_on()
    board.follow(path, start_ns)
    board.bits["follow"] = 0
    board.tell()


VERBS = (
    Verb(
        "position",
        "set-point of the position; the loop has to be on",
        (Parameter("position_deg", "the angle", "deg", -ANGLE_DEG, ANGLE_DEG),),
        position,
        Effect.STREAM,
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
        (HOW_TO_STOP, _MOVE[1]),
        stop,
        Effect.ENDS,
    ),
    Verb(
        "gains",
        "set gains of the law; without any it tells them",
        tuple(
            Parameter(name, "as the law has it", "Hz" if "LPF" in name else "", 0.0, 1e6, is_optional=True)
            for name in GAINS
        ),
        gains,
    ),
    *registers.VERBS,
    Verb(
        "run",
        "turn at a speed until a stop; the loop has to be on",
        (
            Parameter(
                "velocity_rpm", "speed; left out: the register's", "rpm", *SIGNED_RPM, is_optional=True
            ),
            *_MOVE[1:],
        ),
        registers.run,
        Effect.ENDS,
    ),
    Verb(
        "search_home",
        "search home by a homing method of CiA 402, and let the registers call it 0",
        (
            Parameter(
                "velocity_rpm",
                "speed of the search for the switch; left out: the register's; above 0 and without a"
                f" method: {registers.UPWARDS}",
                "rpm",
                *SIGNED_RPM,
                is_optional=True,
            ),
            Parameter(
                "method", "which; left out: the register's", "", 1, 37, is_whole=True, is_optional=True
            ),
            Parameter(
                "slow_rpm", "speed at the edge; left out: the register's", "rpm", *RPM, is_optional=True
            ),
        ),
        registers.search_home,
        Effect.ENDS,
    ),
    Verb("origin", "let the registers call the present angle 0", run=registers.origin),
)
