"""Entries that the drive of an axis has: rows of the table of objects, with the axis's own numbers."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from bridges.can.canopen.can_ids import RPDO, TPDO
from bridges.can.canopen.cia402.motor_axis import MotorAxis
from bridges.can.canopen.cia402.objects import (
    CONST,
    I8,
    NAMES,
    PATHS,
    ROWS,
    RW,
    SERVO_DRIVE,
    STEPPER_DRIVE,
    TORQUE,
    U32,
    UINT32,
    array_of,
)
from bridges.can.canopen.cia402_words import (
    CYCLIC_POSITION,
    CYCLIC_VELOCITY,
    HOMING,
    PROFILE_POSITION,
    PROFILE_TORQUE,
    PROFILE_VELOCITY,
    mode_bit,
)
from bridges.can.canopen.node.application import Entry
from bridges.can.canopen.node.communication_entries import mapping_entries
from hil.firmware.homing_methods import methods_of

MAPPED = {
    0x1600: (0x6040,),
    0x1601: (0x6040, 0x6060),
    0x1602: (0x6040, 0x607A),
    0x1603: (0x6040, 0x60FF),
    0x1A00: (0x6041,),
    0x1A01: (0x6041, 0x6061),
    0x1A02: (0x6041, 0x6064),
    0x1A03: (0x6041, 0x606C),
}
"""Objects that the PDOs have by default."""
VALID = (0x1400,)
"""PDOs that are valid by default, by their communication parameters. The others wait until a master wants
them: the bus is quiet, and no controlword comes in passing with another object."""
_NOT_VALID = 1 << 31


def modes_of(axis: MotorAxis) -> tuple[int, ...]:
    """Modes of operation (6060h) in which an axis can be moved."""
    verbs = axis.verbs
    modes = []
    if axis.follows_paths or "move_abs" in verbs:
        modes.append(PROFILE_POSITION)
    if axis.follows_paths or "velocity" in verbs:
        modes.append(PROFILE_VELOCITY)
    if axis.follows_paths and "torque" in verbs:
        modes.append(PROFILE_TORQUE)
    if axis.follows_paths or "velocity" in verbs:
        modes.append(HOMING)
    if axis.follows_paths:
        modes += [CYCLIC_POSITION, CYCLIC_VELOCITY]
    return tuple(modes)


def entries_of(axis: MotorAxis) -> tuple[Entry, ...]:
    """Make the entries that an axis's drive has."""
    has = {"": True, PATHS: axis.follows_paths, TORQUE: PROFILE_TORQUE in modes_of(axis)}
    most_rpm = round(min(axis.max_velocity_rpm, UINT32))
    own: dict[int, int] = {
        0x6075: round(axis.rated_current_A * 1000),
        0x6076: round(axis.rated_torque_Nm * 1000),
        0x6080: most_rpm,
        0x6502: sum(mode_bit(mode) for mode in modes_of(axis)),
        0x6060: next(iter(modes_of(axis)), 0),
        0x67FF: SERVO_DRIVE if axis.follows_paths else STEPPER_DRIVE,
    }
    own_sub = {(0x608F, 1): axis.encoder_counts}
    found = []
    for row in ROWS:
        entry = row.entry
        if not has[row.needs]:
            continue
        default = own_sub.get((entry.index, entry.subindex), entry.default)
        if entry.subindex == 0:
            default = own.get(entry.index, default)
        high = most_rpm if entry.index == 0x6080 else entry.high
        found.append(replace(entry, default=default, high=high))
    found += _methods(axis)
    return (*found, *_mappings(found))


def _mappings(entries: Sequence[Entry]) -> Iterator[Entry]:
    """PDO mappings with which the drive begins."""
    by_index = {entry.index: entry for entry in entries if entry.subindex == 0}
    for index, mapped in MAPPED.items():
        yield from mapping_entries(index, [by_index[each] for each in mapped])
    for index, can_ids, name in (
        (0x1400, RPDO, "COB-ID used by RPDO"),
        (0x1800, TPDO, "COB-ID used by TPDO"),
    ):
        for at, can_id in enumerate(can_ids):
            if index + at not in VALID:
                cob_id = can_id | _NOT_VALID
                yield Entry(index + at, 1, name, U32, RW, cob_id, is_stored=True, adds_node_id=True)


def _methods(axis: MotorAxis) -> Iterator[Entry]:
    """Homing methods that an axis can do (60E3h)."""
    numbers = methods_of(axis.look().inputs, has_index=axis.index_deg is not None)
    return array_of(
        0x60E3,
        *(
            Entry(0x60E3, place, f"{place}. supported homing method", I8, CONST, number, about="Its number.")
            for place, number in enumerate(numbers, 1)
        ),
    )


def names_of(entries: Collection[Entry]) -> dict[int, str]:
    """Names of those objects among the entries that have sub-indices."""
    there = {entry.index for entry in entries}
    return {index: name for index, name in NAMES.items() if index in there}
