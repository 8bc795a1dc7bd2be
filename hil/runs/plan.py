"""Plan of a run's whole motion, made before anything moves: phrases that go by the clock, and waits."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from struct import Struct

from hil.core.trajectory import Trajectory
from hil.runs.run_document import RunDocument, WaitUntil
from hil.vocab.axis import Axis, AxisNow
from hil.vocab.path import Path, PathPiece

_PIECE = Struct("<q4d")


@dataclass(frozen=True)
class Move:
    """Motion of an axis to an angle by ramps of its own, ``at_ns`` after its phrase's start."""

    at_ns: int
    axis: str
    position_deg: float
    velocity_rpm: float

    def give(self, axis: Axis, start_ns: int) -> None:
        """Give the motion to its axis, in a phrase that starts then. Raises VerbRefused."""
        axis.move(self.position_deg, self.velocity_rpm, start_ns + self.at_ns)


@dataclass(frozen=True)
class Level:
    """Level of an axis's input from ``at_ns`` after its phrase's start."""

    at_ns: int
    axis: str
    pin: str
    level: int

    def give(self, axis: Axis, start_ns: int) -> None:
        """Give the level to its axis, as ``Move.give``."""
        axis.set_pin(self.pin, self.level, start_ns + self.at_ns)


@dataclass(frozen=True)
class Phrase:
    """Motion that goes by the clock from one common start. ``paths``: those of axes that follow them, from
    the start to ``duration_ns``. ``marks``: the beginning of each step. After it the axes ``awaited``, which
    alone know when they end, have to be at their ends, and the condition of ``wait`` has to be met."""

    duration_ns: int
    paths: Mapping[str, tuple[PathPiece, ...]]
    events: tuple[Move | Level, ...]
    marks: tuple[tuple[int, int], ...]
    awaited: frozenset[str] = frozenset()
    wait: WaitUntil | None = None
    keeps_path: bool = False
    """True if a controlled stop stays on the path: axes that draw."""


@dataclass(frozen=True)
class Plan:
    """Plan of a run that can be done. ``steps``: their number, repetitions counted."""

    run: RunDocument
    phrases: tuple[Phrase, ...]
    steps: int
    ends_deg: Mapping[str, float]
    axes: Mapping[str, AxisNow]

    def part(self, of: Collection[str]) -> "Plan":
        """The plan with the paths of these axes alone."""
        phrases = (replace(phrase, paths=_some(phrase.paths, of)) for phrase in self.phrases)
        return replace(self, phrases=tuple(phrases))

    def digest(self, of: Collection[str]) -> str:
        """Digest of the timing and of the motion of these axes: the same for the same motion, to the bit."""
        total = sha256()
        for phrase in self.phrases:
            timing = (phrase.duration_ns, phrase.marks, sorted(phrase.awaited & set(of)), phrase.wait)
            events = [event for event in phrase.events if event.axis in of]
            total.update(repr((timing, events)).encode())
            for axis, path in _some(phrase.paths, of).items():
                total.update(axis.encode())
                for piece in path:
                    total.update(
                        _PIECE.pack(piece.duration_ns, piece.r, piece.per_s, piece.per_s2, piece.per_s3)
                    )
        return total.hexdigest()


def _some(paths: Mapping[str, Path], of: Collection[str]) -> dict[str, Path]:
    return {axis: path for axis, path in paths.items() if axis in of}


class Phrases:
    """Phrases of a plan, as its steps add to them. ``position_deg``: positions after the last step; ``of``:
    axes whose paths are wanted."""

    def __init__(self, axes: Mapping[str, AxisNow], of: Collection[str]) -> None:
        self.ended: list[Phrase] = []
        self._of = of
        self.position_deg = {name: axis.position_deg for name, axis in axes.items()}
        self.followers = [name for name, axis in axes.items() if axis.follows_paths]
        self._silent = {name for name, axis in axes.items() if axis.is_awaited or not axis.tells_position}
        self._begin()

    def _begin(self) -> None:
        self._at_ns = 0
        self._pieces: dict[str, list[PathPiece]] = {name: [] for name in self.followers if name in self._of}
        self._events: list[Move | Level] = []
        self._marks: list[tuple[int, int]] = []
        self._sent: set[str] = set()

    def end(self, wait: WaitUntil | None = None, *, keeps_path: bool = False) -> None:
        """End the phrase: what was planned so far goes by one clock."""
        if self._marks or wait:
            paths = {
                name: (*pieces, PathPiece(0, self.position_deg[name]))
                for name, pieces in self._pieces.items()
                if any(piece.per_s or piece.per_s2 or piece.per_s3 for piece in pieces)
            }
            events = tuple(sorted(self._events, key=lambda event: event.at_ns))
            awaited = frozenset(self._sent | (self._silent & set(paths)))
            self.ended.append(
                Phrase(self._at_ns, paths, events, tuple(self._marks), awaited, wait, keeps_path)
            )
        self._begin()

    def mark(self, step: int) -> None:
        self._marks.append((self._at_ns, step))

    def send(self, axis: str, position_deg: float, velocity_rpm: float) -> None:
        """Send an axis that follows no paths to an angle as the step begins."""
        self._events.append(Move(self._at_ns, axis, position_deg, velocity_rpm))
        self._sent.add(axis)

    def drive(self, axis: str, pin: str, level: int) -> None:
        """Drive an axis's input as the step begins."""
        self._events.append(Level(self._at_ns, axis, pin, level))

    def move(
        self,
        targets_deg: Mapping[str, float],
        duration_ns: int,
        moved: Sequence[str] = (),
        trajectory: Trajectory | None = None,
    ) -> None:
        """Move axes to their targets, ``moved`` of those that follow paths, in order, by ``trajectory``; the
        others of them stand."""
        for name in self._pieces:
            pieces = trajectory.pieces(moved.index(name)) if trajectory and name in moved else []
            if duration_ns:
                self._pieces[name] += pieces or [PathPiece(duration_ns, self.position_deg[name])]
        self._at_ns += duration_ns
        self.position_deg |= targets_deg
        if not self._sent.isdisjoint(targets_deg):
            self.end()

    def follow(
        self, targets_deg: Mapping[str, float], duration_ns: int, pieces: Mapping[str, Sequence[PathPiece]]
    ) -> None:
        """Let axes follow pieces to their targets, and the others stand; a phrase of its own."""
        for name in self._pieces:
            self._pieces[name] += pieces.get(name) or [PathPiece(duration_ns, self.position_deg[name])]
        self._at_ns += duration_ns
        self.position_deg |= targets_deg
        self.end(keeps_path=True)
