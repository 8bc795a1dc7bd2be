"""Axes as runs see them: their state when a plan begins, and the bench that an execution needs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from hil.sim.inputs import Input

Refused = Callable[[str], None]
"""Called with the reason why a verb was refused."""


@dataclass(frozen=True)
class AxisNow:
    """Axis before the run: its set-point and its properties. ``why_not``: it cannot take part. ``is_real``: a
    real board, whose terminal takes targets and tells no position."""

    kind: Literal["servo", "stepper"]
    position_deg: float
    fields: Sequence[str]
    pins: Sequence[str]
    why_not: str | None = None
    is_real: bool = False


class Rows(Protocol):
    """Samples of two fields of an axis."""

    def take(self) -> Sequence[tuple[float, ...]]:
        """Take rows of (at_ns, set-point, position) since the last call."""

    def close(self) -> None: ...


class RunBench(Protocol):
    """Bench as an execution needs it. Axes by name."""

    @property
    def now_ns(self) -> int: ...

    def give(self, axis: str, given: Input, refused: Refused) -> None:
        """Let an input take effect. ``refused`` is called when a verb that is to be done later cannot be.

        Raises:
            VerbRefused: a verb was not carried out.
        """

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        """Values of fields, all of one time. NaN: unknown."""

    def failure(self, axis: str) -> str | None:
        """Reason why the board does nothing any more, or None."""

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        """Begin samples of two fields; a real board is the run's own until the rows are closed."""
