"""The whole motion of a run, made before anything moves: phrases that go by the clock, waits in between."""

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from struct import Struct

from hil.runs.axes import AxisNow
from hil.runs.run_document import RunDocument, WaitUntil
from hil.vocab.path import PathPiece

_PIECE = Struct("<q4d")


@dataclass(frozen=True)
class Event:
    """A verb that is carried out ``at_ns`` after its phrase's start."""

    at_ns: int
    axis: str
    verb: str
    parameters: Mapping[str, float | str]


@dataclass(frozen=True)
class Phrase:
    """What goes by the clock from one common start. ``paths``: of servos, from the start to
    ``duration_ns``. ``marks``: when which step begins. After it the ``steppers`` have to stand (and real
    servos to have confirmed their last set-point), and what ``wait`` says has to be."""

    duration_ns: int
    paths: Mapping[str, tuple[PathPiece, ...]]
    events: tuple[Event, ...]
    marks: tuple[tuple[int, int], ...]
    steppers: frozenset[str] = frozenset()
    wait: WaitUntil | None = None


@dataclass(frozen=True)
class Plan:
    """A run that can be done. ``steps``: how many, repetitions counted."""

    run: RunDocument
    phrases: tuple[Phrase, ...]
    steps: int
    ends_deg: Mapping[str, float]
    axes: Mapping[str, AxisNow]

    def digest(self) -> str:
        """The same for the same motion, to the bit."""
        total = sha256()
        for phrase in self.phrases:
            timing = (phrase.duration_ns, phrase.marks, sorted(phrase.steppers), phrase.wait)
            total.update(repr((timing, phrase.events)).encode())
            for axis, path in phrase.paths.items():
                total.update(axis.encode())
                for piece in path:
                    total.update(
                        _PIECE.pack(piece.duration_ns, piece.r, piece.per_s, piece.per_s2, piece.per_s3)
                    )
        return total.hexdigest()
