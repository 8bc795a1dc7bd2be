"""A transaction of a line's master: one command to one node, with its tries and its outcome."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class Outcome(StrEnum):
    """Outcome of a transaction: what is known of a command."""

    DONE = "done"
    """The node has it, once."""
    REFUSED = "refused"
    """The node has refused each try: it was not carried out."""
    NOT_KNOWN = "not known"
    """No answer came: it was carried out once, or not at all."""
    SENT = "sent"
    """It went out to all, and nobody answers that."""
    NOT_SENT = "not sent"
    """It never went out: it was not carried out."""


@dataclass(eq=False)
class Transaction:
    """Command to a node. ``frame``: its bytes on the line; ``answer_bytes``: length of the longest answer, 0:
    nobody answers; ``may_repeat``: twice is as good as once."""

    unit: int
    command: bytes
    frame: bytes
    answer_bytes: int
    may_repeat: bool
    tries: int
    is_urgent: bool = False
    rest_ns: int = 0
    """Time behind a time-out in which a late answer is waited for, and the node gets nothing else."""
    moves: bool = False
    """True if it begins a motion, about which the node may send a packet right behind its answer."""
    ended: Callable[["Transaction"], None] | None = None
    """Called when the outcome is known."""

    outcome: Outcome | None = None
    why: str = ""
    answer: Any = None
    sent: int = 0
    """Number of times that it went out."""
    refusals: int = 0
    refusal: str = ""
    """Reason that the node gave for refusing it."""
    silences: int = 0
    early: int = 0
    """Number of answers that came earlier than the line can carry them; they do not count."""
    queued_ns: int = 0
    first_ns: int = 0
    """Time at which it first went out."""
    sent_ns: int = 0
    """Time at which it last went out."""
    ended_ns: int = 0
    believed_after: int = field(default=0, repr=False)
    """Number of answers that may be late ones to something before: those are not believed."""

    @property
    def is_over(self) -> bool:
        return self.outcome is not None

    @property
    def round_trip_ns(self) -> int:
        """Time from the last try to its answer."""
        return self.ended_ns - self.sent_ns

    def end(self, outcome: Outcome, why: str, now_ns: int) -> None:
        """End it; from then on nothing changes."""
        if self.outcome is None:
            self.outcome, self.why, self.ended_ns = outcome, why, now_ns
            if self.ended:
                self.ended(self)
