"""Writes of a Modbus master: values and control bits, all that one request has at once."""

from collections.abc import Mapping
from dataclasses import replace

from device_profiles.modbus_drive.firmware import BITS, ModbusDrive
from hil.firmware.cell_verbs import CELL_VERBS, CELLS
from hil.firmware.closed_loop_drive import duration_of
from hil.firmware.homing_methods import METHODS
from hil.vocab.drive_words import SLOWLY
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Effect, Verb, VerbRefused

ANGLE_DEG = 1e6
RPM, RPM_PER_S = (0.1, 3000.0), (1.0, 1e6)
SIGNED_RPM, FAST_RPM_PER_S = (-1e4, 1e4), (0.001, 1e6)
"""Limits within which every path can be computed."""
Answer = Mapping[str, float | str | int]
UPWARDS = 19
"""Homing method of a search of the home switch towards larger angles."""
_NAMES = {"set_velocity_rpm": "velocity_rpm", "acceleration_rpm_per_s": "acceleration_rpm_per_s"}
"""Attributes of the firmware by names of values."""


def write(board: ModbusDrive, **given: float) -> Answer | None:
    """Take what a request writes, in the order reset, values, enable, stop, follow, start; all of it or
    nothing. A start answers as a move."""
    board.must_be_ready()
    bits = board.bits | {name: int(value) for name, value in given.items() if name in BITS}
    rises = {name for name in BITS if bits[name] > board.bits[name]}
    is_switched_off = board.bits["enable"] > bits["enable"]
    _check(board, bits, rises, is_switched_off=is_switched_off)
    _check_start_is_no_repeat(board, bits, given)
    if "reset" in rises:
        board.clear_fault()
    for name, attribute in _NAMES.items():
        if name in given:
            setattr(board, attribute, given[name])
    if is_switched_off:
        board.switch_off()
    elif "enable" in rises:
        board.switch_on(follows=bool(bits["follow"]))
    answer = _moved(board, bits, rises, given.get("set_point_deg"))
    board.bits = bits
    board.tell()
    return answer


def _check(board: ModbusDrive, bits: Mapping[str, int], rises: set[str], *, is_switched_off: bool) -> None:
    """Refuse what cannot be taken, before anything is."""
    if "enable" in rises and "reset" not in rises:
        board.must_be_sound()
    if "follow" in rises and board.is_moving:
        raise VerbRefused("not_now", "follow: a move is under way; stop it, or let it end")
    if "start" not in rises:
        return
    if "reset" not in rises:
        board.must_be_sound()
    if is_switched_off or not (board.is_on or "enable" in rises):
        raise VerbRefused("not_now", "start: the control loop is off; enable it first")
    for bit in ("stop", "follow"):
        if bits[bit]:
            raise VerbRefused("not_now", f"start: {bit} is 1; write 0 to it first")


def _check_start_is_no_repeat(
    board: ModbusDrive, bits: Mapping[str, int], given: Mapping[str, float]
) -> None:
    """Refuse a start that would do nothing, where the master means one: a start bit that is 1 already, alone,
    behind a new set-point, while the axis stands. A master that writes in a cycle has written the bit again
    before, and is not refused."""
    if not given.get("start") or not board.bits["start"]:
        return
    is_alone = given.keys() <= set(BITS) and bits == board.bits
    stands = board.is_on and not board.is_moving and not bits["follow"]
    if is_alone and board.has_new_target and stands and not board.repeats_start:
        raise VerbRefused(
            "not_now",
            "start: it is 1 already, and the drive starts when it becomes 1; write 0 first, or say in the map"
            " that each write is a start: on_write: true",
        )
    board.repeats_start = True


def _moved(
    board: ModbusDrive, bits: Mapping[str, int], rises: set[str], set_point_deg: float | None
) -> Answer | None:
    """Stop, follow and start, as the bits say."""
    if "stop" in rises and board.is_on:
        board.ramp_down(board.acceleration_rpm_per_s)
    if set_point_deg is not None:
        board.has_new_target |= set_point_deg != board.set_point_deg
        board.set_point_deg = set_point_deg
    is_new = set_point_deg is not None or "follow" in rises
    if bits["follow"] and not bits["stop"] and board.is_on and is_new:
        board.step_to(board.set_point_deg)
    if "start" in rises:
        board.has_new_target = board.repeats_start = False
        path = board.move(board.set_point_deg, board.velocity_rpm, board.acceleration_rpm_per_s)
        return duration_of(path)
    return None


def put(board: ModbusDrive, cells: str = "", **given: float) -> None:
    """Take values and cells as they are written by a map of version 2: they are kept, and what turns or
    follows changes with them. Raises VerbRefused."""
    board.must_be_ready()
    if cells:
        board.cells.take_text(cells, board.now_ns)
    if "homing_method" in given:
        _must_be_method("homing_method", given["homing_method"])
    for name, value in given.items():
        if name == "reverse":
            board.is_reversed = bool(value)
        elif name != "set_point_deg":
            setattr(board, _NAMES.get(name, name), value)
    if (set_point_deg := given.get("set_point_deg")) is not None:
        if board.is_following:
            board.step_to(set_point_deg)
        board.set_point_deg = set_point_deg
    board.run_again()
    board.tell()


def run(
    board: ModbusDrive,
    velocity_rpm: float | None = None,
    acceleration_rpm_per_s: float | None = None,
    deceleration_rpm_per_s: float | None = None,
) -> None:
    """Turn at a speed until a stop. Raises VerbRefused."""
    board.must_be_on()
    board.bits["follow"] = 0
    board.run(velocity_rpm, acceleration_rpm_per_s, deceleration_rpm_per_s)
    board.tell()


def search_home(
    board: ModbusDrive,
    velocity_rpm: float | None = None,
    method: int | None = None,
    slow_rpm: float | None = None,
) -> None:
    """Search home, and let the registers call it 0. Raises VerbRefused."""
    if method is None:
        method = UPWARDS if velocity_rpm is not None and velocity_rpm > 0 else board.homing_method
    _must_be_method("method", method)
    board.must_be_on()
    board.bits["follow"] = 0
    fast_rpm = velocity_rpm or board.homing_velocity_rpm or board.velocity_rpm
    board.search_home(int(method), abs(fast_rpm), slow_rpm or board.homing_slow_rpm or abs(fast_rpm) * SLOWLY)
    board.tell()


def _must_be_method(name: str, method: float) -> None:
    if method not in METHODS:
        known = ", ".join(map(str, sorted(METHODS)))
        raise VerbRefused("bad_parameter", f"{name}: {method:g} is no homing method; there are {known}")


def origin(board: ModbusDrive) -> None:
    """Let the registers call the present angle 0. Raises VerbRefused: it moves."""
    board.must_be_ready()
    if board.is_moving:
        raise VerbRefused("not_now", "origin: a motion is under way; stop it, or let it end")
    board.zero()
    board.tell()


_SET_POINT = Parameter(
    "set_point_deg", "target of a move, or set-point that is followed", "deg", -ANGLE_DEG, ANGLE_DEG
)
_OTHERS = (
    Parameter("set_velocity_rpm", "largest speed of moves", "rpm", *RPM, is_optional=True),
    Parameter("acceleration_rpm_per_s", "acceleration of moves", "rpm/s", *RPM_PER_S, is_optional=True),
    *(Parameter(bit, "control bit", is_whole=True, is_optional=True, limits="0 or 1") for bit in BITS),
)
VERBS = (
    Verb(
        "set_point",
        "write the set-point's register, and others with it, as a Modbus master does",
        (_SET_POINT, *_OTHERS),
        write,
        Effect.STREAM,
    ),
    Verb("write", "write registers and control bits, as a Modbus master does", _OTHERS, write),
    Verb(
        "put",
        "write values and cells by a map of version 2, as a Modbus master does",
        (
            CELLS,
            replace(_SET_POINT, is_optional=True),
            Parameter("set_velocity_rpm", "speed", "rpm", *SIGNED_RPM, is_optional=True),
            Parameter("run_velocity_rpm", "speed to turn at", "rpm", *SIGNED_RPM, is_optional=True),
            Parameter("acceleration_rpm_per_s", "acceleration", "rpm/s", *FAST_RPM_PER_S, is_optional=True),
            Parameter("deceleration_rpm_per_s", "deceleration", "rpm/s", *FAST_RPM_PER_S, is_optional=True),
            Parameter("homing_method", "way to search home", "", 1, 37, is_whole=True, is_optional=True),
            Parameter("homing_velocity_rpm", "speed of the search", "rpm", *RPM, is_optional=True),
            Parameter("homing_slow_rpm", "speed at the edge", "rpm", *RPM, is_optional=True),
            Parameter("reverse", "1: turn in the other direction", is_whole=True, is_optional=True),
        ),
        put,
    ),
    *CELL_VERBS,
)
