"""Verbs of a real Modbus drive: those that its map allows."""

from bridges.modbus.registers.drive_map import DriveMap
from hil.drives.drive_verbs import (
    FOLLOW_RPM,
    FOLLOW_RPM_PER_S,
    MOST_RPM,
    MOST_RPM_PER_S,
    common_verbs,
    drive_verb,
)
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb


def map_verbs(of: DriveMap) -> dict[str, Verb]:
    """Verbs of a drive with this map, by name."""
    verbs = common_verbs(
        _ramps(of), "end all motion by the drive's own ramp, or where it is if it has no such bit"
    )
    if "reset" in of.control:
        verbs.append(drive_verb("clear_fault", "clear the drive's fault"))
        verbs.append(drive_verb("reset", "the same: the power of a real drive stays on"))
    return {verb.name: verb for verb in verbs}


def _ramps(of: DriveMap) -> tuple[Parameter, ...]:
    """Parameters of the ramps of a move: those that the drive has registers for, or that the daemon makes."""
    is_ours = "start" not in of.control
    rows: list[tuple[str, str, str, str, float, float]] = [
        ("velocity_rpm", "set_velocity_rpm", "largest speed on the way", "rpm", MOST_RPM, FOLLOW_RPM),
        (
            "acceleration_rpm_per_s",
            "acceleration_rpm_per_s",
            "of both ramps",
            "rpm/s",
            MOST_RPM_PER_S,
            FOLLOW_RPM_PER_S,
        ),
    ]
    found = []
    for name, register, about, unit, most, default in rows:
        if is_ours:
            found.append(Parameter(name, about, unit, 0.01, most, default))
        elif register in of.values:
            kept = f"{about}; left out: as the drive has it"
            found.append(Parameter(name, kept, unit, 0.01, most, is_optional=True))
    return tuple(found)
