"""Scores of a session that was typed at a board and at its twin."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

from hil.testing.parity.answer_match import AnswerMatch, AnswerMatcher, Parting
from hil.testing.parity.typed_session import StepAnswer, TypedSession, TypedStep

FIRST, LAST, STOOD = "first byte", "last byte", "end of motion"


@dataclass(frozen=True, kw_only=True)
class TimesApart:
    """Times of one event at board and twin. ``late_ms``: how much later the board is, less what host and
    adapter add; negative: earlier."""

    board_ms: float
    twin_ms: float
    late_ms: float
    within_ms: float

    @property
    def is_near(self) -> bool:
        return abs(self.late_ms) <= self.within_ms + 1e-9

    @property
    def share(self) -> float:
        """1 within the tolerance; twice as far apart: a half."""
        return 1.0 if self.is_near else self.within_ms / abs(self.late_ms)


@dataclass(frozen=True, kw_only=True)
class StepScore:
    """Score of a command. ``percent``: mean of its bytes, its times and its end of motion."""

    number: int
    step: TypedStep
    board: StepAnswer
    twin: StepAnswer
    match: AnswerMatch
    """Comparison of their bytes."""
    times: Mapping[str, TimesApart]
    """Times that both have: of the first and last byte, and of the end of the motion."""
    never_stood: tuple[str, ...]
    """Sides that did not tell in time that they stand: ``board``, ``twin``."""

    @property
    def parting(self) -> Parting | None:
        return self.match.parting

    @property
    def late(self) -> dict[str, TimesApart]:
        """Times that are further apart than the tolerance."""
        return {name: each for name, each in self.times.items() if not each.is_near}

    @property
    def is_equal(self) -> bool:
        return not (self.parting or self.late or self.never_stood)

    @property
    def percent(self) -> float:
        parts = [self.match.percent / 100]
        if shares := [each.share for name, each in self.times.items() if name != STOOD]:
            parts.append(min(shares))
        if self.step.stands:
            parts.append(self.times[STOOD].share if STOOD in self.times else 0.0)
        return 100 * sum(parts) / len(parts)


@dataclass(frozen=True, kw_only=True)
class SessionScore:
    """Score of a session."""

    steps: Sequence[StepScore]
    """Commands so far, without those that prepare."""
    of: int
    """Number of commands that the session has."""
    host_ms: float
    """Time that host and adapter add to each answer: by how much the quickest one is later than the twin's,
    and not counted."""
    origins: Mapping[str, tuple[float, float]]
    """First numbers of board and twin, of those that count from there."""

    @property
    def equal(self) -> int:
        return sum(each.is_equal for each in self.steps)

    @property
    def percent(self) -> float:
        """Mean of all commands; one that was not typed has 0."""
        return sum(each.percent for each in self.steps) / self.of if self.of else 100.0

    @property
    def times_ms(self) -> list[float]:
        """Distances of the times of first and last bytes, ascending."""
        return sorted(
            abs(at.late_ms) for each in self.steps for name, at in each.times.items() if name != STOOD
        )


def percentile(ascending: Sequence[float], percent: float) -> float | None:
    """Value that so many per cent of the values do not exceed; None: there is none."""
    if not ascending:
        return None
    return ascending[max(ceil(len(ascending) * percent / 100) - 1, 0)]


def scored(
    session: TypedSession,
    board: Sequence[StepAnswer],
    twin: Sequence[StepAnswer],
    is_own_words: Callable[[str], bool],
    tolerance_ms: float,
    host_ms: float | None = None,
) -> SessionScore:
    """Score a session, as far as the board has come. ``host_ms``: as ``SessionScore`` has it; None: it is
    found."""
    rows = [*zip(session.steps, board, twin, strict=False)]
    if host_ms is None:
        host_ms = _host_ms(rows)
    matcher = AnswerMatcher(session.measured, is_own_words)
    steps: list[StepScore] = []
    for step, own, other in rows:
        if step.prepares:
            continue
        match = matcher.match(own.text, other.text)
        steps.append(
            StepScore(
                number=len(steps) + 1,
                step=step,
                board=own,
                twin=other,
                match=match,
                times=_times(step, own, other, tolerance_ms, host_ms),
                never_stood=_never_stood(step, own, other),
            )
        )
    of = sum(not step.prepares for step in session.steps)
    return SessionScore(steps=steps, of=of, host_ms=host_ms, origins=matcher.origins)


def _host_ms(rows: Sequence[tuple[TypedStep, StepAnswer, StepAnswer]]) -> float:
    later = [
        own.first_ms - other.first_ms
        for _, own, other in rows
        if own.first_ms is not None and other.first_ms is not None
    ]
    return max(min(later, default=0.0), 0.0)


def _times(
    step: TypedStep, own: StepAnswer, other: StepAnswer, tolerance_ms: float, host_ms: float
) -> dict[str, TimesApart]:
    asked_ms = step.stands.every_ms if step.stands and step.stands.types else 0.0
    events = (
        (FIRST, own.first_ms, other.first_ms, tolerance_ms),
        (LAST, own.last_ms, other.last_ms, tolerance_ms),
        (STOOD, own.stood_ms, other.stood_ms, tolerance_ms + asked_ms),
    )
    return {
        name: TimesApart(
            board_ms=board_ms, twin_ms=twin_ms, late_ms=board_ms - twin_ms - host_ms, within_ms=within_ms
        )
        for name, board_ms, twin_ms, within_ms in events
        if board_ms is not None and twin_ms is not None
    }


def _never_stood(step: TypedStep, own: StepAnswer, other: StepAnswer) -> tuple[str, ...]:
    if not step.stands:
        return ()
    sides = (("board", own), ("twin", other))
    return tuple(name for name, answer in sides if answer.stood_ms is None)
