"""Verbs of a Mechaduino: its set-points, modes and gains as the firmware's own memory has them, and motions
that the firmware itself does not know: the core moves the set-point along a path."""

from collections.abc import Callable, Mapping

from device_profiles.mechaduino.firmware import Mechaduino
from device_profiles.mechaduino.firmware_build import GAINS
from hil.firmware.set_point_paths import at, length_ns, to_rest, trapezoid
from hil.vocab.axis import CONTROL_MODES
from hil.vocab.parameters import Parameter
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import HOW_TO_STOP, Effect, Verb, VerbRefused

_MOVE = (
    Parameter("velocity_rpm", "speed on the way", "rpm", 0.001, 3000.0, 60.0),
    Parameter("acceleration_rpm_per_s", "of both ramps", "rpm/s", 0.01, 1e6, 600.0),
)
_ANGLE_DEG = 1e6
_POSITION = ord("x")
_DIR_NS = 1000
"""Time in which the direction is told before the first pulse: chosen."""
_BUSY_WITH = {
    "": "it starts, and takes commands 4 s after power-up; wait until then",
    "c": "it calibrates itself, which takes 26 s and more; wait for the end, or reset it",
    "j": "it makes its step response, after a count-down of 10 s; wait for the end, or reset it",
}
"""Routines that take longest, by the letter that began each, and what to do meanwhile."""
_EMPTY = "its look-up table is empty, so it holds no angle: disable it, then calibrate it"

Answer = Mapping[str, float | str | int]


def _at_the_menu(board: Mechaduino) -> None:
    """Refuse while the main program is busy: a serial client could not disturb it either."""
    if board.is_busy:
        at_prompt = f"its command {board.letter} runs, or asks for a number at its terminal"
        why = _BUSY_WITH.get(board.letter, f"{at_prompt}; answer it there, wait for the end, or reset it")
        raise VerbRefused("not_now", why)


def _may_move(board: Mechaduino, mode: str) -> None:
    """Refuse a motion while the loop is off, as nobody switched it on, or the look-up table is empty."""
    _at_the_menu(board)
    if mode in "xh" and not board.table.is_written:
        raise VerbRefused("not_now", "the look-up table is empty; calibrate it first")
    if not board.axis.get("loop_on"):
        raise VerbRefused("not_now", "the control loop is off; enable it first")


def _set_point(board: Mechaduino, mode: str, r: float) -> None:
    _may_move(board, mode)
    board.axis.set("mode", ord(mode))
    board.axis.set("r", r)


def mode(board: Mechaduino, mode: str) -> None:
    _at_the_menu(board)
    board.axis.set("mode", ord(CONTROL_MODES[mode]))
    if mode in ("velocity", "torque"):
        board.axis.set("r", 0.0)
    else:
        board.axis.set("r", board.table.angle_deg())


def enable(board: Mechaduino) -> Answer:
    """Do as the letter ``y``, without its ten readings; a position is held where no mode was chosen."""
    _at_the_menu(board)
    letter = _letter(board)
    if letter not in CONTROL_MODES.values():
        letter = "x"
    r = board.table.angle_deg() if letter in "xh" else 0.0
    board.axis.set("mode", ord(letter))
    board.axis.set("r", r)
    board.axis.loop(True)
    if letter not in "xh":
        return {}
    lacks = {} if board.table.is_written else {"remark": _EMPTY}
    return {"set_point": board.axis.get("r")} | lacks


def gains(board: Mechaduino, **given: float) -> Answer:
    for name, value in given.items():
        board.axis.set(name, value)
    return {name: board.axis.get(name) for name in GAINS}


def calibrate(board: Mechaduino) -> Answer:
    """Type the letter ``c``, which begins at once."""
    _at_the_menu(board)
    if board.axis.get("loop_on"):
        raise VerbRefused("not_now", "the control loop is on, and would turn the shaft; disable it first")
    return {"ends_after_ns": board.calibration_ns}


def move_abs(
    board: Mechaduino, position_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float
) -> Answer:
    _may_move(board, "x")
    limits = velocity_rpm * DEG_PER_S, acceleration_rpm_per_s * DEG_PER_S
    return _follow(board, "x", lambda: trapezoid(*_where(board), position_deg, *limits))


def move_rel(
    board: Mechaduino, angle_deg: float, velocity_rpm: float, acceleration_rpm_per_s: float
) -> Answer:
    from_deg = board.path[-1].r if _is_on_the_way(board) else _where(board)[0]
    target_deg = from_deg + angle_deg
    if not abs(target_deg) <= _ANGLE_DEG:
        raise VerbRefused("bad_parameter", f"angle_deg: it would lead to {target_deg:.10g} deg")
    return move_abs(board, target_deg, velocity_rpm, acceleration_rpm_per_s)


def stop(board: Mechaduino, how: str, acceleration_rpm_per_s: float) -> Answer | None:
    """Stop: ``grace`` with a ramp; ``prejudice`` at once, and a position loop holds the shaft where it is."""
    answer = _stop_set_point(board, how, acceleration_rpm_per_s)
    board.axis.drive(())  # pulses would move the set-point on
    return answer


def _stop_set_point(board: Mechaduino, how: str, acceleration_rpm_per_s: float) -> Answer | None:
    letter = _letter(board)
    if not board.axis.get("loop_on"):
        return None
    if how == "prejudice":
        board.axis.set("r", board.table.angle_deg() if letter in "xh" else 0.0)
        return None
    if letter in "xh":
        return _follow(board, letter, lambda: to_rest(*_where(board), acceleration_rpm_per_s * DEG_PER_S))
    if letter == "v":
        return _follow(board, "v", lambda: to_rest_value(board.axis.get("r"), acceleration_rpm_per_s))
    board.axis.set("r", 0.0)
    return None


def to_rest_value(r: float, per_s: float) -> tuple[PathPiece, ...]:
    """Path of a set-point to 0 at this rate."""
    duration_ns = round(abs(r) / per_s * NS_PER_S)
    return PathPiece(duration_ns, r, -per_s if r > 0 else per_s), PathPiece(0, 0.0)


def starve(board: Mechaduino, policy: str, acceleration_rpm_per_s: float) -> None:
    """Stop as the policy says: no set-point came for the time-out."""
    if policy == "torque_off":
        board.disable()
    elif policy == "decelerate":
        try:
            stop(board, "grace", acceleration_rpm_per_s)
        except VerbRefused:  # from a set-point that was typed it would take centuries
            stop(board, "prejudice", acceleration_rpm_per_s)
    elif board.axis.get("loop_on"):  # hold: stay here, whatever the axis did
        if not board.table.is_written:
            board.axis.set("r", 0.0)
            return
        here_deg = board.table.angle_deg()
        board.axis.set("mode", ord("x"))
        board.axis.set("r", here_deg)


def pulses(board: Mechaduino, count: float, rate_Hz: float, direction: str) -> Answer:
    duration_ns = round(count / rate_Hz * NS_PER_S)
    level = 0 if direction == "up" else 1
    # The firmware knows edges of its dir input, and no level.
    edges = [(0, "dir", 1 - level, 0, 0), (_DIR_NS // 2, "dir", level, 0, 0)]
    board.axis.drive([*edges, (_DIR_NS, "step", 0, int(count), duration_ns)])
    return {"ends_after_ns": duration_ns + _DIR_NS}


def _letter(board: Mechaduino) -> str:
    return chr(int(board.axis.get("mode")))


def _is_on_the_way(board: Mechaduino) -> bool:
    """True while the set-point is an angle that follows a path."""
    return bool(board.axis.get("following")) and _letter(board) in "xh"


def follow(board: Mechaduino, path: Path, start_ns: int) -> None:
    """Follow a run's path: position mode, and the set-point along the path from then on."""
    _may_move(board, "x")
    if board.axis.get("mode") != _POSITION:
        board.axis.set("mode", _POSITION)
        board.axis.set("r", path[0].r)
    board.axis.follow(path, start_ns)
    board.path, board.path_from_ns = path, max(start_ns, int(board.axis.get("at_ns")))


def _where(board: Mechaduino) -> tuple[float, float]:
    """Set-point and its rate in degrees; those of the shaft, if the set-point is no angle."""
    axis = board.axis
    if _is_on_the_way(board):
        return at(board.path, int(axis.get("at_ns")) - board.path_from_ns)
    if axis.get("loop_on") and _letter(board) in "xh":
        return axis.get("r"), 0.0
    return board.table.angle_deg(), axis.get("velocity_rpm") * DEG_PER_S


def _follow(board: Mechaduino, mode: str, make: Callable[[], Path]) -> Answer:
    try:
        path = make()
        board.axis.follow(path)
    except (ValueError, OverflowError):  # a set-point that was typed may be infinite, or nearly so
        raise VerbRefused(
            "not_now",
            f"no path leads there from the set-point {board.axis.get('r'):g}; set another one first",
        ) from None
    if _letter(board) != mode:
        board.axis.set("mode", ord(mode))
        board.axis.follow(path)
    board.path, board.path_from_ns = path, int(board.axis.get("at_ns"))
    return {"ends_after_ns": length_ns(path), "set_point": path[-1].r}


_RAMP = (Parameter("acceleration_rpm_per_s", "of the ramp", "rpm/s", 0.01, 1e6, 600.0),)
VERBS = (
    Verb(
        "position",
        "set-point of the position; the loop has to be on",
        (Parameter("position_deg", "the angle", "deg", -_ANGLE_DEG, _ANGLE_DEG),),
        lambda board, position_deg: _set_point(board, "x", position_deg),
        Effect.STREAM,
    ),
    Verb(
        "velocity",
        "set-point of the speed; the loop has to be on",
        (Parameter("velocity_rpm", "the speed", "rpm", -3000.0, 3000.0),),
        lambda board, velocity_rpm: _set_point(board, "v", velocity_rpm),
        Effect.STREAM,
    ),
    Verb(
        "torque",
        "set-point of the effort; the loop has to be on",
        (Parameter("effort_count", "8.63 mA each", "count", -255.0, 255.0),),
        lambda board, effort_count: _set_point(board, "t", effort_count),
        Effect.STREAM,
    ),
    Verb(
        "mode",
        "choose what the set-point means; it becomes the present angle, or 0",
        (Parameter("mode", "of the control law", choices=tuple(CONTROL_MODES)),),
        mode,
        Effect.ENDS,
    ),
    Verb(
        "enable", "start the control loop, which holds the shaft where it is", run=enable, effect=Effect.ENDS
    ),
    Verb(
        "disable",
        "stop the control loop and take the current off",
        run=Mechaduino.disable,
        effect=Effect.ENDS,
    ),
    Verb(
        "gains",
        "set gains and break frequencies of the law; without any it tells them",
        tuple(
            Parameter(
                name, "as the firmware has it", "Hz" if "LPF" in name else "", 0.0, 1e6, is_optional=True
            )
            for name in GAINS
        ),
        gains,
    ),
    Verb(
        "calibrate",
        "make and store the look-up table, as the letter c: 26 s in which the shaft turns, and before it"
        " 0.11 s back for each step since the reset: 49 s the second time",
        run=calibrate,
        effect=Effect.ENDS,
        types=b"c",
    ),
    Verb(
        "move_abs",
        "go to an angle with ramps",
        (Parameter("position_deg", "where to", "deg", -_ANGLE_DEG, _ANGLE_DEG), *_MOVE),
        move_abs,
        Effect.ENDS,
    ),
    Verb(
        "move_rel",
        "go by an angle with ramps, from where the last motion leads",
        (Parameter("angle_deg", "how far", "deg", -_ANGLE_DEG, _ANGLE_DEG), *_MOVE),
        move_rel,
        Effect.ENDS,
    ),
    Verb(
        "stop",
        "end all motion, pulses too: with a ramp, or at once",
        (HOW_TO_STOP, *_RAMP),
        stop,
        Effect.ENDS,
    ),
    Verb(
        "pulses",
        "pulses at the step input",
        (
            Parameter("count", "how many", "pulse", 1, 1e6, is_whole=True),
            Parameter("rate_Hz", "how fast", "Hz", 0.1, 100_000.0, 1000.0),
            Parameter("direction", "up: larger angles", choices=("up", "down"), default="up"),
        ),
        pulses,
    ),
)
