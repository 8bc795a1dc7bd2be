"""States of a bench, the three words for how it is, and the problems that make it late."""

from dataclasses import dataclass

OK, LATE, FAILED = "ok", "late", "failed"
STATES = {
    OK: "answers are right and in time",
    LATE: "all works; answers are right, and come late",
    FAILED: "something does not work",
}
"""States of a bench, and the meaning of each."""
LATE_KINDS = ("real_time", "wakes", "loop")
"""Kinds of problems that make a bench late; all others are failures."""


@dataclass(frozen=True)
class HealthProblem:
    """Problem of a bench. ``about`` is the device, port or segment, empty for the whole bench."""

    kind: str
    about: str
    what: str
    remedy: str
