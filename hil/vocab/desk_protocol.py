"""Desk of a bench, as all its doors see it, bridges and control socket, in one event loop."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import field
from enum import Enum
from fractions import Fraction
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from hil.vocab.axis import AxisState
from hil.vocab.dialogue import TextReader
from hil.vocab.late_dataclass import dataclass
from hil.vocab.operation import Operation
from hil.vocab.segment import SegmentView
from hil.vocab.verbs import Role, Verb, VerbRefused
from hil.vocab.wire import FrameKind


@dataclass(frozen=True)
class Proof:
    """Signature that a request came with, and what it signs, as they were received."""

    key: str
    payload: bytes
    attachment: bytes


@dataclass(frozen=True)
class Source:
    """Origin of a request: a name for log and status, and the role of its asker. ``door``: a door of
    ``hil.vocab.lease.DOORS`` that does not know who asks; empty: ``name`` is the asker's, unless ``user``
    is. ``via``: door by which such an asker came, if it is not ``name``; ``proof``: that it is he."""

    name: str
    role: Role
    door: str = field(default="", kw_only=True)
    user: str = field(default="", kw_only=True)
    via: str = field(default="", kw_only=True)
    proof: Proof | None = field(default=None, kw_only=True, compare=False, repr=False)

    @property
    def person(self) -> str:
        """Name of the asker; empty: nobody knows it."""
        return "" if self.door else self.user or self.name


LOCAL = Source("control socket", Role.ADMIN)
"""Source of requests at the control socket: programs that may open it may do everything."""


@dataclass(frozen=True)
class Done:
    """Result of a verb that was carried out at ``effective_at_ns``; ``answer`` is the verb's own."""

    effective_at_ns: int
    answer: Mapping[str, Any]


@dataclass(frozen=True)
class Encoded:
    """Long answer that is JSON already, made once for all who ask. ``parts``: its bytes, one behind the
    other."""

    parts: Sequence[bytes]

    def __len__(self) -> int:
        return sum(map(len, self.parts))


@dataclass(frozen=True)
class AxisField:
    """Field of an axis: name, type (f32, f64, i32, i64), unit, meaning, offset in the binary layout in bytes,
    whether it may be set from outside, and whether it belongs to the short state."""

    name: str
    type: str
    unit: str
    meaning: str
    offset: int
    is_settable: bool
    is_state: bool
    """True if the field belongs to the short state, which is told most often."""


@dataclass(frozen=True)
class DeviceInfo:
    """A device with its first axis, or another axis of one, as bridges see it. ``name``: its address;
    ``fields``: those of the axis, empty where there is none, or where it cannot be seen, as a real
    board's."""

    name: str
    profile: str
    is_real: bool
    verbs: Mapping[str, Verb]
    fields: Mapping[str, AxisField]
    inputs: Mapping[str, str] = field(default_factory=dict)
    """Pins of the axis that may be driven, each by one of its names, in the order of their numbers; and the
    field that tells the pin's level, or a bit of one, as in ``pin_levels.13``; empty where none does."""
    own_map: object | None = None
    """Map of registers of its own, a ``DriveMap`` of ``bridges.modbus.registers``; None: it has none, and its
    registers are made of its verbs and fields."""
    readers: Mapping[str, TextReader] = field(default_factory=dict)
    """Readers of its texts, by name."""

    @property
    def is_seen(self) -> bool:
        """True if the axis tells its state: a motion's end can be awaited, and its fields are published."""
        return bool(self.fields)


class AxisLook(NamedTuple):
    """Answer of ``look``: an axis at one simulated time. ``packed``: its fields in the binary layout;
    ``failed``: why its board's firmware has stopped, or None; ``told``: values of the firmware's own, by
    name."""

    packed: bytes
    motion: AxisState
    failed: str | None
    told: Mapping[str, float] = MappingProxyType({})


class Watched(Enum):
    """Kinds of things that can be watched, and the arguments of a watcher's call."""

    SAMPLES = "an axis at exact multiples of an interval: its fields in the binary layout, ``bytes``"
    PACKETS = "what was on a segment: a ``SegmentEvent``"
    BYTES = 'what passes at a port: whom it is for, "board" or "client", and the bytes'
    FRAMES = "what was on a CAN bus: an event of its ``FrameKind``"
    RUNS = "runs whose progress changes: the progress, a mapping"
    EVENTS = "what happens to the bench: the event, a mapping"
    COMMANDS = "what is asked of the bench, and its outcome: the line and its content, a text and a mapping"


class Watch(Protocol):
    """Handle of a watch."""

    @property
    def lost(self) -> int:
        """Number of samples lost for lack of room, since the beginning."""

    def flush(self) -> None:
        """Hand over the samples that wait, in time's order; all else is told as it happens."""

    def close(self) -> None:
        """End the watch."""


class BenchClock(Protocol):
    """Simulated time, and the wall's in nanoseconds since 1970."""

    def times_ns(self) -> tuple[int, int]:
        """Simulated and wall time, now."""

    def wall_ns(self, sim_ns: int) -> int:
        """Wall time at a simulated time."""


@dataclass(frozen=True)
class Description:
    """Description of a bench. ``devices``: by address, each device and each further axis of one;
    ``segments``: by name, to be looked at alone. ``buses``: frames of the CAN buses by name;
    ``ports``: addresses at which bytes pass. Devices and ports are current whenever they are looked at."""

    bench: str
    clock: BenchClock
    devices: Mapping[str, DeviceInfo]
    segments: Mapping[str, SegmentView]
    ports: Collection[str]
    operations: Mapping[str, Operation]
    buses: Mapping[str, FrameKind] = field(default_factory=dict)


class Desk(Protocol):
    """Request desk of a bench: all that a door has of it. Every refusal is a ``VerbRefused``."""

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        """Carry out an operation of the table. Answers its result, or where the table says that it takes time
        perhaps a coroutine of it. The result of what takes effect at a time is ``Done``. ``target``: a name,
        or empty for the bench.

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
        points: int = 1,
    ) -> Watch:
        """Call back with what happens from now on. ``interval_ns``: samples are taken at its multiples,
        rounded down to whole nanoseconds. ``points`` above 1: of so many times in each interval two samples
        have the smallest and the largest value of each field, in the order in which they came.

        Raises:
            VerbRefused: there is no such thing, or it, or so much, cannot be watched.
        """

    def note_refusal(
        self, source: Source, operation: str, target: str, given: Mapping[str, object], refusal: VerbRefused
    ) -> None:
        """Note for the bench's events that a door refused a request itself, as one that came too late."""

    def describe(self) -> Description:
        """Describe the bench."""
