"""Verbs of real drives, of one on Modbus those that its map allows. They have the words of a twin's."""

from bridges.modbus.registers.drive_map import DriveMap
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Effect, Verb

ANGLE_DEG, MOST_RPM, MOST_RPM_PER_S = 1e9, 1e5, 1e7
FOLLOW_RPM, FOLLOW_RPM_PER_S = 60.0, 600.0
"""Ramps of a move that the daemon makes for a drive that only follows set-points."""


def map_verbs(of: DriveMap) -> dict[str, Verb]:
    """Verbs of a drive with this map, by name."""
    verbs = _verbs(_ramps(of), "end all motion by the drive's own ramp, or where it is if it has no such bit")
    if "reset" in of.control:
        verbs.append(_verb("clear_fault", "clear the drive's fault"))
        verbs.append(_verb("reset", "the same: the power of a real drive stays on"))
    return {verb.name: verb for verb in verbs}


def can_verbs() -> dict[str, Verb]:
    """Verbs of a CANopen drive, by name."""
    kept = "left out: as the drive has it"
    ramps = (
        Parameter(
            "velocity_rpm", f"largest speed on the way; {kept}", "rpm", 0.01, MOST_RPM, is_optional=True
        ),
        Parameter(
            "acceleration_rpm_per_s",
            f"of both ramps; {kept}",
            "rpm/s",
            0.01,
            MOST_RPM_PER_S,
            is_optional=True,
        ),
    )
    verbs = _verbs(ramps, "end all motion by the drive's quick stop, and hold the shaft there")
    method = Parameter(
        "method", f"number of CiA 402 (6098h); {kept}", "", -128, 127, is_whole=True, is_optional=True
    )
    verbs.append(_verb("home", "find the origin by the drive's homing", method))
    verbs.append(_verb("clear_fault", "clear the drive's fault"))
    verbs.append(_verb("reset", "let the drive start again, as after power-up (NMT reset node)"))
    return {verb.name: verb for verb in verbs}


def _verbs(ramps: tuple[Parameter, ...], stops: str) -> list[Verb]:
    return [
        _verb("enable", "switch the loop on, which holds the shaft where it is"),
        _verb("disable", "switch the loop off"),
        _verb(
            "move_abs",
            "go to an angle with ramps",
            Parameter("position_deg", "where to", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        _verb(
            "move_rel",
            "go by an angle with ramps, from where the last motion leads",
            Parameter("angle_deg", "how far", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        _verb("stop", stops),
    ]


def _verb(name: str, about: str, *parameters: Parameter) -> Verb:
    return Verb(name, about, parameters, effect=Effect.ENDS)


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
