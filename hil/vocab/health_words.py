"""States of a bench, the three words for how it is, and the problems that make it late."""

OK, LATE, FAILED = "ok", "late", "failed"
STATES = {
    OK: "answers are right and in time",
    LATE: "all works; answers are right, and come late",
    FAILED: "something does not work",
}
"""States of a bench, and the meaning of each."""
LATE_KINDS = ("real_time", "wakes", "loop")
"""Kinds of problems that make a bench late; all others are failures."""
