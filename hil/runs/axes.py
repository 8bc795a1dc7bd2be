"""Axes as runs see them: what a plan begins with, and what an execution needs of a bench."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from hil.sim.inputs import Input


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

    def give(self, axis: str, given: Input) -> None:
        """An input takes effect. Raises VerbRefused: a verb was not carried out."""

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        """All of one time. NaN: it is not known."""

    def failure(self, axis: str) -> str | None:
        """Why the board does nothing any more."""

    def refusals(self, axis: str) -> Sequence[str]:
        """Of verbs that were to be carried out later, since the last call."""

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        """Two fields from now on; a real board is the run's own until the rows are closed."""


class Named:
    """A ``RunBench`` whose axes a run knows by other names, as ``lathe/m1`` for ``m1``."""

    def __init__(self, bench: RunBench, devices: Mapping[str, str]) -> None:
        self._bench = bench
        self._devices = devices

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def give(self, axis: str, given: Input) -> None:
        self._bench.give(self._devices[axis], given)

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        return self._bench.fields(self._devices[axis], names)

    def failure(self, axis: str) -> str | None:
        return self._bench.failure(self._devices[axis])

    def refusals(self, axis: str) -> Sequence[str]:
        return self._bench.refusals(self._devices[axis])

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        return self._bench.sample(self._devices[axis], signals, interval_ns)
