"""Axes as runs see them: what a plan begins with, and what an execution needs of a bench."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from hil.sim.inputs import Input

Refused = Callable[[str], None]
"""Told which verb was refused, and why."""


@dataclass(frozen=True)
class AxisNow:
    """An axis before the run: where its set-point is, and what it is. ``why_not``: it cannot take part.
    ``is_real``: a board that is told where to go over its terminal, which tells no position."""

    kind: Literal["servo", "stepper"]
    position_deg: float
    fields: Sequence[str]
    pins: Sequence[str]
    why_not: str | None = None
    is_real: bool = False


class Rows(Protocol):
    """Samples of two fields of an axis."""

    def take(self) -> Sequence[tuple[float, ...]]:
        """Rows of (at_ns, where it should be, where it is) since the last call."""

    def close(self) -> None: ...


class RunBench(Protocol):
    """What an execution needs of a bench. Axes by name."""

    @property
    def now_ns(self) -> int: ...

    def give(self, axis: str, given: Input, refused: Refused) -> None:
        """An input takes effect. ``refused`` is called when a verb that is to be done later cannot be.

        Raises:
            VerbRefused: a verb was not carried out.
        """

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        """All of one time. NaN: it is not known."""

    def failure(self, axis: str) -> str | None:
        """Why the board does nothing any more."""

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        """Two fields from now on; a real board is the run's own until the rows are closed."""
