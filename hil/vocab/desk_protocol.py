"""The desk: what a door has of a bench, a bridge as well as the control socket, all in one event loop."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any, Protocol

from hil.vocab.operation import Operation
from hil.vocab.verbs import Role, Verb


@dataclass(frozen=True)
class Source:
    """Who asks: a name for log and status, and what the asker may do."""

    name: str
    role: Role


LOCAL = Source("control socket", Role.ADMIN)
"""Who may open the socket may do all."""


@dataclass(frozen=True)
class Done:
    """A verb was carried out at ``effective_at_ns``; ``answer`` is the verb's own."""

    effective_at_ns: int
    answer: Mapping[str, Any]


@dataclass(frozen=True)
class AxisField:
    """A value of an axis: its name, type (f32, f64, i32, i64), unit and meaning, its offset in the binary
    layout in bytes, whether it may be set from outside, and whether it is told most often."""

    name: str
    type: str
    unit: str
    meaning: str
    offset: int
    is_settable: bool
    is_state: bool
    """It belongs to the short state that is told most often."""


@dataclass(frozen=True)
class DeviceInfo:
    """A device as bridges see it. ``fields`` is empty for a real board, whose axis nobody sees."""

    name: str
    profile: str
    is_real: bool
    verbs: Mapping[str, Verb]
    fields: Mapping[str, AxisField]


class Watched(Enum):
    """What can be watched, and what its watcher is called with."""

    SAMPLES = "an axis at exact multiples of an interval: its fields in the binary layout, ``bytes``"
    PACKETS = "what was on a segment: a ``SegmentEvent``"
    BYTES = 'what passes at a port: whom it is for, "board" or "client", and the bytes'
    RUNS = "runs whose progress changes: the progress, a mapping"


class Watch(Protocol):
    """Something that is watched."""

    @property
    def lost(self) -> int:
        """How many samples found no room since the beginning."""

    def take(self) -> None:
        """Call now with the samples that wait, in time's order; all else comes as it happens."""

    def close(self) -> None:
        """No more."""


class BenchClock(Protocol):
    """Simulated time, and the wall's in nanoseconds since 1970."""

    def times_ns(self) -> tuple[int, int]:
        """Both, now."""

    def wall_ns(self, sim_ns: int) -> int:
        """The wall's at a simulated time."""


@dataclass(frozen=True)
class Description:
    """What a bench is. ``devices`` and ``segments`` are those of the moment at which they are looked at;
    ``ports``: names of what bytes pass at, now."""

    bench: str
    clock: BenchClock
    devices: Mapping[str, DeviceInfo]
    segments: Collection[str]
    ports: Sequence[str]
    operations: Mapping[str, Operation]


class Desk(Protocol):
    """All that a door has of a bench. Everything is refused with ``VerbRefused``."""

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        """Carry an operation of the table out: its answer, or where the table says that it takes time maybe a
        coroutine of it. What takes effect at a time answers ``Done``. ``target``: a name, or empty for the
        bench.

        Raises:
            VerbRefused: it was not carried out; a coroutine raises it when it is awaited.
        """

    def watch(
        self,
        source: Source,
        what: Watched,
        target: str,
        call: Callable[..., object],
        *,
        interval_ns: int | Fraction = 0,
    ) -> Watch:
        """Call with what happens from now on. ``interval_ns``: of samples, at whose multiples they are taken,
        rounded down to whole nanoseconds.

        Raises:
            VerbRefused: there is no such thing, or it, or so much, cannot be watched.
        """

    def describe(self) -> Description:
        """What there is."""
