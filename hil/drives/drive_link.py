"""State of the link to one drive, and waits between attempts: pure, times are arguments.

A drive is ``away`` while the place that it is at cannot be reached, ``silent`` while the place is there and
the drive has not answered yet, or not any more, and ``there``. Each time that it comes to be there begins a
new ``session``: what was asked in the one before is neither believed to be done nor sent again.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

Lines = TypeVar("Lines")


class SharedLines:
    """Lines of each kind of drive, made when the first of that kind begins."""

    def __init__(self) -> None:
        self._made: dict[type[Any], Any] = {}

    def of(self, kind: type[Lines]) -> Lines:
        """Give the one object of a class that has the lines of a kind."""
        if kind not in self._made:
            self._made[kind] = kind()
        made: Lines = self._made[kind]
        return made


URGENT, IN_TURN = 0, 1
"""Orders of requests: verbs before set-points and polls, which take turns."""


class PlaceLost(Exception):
    """Loss of the place; ``str(error)`` says why. What was asked may have been done, or not."""


class NoAnswer(Exception):
    """End of the time for an answer."""


class Garbled(Exception):
    """Answer that does not fit its request."""


class Denied(Exception):
    """Answer that says why the drive does not do what it was asked."""


class Stale(Exception):
    """Request that was not sent, as nobody wants it any more: the drive was lost meanwhile."""


ASKING = (PlaceLost, NoAnswer, Garbled, Denied, Stale)
"""Errors of a request."""


@dataclass(frozen=True)
class Reading:
    """Answer of a drive to a request that was sent at ``at_ns``, simulated time. ``values`` are by the names
    of a map, set-point and parameters included; ``bits`` by dotted names, as in ``status.moving``; ``words``:
    what stood in the answer, as its bus has it."""

    at_ns: int
    values: Mapping[str, float] = field(default_factory=dict)
    bits: Mapping[str, bool] = field(default_factory=dict)
    words: Mapping[Any, Mapping[int, int]] = field(default_factory=dict)


LOST_AFTER = 3
"""Number of requests in a row without an answer after which a drive is lost."""
FIRST_WAIT_NS, LONGEST_WAIT_NS = 100_000_000, 5_000_000_000
"""Wait before the second attempt, and the longest: each is twice as long as the one before."""
ROUND_TRIPS = 512
"""Number of the last round trips of which the percentiles are told."""

State = Literal["away", "silent", "there"]


@dataclass
class Waits:
    """Waits between attempts, each twice as long as the one before."""

    longest_ns: int = LONGEST_WAIT_NS
    _next_ns: int = FIRST_WAIT_NS

    def take_ns(self) -> int:
        """Wait after an attempt that failed."""
        wait_ns, self._next_ns = self._next_ns, min(self._next_ns * 2, self.longest_ns)
        return wait_ns

    def reset(self) -> None:
        """Begin again, after an attempt that succeeded."""
        self._next_ns = FIRST_WAIT_NS


@dataclass
class Counters:
    """Counters of a drive since it is configured."""

    polls: int = 0
    """Complete readings of its state."""
    writes: int = 0
    """Writes that it confirmed."""
    time_outs: int = 0
    """Requests that were not answered in time."""
    garbled: int = 0
    """Answers that did not fit their request."""
    exceptions: int = 0
    """Answers that were exceptions."""
    connects: int = 0
    """Times that it came to be there; all but the first are reconnects."""

    @property
    def reconnects(self) -> int:
        return max(self.connects - 1, 0)


@dataclass
class DriveLink:
    """Link to one drive."""

    counters: Counters = field(default_factory=Counters)
    state: State = "away"
    why: str = "it was not asked yet"
    """Reason why it is not there."""
    is_tried: bool = False
    """True once it is known whether the drive is there: ``why`` is more than that it was not asked yet."""
    session: int = 0
    """Number of the session; those before have ended for good."""
    answered_ns: int | None = None
    """Wall time of its last answer, of a clock that only goes forward."""
    waits: Waits = field(default_factory=lambda: Waits(2_000_000_000))
    _unanswered: int = 0
    _trips_ns: deque[int] = field(default_factory=lambda: deque(maxlen=ROUND_TRIPS), repr=False)

    @property
    def is_there(self) -> bool:
        return self.state == "there"

    def place_lost(self, why: str) -> None:
        """Note that its place is not there."""
        self.state, self.why, self.is_tried = "away", why, True

    def place_found(self) -> None:
        """Note that its place is there: the drive is asked next."""
        if self.state == "away":
            self.state, self.why, self._unanswered = "silent", "it has not answered yet", 0
            self.waits.reset()

    def greeted(self) -> None:
        """Note that all was read that has to be known of it: it is there."""
        self.state, self.why, self.is_tried = "there", "", True
        self.session += 1
        self.counters.connects += 1
        self.waits.reset()

    def answered(self, now_ns: int, round_trip_ns: int) -> None:
        """Note an answer that fits, an exception included."""
        self._unanswered = 0
        self.answered_ns = now_ns
        self._trips_ns.append(round_trip_ns)

    def refused(self, why: str) -> None:
        """Note that it does not let itself be read: it is not used."""
        self.state, self.why, self.is_tried = "silent", why, True

    def unanswered(self, what: str) -> None:
        """Note a request without an answer, or with one that does not fit; ``what`` says which."""
        self._unanswered += 1
        self.is_tried = True
        if self.state == "silent":
            self.why = what
        elif self._unanswered >= LOST_AFTER and self.state == "there":
            self.state, self.why = "silent", f"{what}, {self._unanswered} times in a row"

    def age_ns(self, now_ns: int) -> int | None:
        """Time since its last answer; None: there was none."""
        return None if self.answered_ns is None else now_ns - self.answered_ns

    def round_trip_ns(self, part: float) -> int | None:
        """Percentile of the last round trips, as 0.5 for the median; None: there was none."""
        if not self._trips_ns:
            return None
        ordered = sorted(self._trips_ns)
        return ordered[min(int(len(ordered) * part), len(ordered) - 1)]
