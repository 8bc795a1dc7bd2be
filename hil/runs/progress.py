"""Progress of a run, and its end."""

from dataclasses import asdict, dataclass, field
from typing import Any

from hil.vocab.axis import How


@dataclass
class AxisReport:
    """Report on an axis. The errors are between set-point and position, over the whole run; None: unknown.
    Angles are the board's own, as the run's. ``commanded_deg``: final set-point, a real one's as it said."""

    target_deg: float
    commanded_deg: float | None = None
    position_deg: float | None = None
    error_max_deg: float | None = None
    error_rms_deg: float | None = None
    at_end: str | None = None
    """State at the end: stands, moves, off (a servo's loop), failed, or unknown (its bench is gone)."""


@dataclass
class BenchReport:
    """Report on another bench that takes part. Its clock is ``clock_offset_ns`` ahead of this one's, give or
    take ``clock_error_ns``. ``began_apart_ns``: how much later than here motion began there, by the clocks;
    None: not yet."""

    state: str
    why: str | None
    clock_offset_ns: int
    clock_error_ns: int
    began_apart_ns: int | None = None


@dataclass
class Progress:
    """Progress of a run, its state one of queued, running, done, failed or cancelled. ``step`` counts from 1,
    repetitions too. Times are simulated; ``why`` says what ended it. ``benches``: the others that take part.
    """

    run: str
    state: str = "queued"
    step: int = 0
    steps: int = 0
    step_at_ns: int | None = None
    """Time at which the step began, exactly: at any pace, and however late somebody looked."""
    started_at_ns: int | None = None
    began_at_ns: int | None = None
    """Time at which this bench's axes began to move, as they took it; ``started_at_ns`` is before that."""
    ended_at_ns: int | None = None
    planned_end_ns: int | None = None
    """Time at which the plan ends, known when it moves; waits and steppers' own ramps can make it later."""
    planned_ns: int = 0
    """Duration of its plan. It and ``gone_ns``, the part that is done, are in the plan's time at any pace."""
    gone_ns: int = 0
    pace: float = 1.0
    """Pace that it was told: 1 as planned, 0 paused."""
    why: str | None = None
    digest: str = ""
    """Digest of the run's text: names are used again, and a drawing knows its own runs by it."""
    submissions: int = 1
    """Number of times that its name was submitted: it is done once."""
    axes: dict[str, AxisReport] = field(default_factory=dict)
    benches: dict[str, BenchReport] = field(default_factory=dict)

    @property
    def is_over(self) -> bool:
        return self.state not in ("queued", "running")

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


class Ended(Exception):
    """Early end of a run: the reason, and how its axes are to stop."""

    def __init__(self, state: str, why: str, how: How) -> None:
        super().__init__(why)
        self.state = state
        self.how = how
