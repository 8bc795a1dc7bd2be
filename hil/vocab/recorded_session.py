"""Recorded session with a board: what was sent when, and what has to come back."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any

from hil.vocab.late_dataclass import dataclass

TimedText = tuple[float, str]
"""Time in ms since power-up, and text (latin-1)."""


class SessionRefused(ValueError):
    """Error of a session that cannot be played: ``str(error)`` says why."""


@dataclass(frozen=True, kw_only=True)
class Digest:
    """Digest of a long text. Where the twin has explanations in the project's words, only ``head`` and
    ``tail`` are compared."""

    size_bytes: int
    sha256: str
    head: str = ""
    tail: str = ""


@dataclass(frozen=True, kw_only=True)
class SessionPlan:
    """Session as the kit plays it against a twin that has just got its power."""

    device: Mapping[str, Any]
    """Keys of the device in a configuration, its profile among them."""
    inputs: Sequence[TimedText]
    """Text that is sent to the first UART, ascending."""
    end_ms: float
    timelines: Mapping[str, Sequence[TimedText]]
    """Text that has to come, by UART, to the end; the first one's name is empty."""
    texts: Mapping[str, str] = field(default_factory=dict)
    """Text that has to come, whenever that is, by UART."""
    texts_from_ms: float = 0.0
    """Time from which text counts for ``texts``."""
    from_ms: float = 0.0
    """Time from which text counts for ``timelines``."""
    digests: Mapping[str, "Digest"] = field(default_factory=dict)
    """Digest of all that has to come, by UART, where a session has that instead of the text."""
    faults: Sequence[Mapping[str, Any]] = ()
    """Faults from the start, as a configuration has them; the device is called ``d``."""
    encoder: tuple[Sequence[tuple[float, int]], bool] | None = None
    """Counts of the first axis's encoder by times in ms, and whether they are joined by lines."""
    tolerance_ms: float = 1.0
    is_own_words: Callable[[str], bool] = lambda line: False
    """Tells whether a line of the twin is explanation in the project's words, for which any line will do."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Difference between a recording and its twin. ``where``: UART or signal; ``expected`` and ``got`` are
    None where there is nothing."""

    session: str
    at_ms: float | None
    where: str
    expected: str | None
    got: str | None

    def __str__(self) -> str:
        when = "" if self.at_ms is None else f" at {self.at_ms:.3f} ms"
        return f"{self.session}: {self.where}{when}: expected {self.expected!r}, got {self.got!r}"
