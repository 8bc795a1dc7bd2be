"""Wire of a bench, whatever bus it is of: stations on it hear each other with its times."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from hil.vocab.late_dataclass import dataclass
from hil.vocab.monitoring import HealthProblem, Metric

if TYPE_CHECKING:
    from hil.vocab.faults import Fault
    from hil.vocab.packet_field import Fields

Report = Mapping[str, Any]
"""State and statistics of a wire, for JSON."""


class WireTap(NamedTuple):
    """Tap of a wire, and its port. ``tap``: the station, as its bus made it; ``failure``: reason why the port
    cannot go on, or None."""

    label: str
    address: str
    clients: int
    failure: str | None
    tap: Any

    def row(self) -> dict[str, Any]:
        """Row of a report."""
        return {"tap": self.label, "address": self.address, "clients": self.clients}


@dataclass(frozen=True)
class FrameKind:
    """Frames of a bus. An event, which its watchers hear, has ``at_ns``, and ``node``, by whom it is. Both
    functions import what they need when they are called: few benches have a bus."""

    packed: Callable[[Any], bytes]
    """Packs an event for a capture, as its link type says."""
    words: Callable[[], Callable[[Any], Mapping[str, Any]]]
    """Makes what describes events for the page, in their order."""
    link: int
    """Link type of a capture, by tcpdump.org's numbers: one for such frames, or one for users, 147 to 162."""
    lost: bytes = b""
    """Frame of a capture that says that some were lost; its comment says how many."""
    name: str = ""
    """Name of the bus in a capture whose link type is for users: two buses may have the same one."""
    fields: "Callable[[Iterable[str]], Fields]" = lambda texts: ()
    """Makes the fields of the last of some frames, which are in their order, each as its text. Raises
    ValueError: one is no frame."""


class Wire(Protocol):
    """Wire with stations, each under its name. Its bus says how a station joins it, and how it sends.

    Only what happens in the time of its group calls these, except what is told: looking changes nothing.
    """

    kind: str
    """Key of a configuration under which it stands."""
    name: str
    watchers: list[Callable[[Any], None]]
    """Called with what has been on the wire to its end, in order, at that time of the wire's group."""

    @property
    def frames(self) -> FrameKind | None:
        """Frames on it; None: bytes, and watchers hear each ``SegmentEvent``."""

    # ---- what it tells ----

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""

    def report(self, elapsed_ns: int, taps: Sequence[WireTap], cards: Mapping[str, Any]) -> Report:
        """State and statistics, with those of what is on it. ``notes`` are for the operator."""

    def problems(self, taps: Sequence[WireTap]) -> Iterator[HealthProblem]:
        """Present problems, those of its taps too, without failures of ports."""

    def about(self, cards: Mapping[str, Any]) -> str:
        """Words for who starts the bench; empty: none."""

    def interface(self, name: str) -> Any:
        """Source of a capture, ``hil.wire.pcapng.Interface``, of it or of a station on it."""

    # ---- faults ----

    def fault_targets(self, station: str) -> Collection[str]:
        """Targets of faults, keys of ``TARGETS``, that a station on it is; empty: that the wire is itself."""

    def fault_problem(self, fault: "Fault", active: "Iterable[Fault]") -> str | None:
        """Reason why a fault of the wire, or of a station on it, cannot be beside those that are listed."""

    def inject(self, number: int, fault: "Fault", station: str) -> None:
        """Begin a fault of the wire, or of a station on it."""

    def clear(self, number: int, fault: "Fault", station: str) -> None:
        """End a fault."""


class WireView(NamedTuple):
    """Table of ``hil status``. ``texts``: columns that stand to the left; all others to the right."""

    columns: Sequence[str]
    texts: Collection[str]
    rows: Sequence[Sequence[str]]


class WireMetric(NamedTuple):
    """Metric of wires. ``read``: answers values by labels, of a wire's name and counters."""

    metric: Metric
    read: Callable[[str, Report], Iterable[tuple[tuple[str, ...], float]]]


@dataclass(frozen=True)
class WireInfo:
    """Reports on the wires of a bus. ``key``: that of their reports in ``status``; ``label``: key of a
    report with the wire's name; ``tables``: makes tables of reports, one or more."""

    key: str
    label: str
    tables: Callable[[Sequence[Report]], Iterable[WireView]]
    metrics: Sequence[WireMetric]
    problems: Sequence[tuple[str, str]] = ()
    """Kinds of problems that such wires alone have, and the meaning of each."""


def counted(errors: Mapping[str, int]) -> str:
    """Format errors, counted by what was wrong, for a table."""
    return ", ".join(f"{count} {what}" for what, count in errors.items()) or "none"


def one_of(name: str, kind: Any, about: str, label: str, read: Callable[[Report], float]) -> WireMetric:
    """Metric with one value for each wire."""
    return WireMetric(Metric(name, kind, about, (label,)), lambda wire, told: [((wire,), read(told))])


def errors_of(name: str, about: str, label: str) -> WireMetric:
    """Metric of what was wrong on wires, by kind."""
    return WireMetric(
        Metric(name, "counter", about, (label, "kind")),
        lambda wire, told: [((wire, kind), count) for kind, count in told["errors"].items()],
    )
