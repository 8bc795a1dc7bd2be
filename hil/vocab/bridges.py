"""Bridges: doors for other protocols, and what they may use of a daemon, all in its event loop."""

from collections.abc import Callable, Collection, Coroutine, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

from hil.vocab.metrics import Reading
from hil.vocab.segment import SegmentEvent
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


class Samples(Protocol):
    """Samples of axes at exact multiples of an interval, in the binary layout."""

    @property
    def lost(self) -> int:
        """How many found no room since the beginning."""

    def take(self) -> Sequence[bytes]:
        """Those since the last call, in time's order."""

    def close(self) -> None:
        """No more."""


class BridgeHost(Protocol):
    """The daemon."""

    @property
    def bench(self) -> str: ...
    @property
    def devices(self) -> Mapping[str, DeviceInfo]: ...
    @property
    def segments(self) -> Sequence[str]: ...
    @property
    def ports(self) -> Sequence[str]: ...

    def times_ns(self) -> tuple[int, int]:
        """Simulated time, and the wall's since 1970, now."""

    def wall_ns(self, sim_ns: int) -> int:
        """The wall's time since 1970 at a simulated one."""

    async def wait_until_done(self, device: str, done: Done, at_most_s: float) -> str | None:
        """Until what a verb began has ended: "ended", or "interrupted" if by something else; None: not
        within so many seconds of simulated time."""

    def packed(self, device: str) -> bytes:
        """All fields of an axis in the binary layout, now."""

    def do_now(self, source: Source, device: str, verb: str, given: Mapping[str, object]) -> Done | None:
        """As ``do``, for a twin; None for a real board, whose answer takes its time."""

    def state(self, device: str) -> Mapping[str, float]:
        """All fields of an axis, now. Raises VerbRefused: a real board."""

    def sample(self, device: str, interval_ns: int | Fraction) -> Samples:
        """Sample an axis from now on, at the multiples of the interval, rounded down to whole nanoseconds.

        Raises:
            VerbRefused: a real board, or such an interval, or so much, cannot be watched.
        """

    def do(
        self, source: Source, device: str, verb: str, given: Mapping[str, object]
    ) -> Coroutine[Any, Any, Done]:
        """Carry out a verb.

        Raises:
            VerbRefused: it was not.
        """

    def set_field(self, source: Source, device: str, name: str, value: object) -> Done:
        """Set a settable field of an axis.

        Raises:
            VerbRefused: there is none, or not this value.
        """

    def fault(self, source: Source, target: str, given: Mapping[str, object]) -> Mapping[str, Any]:
        """Begin a fault (``fault`` and its parameters), or end one (``clear``: its number, or all).

        Raises:
            VerbRefused: there is no such fault, or it cannot be there.
        """

    def submit_run(
        self, source: Source, text: str
    ) -> Mapping[str, Any] | Coroutine[Any, Any, Mapping[str, Any]]:
        """Submit a multi-axis run; its progress, to be awaited where axes of other benches take part.

        Raises:
            VerbRefused: it cannot be done, or not now, or not by this source; with all problems.
        """

    def part_of_run(
        self, source: Source, name: str, given: Mapping[str, Any]
    ) -> Coroutine[Any, Any, Mapping[str, Any]]:
        """What another bench, which leads a run, asks of this one's part of it. Raises VerbRefused."""

    def run_progress(self, name: str) -> Mapping[str, Any] | None:
        """How a run does; None: there is none of this name."""

    def run_names(self) -> Sequence[str]:
        """Those that are remembered, in the order of their submission."""

    def cancel_run(self, source: Source, name: str, how: object) -> Mapping[str, Any]:
        """End a run with "grace" or "prejudice"; its progress. Raises VerbRefused."""

    def on_run(self, call: Callable[[Mapping[str, Any]], None]) -> Callable[[], None]:
        """Call with a run's progress when it changes; answers what ends it."""

    def segment_stats(self, segment: str) -> Mapping[str, Any]:
        """Its counters, as ``status`` has them."""

    def health(self) -> Mapping[str, Any]:
        """``state`` (ok or degraded) and its ``problems``, ticks, missed wakes, devices that have failed."""

    def metrics(self) -> Iterator[Reading]:
        """All metrics with their values, each metric read when its turn comes; others may run in between."""

    def on_packets(self, segment: str, call: Callable[[SegmentEvent], None]) -> Callable[[], None]:
        """Call with what was on the line; answers what ends it."""

    def on_bytes(self, port: str, call: Callable[[str, bytes], None]) -> Callable[[], None]:
        """Call with what passes at a port, and whom it is for, "board" or "client"; answers what ends it."""


class Bridge(Protocol):
    """One door."""

    async def open(self) -> None:
        """Begin. Raises BridgeError."""

    async def close(self) -> None:
        """End, and leave nothing behind."""

    async def devices_changed(self, names: Collection[str]) -> None:
        """These devices of the host were added, taken away or exchanged, with their ports. Raises
        BridgeError."""

    def status(self) -> Mapping[str, Any]:
        """What ``hil status`` shows of it: ``root``, ``listen``, ``connect``, ``links``, ``insecure``,
        where that is not all ``risk`` (what whoever reaches it may do), and counters."""


class BridgeError(Exception):
    """A bridge cannot be opened: ``str(error)`` says why and what to do."""
