"""The one table of a drive's objects: dictionary, EDS and reference come from it.

Units: positions in user units (``drive_context.py``), by default thousandths of a degree; velocities in the
same a second, accelerations in the same a second squared; torques and currents in thousandths of the rated
ones; times in milliseconds. Names are those of CiA 402-2.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from bridges.can.canopen.cia402_words import (
    CYCLIC_POSITION,
    CYCLIC_VELOCITY,
    HOMING,
    PROFILE_POSITION,
    PROFILE_TORQUE,
    PROFILE_VELOCITY,
)
from bridges.can.canopen.node.application import Access, DataType, Entry

I8, I16, I32 = DataType.INTEGER8, DataType.INTEGER16, DataType.INTEGER32
U8, U16, U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
RO, RW, CONST = Access.RO, Access.RW, Access.CONST
INT16, INT32, UINT32 = 2**15 - 1, 2**31 - 1, 2**32 - 1

LIMITED_JERK = 3
"""Motion profile type (6086h)."""
MODES: Mapping[int, str] = {
    PROFILE_POSITION: "profile position: set-points by handshake, with ramps",
    PROFILE_VELOCITY: "profile velocity: a speed, with ramps",
    PROFILE_TORQUE: "profile torque: a torque, with a slope",
    HOMING: "homing: the search for the position from which the drive counts",
    CYCLIC_POSITION: "cyclic synchronous position: a target with each SYNC",
    CYCLIC_VELOCITY: "cyclic synchronous velocity: a speed with each SYNC",
}
"""Modes of operation (6060h), those of a board with paths and torque."""
SERVO_DRIVE, STEPPER_DRIVE = 0x0002_0192, 0x0004_0192
"""Object 1000h: profile 402, servo drive or stepper motor."""
PATHS, TORQUE = "paths", "torque"
"""Names of what an object needs of the axis: paths, or the verb ``torque``."""


@dataclass(frozen=True)
class ObjectRow:
    """Row of the table: an entry, and what it needs of the axis (empty: nothing)."""

    entry: Entry
    needs: str = ""


def _told(index: int, name: str, data_type: DataType, about: str, mapping: str = "tpdo") -> Entry:
    """Entry of a value that the drive tells: read only."""
    return Entry(index, 0, name, data_type, RO, mapping=mapping, is_live=True, about=about)


def _given(
    index: int,
    name: str,
    data_type: DataType,
    default: int,
    about: str,
    low: int | None = None,
    high: int | None = None,
    *,
    mapping: str = "both",
) -> Entry:
    """Entry of a value that a master writes again and again: no drive keeps it without power."""
    return Entry(index, 0, name, data_type, RW, default, low, high, mapping, about=about)


def _set(
    index: int,
    name: str,
    data_type: DataType,
    default: int,
    about: str,
    low: int | None = None,
    high: int | None = None,
    *,
    subindex: int = 0,
    mapping: str = "",
) -> Entry:
    """Parameter, which 1010h keeps. Only what takes any value within its limits is mapped."""
    return Entry(
        index, subindex, name, data_type, RW, default, low, high, mapping, is_stored=True, about=about
    )


def _of_motion(index: int, name: str, default: int, about: str) -> Entry:
    """Parameter of motions, above 0."""
    return _set(index, name, U32, default, about, 1, mapping="both")


def array_of(index: int, *entries: Entry) -> Iterator[Entry]:
    """Object with sub-indices, 0 included."""
    yield Entry(
        index, 0, "Highest sub-index supported", U8, CONST, len(entries), about="Sub-indices that follow."
    )
    yield from entries


def _ratio(index: int, first: str, second: str, default: int, about: str) -> Iterator[Entry]:
    """Two whole numbers of which the first is divided by the second."""
    return array_of(
        index,
        _set(index, first, U32, default, f"{about}: dividend.", 1, subindex=1),
        _set(index, second, U32, 1, f"{about}: divisor.", 1, subindex=2),
    )


NAMES: Mapping[int, str] = {
    0x607D: "Software position limit",
    0x608F: "Position encoder resolution",
    0x6091: "Gear ratio",
    0x6092: "Feed constant",
    0x6096: "Velocity factor",
    0x6097: "Acceleration factor",
    0x6099: "Homing speeds",
    0x60A4: "Profile jerk",
    0x60C2: "Interpolation time period",
    0x60E3: "Supported homing methods",
}
"""Names of objects that have sub-indices."""

_STATE = (
    _told(0x603F, "Error code", U16, "Code of the last fault; 0 after its reset."),
    _given(0x6040, "Controlword", U16, 0, "What the state machine and the mode are to do."),
    _told(0x6041, "Statusword", U16, "State of the drive and of its mode."),
    _set(
        0x6007,
        "Abort connection option code",
        I16,
        1,
        "Lost connection: 0 nothing, 1 fault, 2 disable voltage, 3 quick stop.",
        0,
        3,
    ),
    _set(
        0x605A,
        "Quick stop option code",
        I16,
        2,
        "0 power off, 1 ramp, 2 quick ramp, 3 at once; 5 to 7 as these, and stay.",
        0,
        7,
    ),
    _set(0x605B, "Shutdown option code", I16, 0, "Shutdown in operation: 0 power off, 1 ramp first.", 0, 1),
    _set(
        0x605C, "Disable operation option code", I16, 1, "Disable operation: 0 power off, 1 ramp first.", 0, 1
    ),
    _set(0x605D, "Halt option code", I16, 1, "Halt: 1 ramp, 2 quick ramp, 3 at once.", 1, 3),
    _set(
        0x605E,
        "Fault reaction option code",
        I16,
        2,
        "Fault: 0 power off, 1 ramp, 2 quick ramp, 3 at once.",
        0,
        3,
    ),
    _given(0x6060, "Modes of operation", I8, 1, "Mode that is wanted; those of 6502h."),
    _told(0x6061, "Modes of operation display", I8, "Mode in force."),
    Entry(0x6502, 0, "Supported drive modes", U32, CONST, about="Modes, a bit each: 0 is mode 1."),
    Entry(0x67FF, 0, "Single device type", U32, CONST, about="Device type, as in 1000h."),
    Entry(0x6402, 0, "Motor type", U16, CONST, 9, about="9: micro-step stepper motor."),
)
_POSITION = (
    _told(0x6062, "Position demand value", I32, "Set-point."),
    _told(0x6063, "Position actual internal value", I32, "Angle of the shaft in counts of the encoder."),
    _told(0x6064, "Position actual value", I32, "Angle of the shaft."),
    _set(
        0x6065, "Following error window", U32, 30_000, "Greatest distance from the set-point; FFFFFFFFh: any."
    ),
    _set(0x6066, "Following error time out", U16, 50, "Time for which it may be exceeded, in ms."),
    _set(
        0x6067, "Position window", U32, 500, "Distance from the target that counts as there; FFFFFFFFh: any."
    ),
    _set(0x6068, "Position window time", U16, 10, "Time in the window until the target is reached, in ms."),
    _given(0x607A, "Target position", I32, 0, "Where to, in the modes 1 and 8."),
    _set(0x607C, "Home offset", I32, 0, "Distance of the zero position from the home position."),
    *array_of(
        0x607D,
        _set(
            0x607D,
            "Min position limit",
            I32,
            -INT32 - 1,
            "Least position from home; -2147483648: none.",
            subindex=1,
        ),
        _set(
            0x607D,
            "Max position limit",
            I32,
            INT32,
            "Greatest position from home; 2147483647: none.",
            subindex=2,
        ),
    ),
    _set(0x607E, "Polarity", U8, 0, "Bit 7: positions have the other sign; bit 6: velocities.", 0, 0xC0),
    _told(0x60F4, "Following error actual value", I32, "Set-point minus position."),
    _told(0x60FC, "Position demand internal value", I32, "Set-point in counts of the encoder."),
    _told(
        0x60FD,
        "Digital inputs",
        U32,
        "Bits 0 negative limit, 1 positive limit, 2 home; other inputs from 16 on.",
    ),
)
_VELOCITY = (
    _told(0x606B, "Velocity demand value", I32, "Speed of the set-point."),
    _told(0x606C, "Velocity actual value", I32, "Speed of the shaft."),
    _set(0x606D, "Velocity window", U16, 60_000, "Distance from the target speed that counts as reached."),
    _set(0x606E, "Velocity window time", U16, 10, "Time in the window until it is reached, in ms."),
    _set(0x606F, "Velocity threshold", U16, 60_000, "Speed up to which the shaft stands."),
    _set(0x6070, "Velocity threshold time", U16, 10, "Time above it after which it turns, in ms."),
    _given(0x60FF, "Target velocity", I32, 0, "Speed, in the modes 3 and 9."),
)
_PROFILE = (
    _of_motion(0x607F, "Max profile velocity", 18_000_000, "Greatest speed of the modes 1 and 3."),
    _set(0x6080, "Max motor speed", U32, 3000, "Greatest speed of the motor in all modes, in rpm.", 1),
    _of_motion(0x6081, "Profile velocity", 360_000, "Speed on the way to a target."),
    _of_motion(0x6083, "Profile acceleration", 3_600_000, "Acceleration of the modes 1 and 3."),
    _of_motion(0x6084, "Profile deceleration", 3_600_000, "Deceleration of the modes 1 and 3."),
    _of_motion(0x6085, "Quick stop deceleration", 36_000_000, "Deceleration of a quick ramp."),
    _of_motion(0x60C5, "Max acceleration", UINT32, "Greatest acceleration."),
    _of_motion(0x60C6, "Max deceleration", UINT32, "Greatest deceleration."),
)
_JERK = (
    _set(0x6086, "Motion profile type", I16, 0, "0: trapezoid, 3: limited jerk.", 0, 3),
    *array_of(
        0x60A4, _set(0x60A4, "Profile jerk 1", U32, 360_000_000, "Jerk of profile type 3.", 1, subindex=1)
    ),
)
_FACTORS = (
    *array_of(
        0x608F,
        Entry(0x608F, 1, "Encoder increments", U32, CONST, about="Counts of the encoder in that many turns."),
        Entry(0x608F, 2, "Motor revolutions", U32, CONST, 1, about="Turns of the motor."),
    ),
    *_ratio(0x6091, "Motor revolutions", "Shaft revolutions", 1, "Turns of the motor for those of the shaft"),
    *_ratio(0x6092, "Feed", "Shaft revolutions", 360_000, "User positions in turns of the shaft"),
    *_ratio(0x6096, "Numerator", "Divisor", 1, "Units of velocity for user positions a second"),
    *_ratio(0x6097, "Numerator", "Divisor", 1, "Units of acceleration for user positions a second squared"),
)
_HOMING = (
    _set(0x6098, "Homing method", I8, 37, "How home is found; those of 60E3h.", 0, 37),
    *array_of(
        0x6099,
        _set(
            0x6099,
            "Speed during search for switch",
            U32,
            360_000,
            "Speed until a switch is found.",
            1,
            subindex=1,
        ),
        _set(
            0x6099,
            "Speed during search for zero",
            U32,
            36_000,
            "Speed to its edge or to the index.",
            1,
            subindex=2,
        ),
    ),
    _set(0x609A, "Homing acceleration", U32, 3_600_000, "Acceleration and deceleration of homing.", 1),
)
_OF_TORQUE = (
    _given(0x6071, "Target torque", I16, 0, "Torque of mode 4.", -INT16 - 1, INT16),
    _set(0x6072, "Max torque", U16, 1000, "Greatest torque of mode 4.", 0, 1000, mapping="both"),
    _told(0x6074, "Torque demand", I16, "Torque that the mode asks for now."),
    _set(
        0x6087, "Torque slope", U32, 1000, "Change of the torque in thousandths a second.", 1, mapping="both"
    ),
)
_CURRENT = (
    Entry(0x6075, 0, "Motor rated current", U32, CONST, about="In mA."),
    Entry(0x6076, 0, "Motor rated torque", U32, CONST, about="In thousandths of a Nm."),
    _told(0x6077, "Torque actual value", I16, "Torque, by the current."),
    _told(0x6078, "Current actual value", I16, "Current that makes torque."),
)
_CYCLIC = (
    *array_of(
        0x60C2,
        _set(
            0x60C2,
            "Interpolation time period value",
            U8,
            1,
            "Time from SYNC to SYNC, in units of the next.",
            1,
            subindex=1,
        ),
        _set(
            0x60C2,
            "Interpolation time index",
            I8,
            -3,
            "Power of ten of seconds that it is counted in.",
            -6,
            0,
            subindex=2,
        ),
    ),
)


ROWS: tuple[ObjectRow, ...] = tuple(
    ObjectRow(entry, needs)
    for entries, needs in (
        (_STATE, ""),
        (_POSITION, ""),
        (_VELOCITY, ""),
        (_PROFILE, ""),
        (_JERK, PATHS),
        (_FACTORS, ""),
        (_HOMING, ""),
        (_OF_TORQUE, TORQUE),
        (_CURRENT, ""),
        (_CYCLIC, PATHS),
    )
    for entry in entries
)
"""All objects, in the order of what they are about."""
