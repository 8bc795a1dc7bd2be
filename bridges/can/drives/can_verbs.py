"""Verbs of a real CANopen drive."""

from hil.drives.drive_verbs import MOST_RPM, MOST_RPM_PER_S, common_verbs, drive_verb
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Verb


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
    verbs = common_verbs(ramps, "end all motion by the drive's quick stop, and hold the shaft there")
    method = Parameter(
        "method", f"number of CiA 402 (6098h); {kept}", "", -128, 127, is_whole=True, is_optional=True
    )
    verbs.append(drive_verb("home", "find the origin by the drive's homing", method))
    verbs.append(drive_verb("clear_fault", "clear the drive's fault"))
    verbs.append(drive_verb("reset", "let the drive start again, as after power-up (NMT reset node)"))
    return {verb.name: verb for verb in verbs}
