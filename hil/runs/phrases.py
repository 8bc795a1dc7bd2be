"""The phrases of a plan, as its steps add to them."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

from hil.core.trajectory import Trajectory
from hil.runs.axes import AxisNow
from hil.runs.plan import Event, Phrase
from hil.runs.run_document import WaitUntil
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_S


class Phrases:
    """Those that have ended, and the one that steps are added to. ``position_deg``: where the axes are after
    the last step."""

    def __init__(self, axes: Mapping[str, AxisNow]) -> None:
        self.ended: list[Phrase] = []
        self.position_deg = {name: axis.position_deg for name, axis in axes.items()}
        self.servos = [name for name, axis in axes.items() if axis.kind == "servo"]
        self._real = {name for name, axis in axes.items() if axis.is_real}
        self._begin()

    def _begin(self) -> None:
        self._at_ns = 0
        self._pieces: dict[str, list[PathPiece]] = {name: [] for name in self.servos}
        self._events: list[Event] = []
        self._marks: list[tuple[int, int]] = []
        self._steppers: set[str] = set()

    def end(self, wait: WaitUntil | None = None) -> None:
        """What was planned so far goes by one clock."""
        if self._marks or wait:
            paths = {
                name: (*pieces, PathPiece(0, self.position_deg[name]))
                for name, pieces in self._pieces.items()
                if any(piece.per_s or piece.per_s2 or piece.per_s3 for piece in pieces)
            }
            events = tuple(sorted(self._events, key=lambda event: event.at_ns))
            stand = frozenset(self._steppers | (self._real & set(paths)))
            self.ended.append(Phrase(self._at_ns, paths, events, tuple(self._marks), stand, wait))
        self._begin()

    def mark(self, step: int) -> None:
        """A step begins."""
        self._marks.append((self._at_ns, step))

    def happen(self, axis: str, verb: str, parameters: Mapping[str, float | str]) -> None:
        """A verb is carried out as the step begins."""
        self._events.append(Event(self._at_ns, axis, verb, parameters))
        if verb == "move_abs":
            self._steppers.add(axis)

    def move(
        self,
        targets_deg: Mapping[str, float],
        duration_ns: int,
        moved: Sequence[str] = (),
        trajectory: Trajectory | None = None,
    ) -> None:
        """Axes go to their targets; of them the servos ``moved``, in this order, by ``trajectory``. All other
        servos stand."""
        for name in self.servos:
            pieces = _pieces(trajectory, moved.index(name)) if trajectory and name in moved else []
            if duration_ns:
                self._pieces[name] += pieces or [PathPiece(duration_ns, self.position_deg[name])]
        self._at_ns += duration_ns
        self.position_deg |= targets_deg
        if not self._steppers.isdisjoint(targets_deg):
            self.end()


def _pieces(trajectory: Trajectory, axis: int) -> list[PathPiece]:
    segments = trajectory.segments(axis)
    times_ns = [*(round(segment.start_s * NS_PER_S) for segment in segments), trajectory.duration_ns]
    return [
        PathPiece(
            to_ns - from_ns,
            segment.position_deg,
            segment.velocity_deg_per_s,
            segment.acceleration_deg_per_s2,
            segment.jerk_deg_per_s3,
        )
        for segment, (from_ns, to_ns) in zip(segments, pairwise(times_ns), strict=True)
        if to_ns > from_ns
    ]
