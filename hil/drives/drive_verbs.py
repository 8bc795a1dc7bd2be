"""Verbs that all real drives have. They have the words of a twin's."""

from collections.abc import Sequence

from hil.vocab.parameters import Parameter
from hil.vocab.verbs import Effect, Verb

ANGLE_DEG, MOST_RPM, MOST_RPM_PER_S = 1e9, 1e5, 1e7
FOLLOW_RPM, FOLLOW_RPM_PER_S = 60.0, 600.0
"""Ramps of a move that the daemon makes for a drive that only follows set-points."""


def common_verbs(ramps: Sequence[Parameter], stops: str) -> list[Verb]:
    """Verbs that all drives have. ``ramps``: parameters of a move beside its target; ``stops``: the end of a
    motion by this kind of drive, in words."""
    return [
        drive_verb("enable", "switch the loop on, which holds the shaft where it is"),
        drive_verb("disable", "switch the loop off"),
        drive_verb(
            "move_abs",
            "go to an angle with ramps",
            Parameter("position_deg", "where to", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        drive_verb(
            "move_rel",
            "go by an angle with ramps, from where the last motion leads",
            Parameter("angle_deg", "how far", "deg", -ANGLE_DEG, ANGLE_DEG),
            *ramps,
        ),
        drive_verb("stop", stops),
    ]


def drive_verb(name: str, about: str, *parameters: Parameter) -> Verb:
    """Verb of a drive. All of them end a run that has it."""
    return Verb(name, about, parameters, effect=Effect.ENDS)
