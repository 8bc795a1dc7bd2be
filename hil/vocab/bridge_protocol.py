"""Contract of a bridge: ``Bridge``, ``BenchDoor`` if it reaches other benches too, and ``PortDoor`` if it has
ports of its own. Its options may be ``BridgeOptions`` and ``BusOptions``, for more than their form."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

from hil.vocab.desk_protocol import Source
from hil.vocab.late_dataclass import dataclass
from hil.vocab.ports import Port

PROTOCOL_VERSION = 1
"""Version of what benches say to each other in runs. It grows when a bench of the version before could not
take part; one that tells none, as hil 0.2 and before, has 0."""


class Bridge(Protocol):
    """Door of a bench for another protocol."""

    async def open(self) -> None:
        """Open the bridge. Raises BridgeError."""

    async def close(self) -> None:
        """Close the bridge, and leave nothing behind."""

    async def devices_changed(self, names: Collection[str]) -> None:
        """Note that these devices were added, removed or exchanged, with their ports. Raises BridgeError."""

    def status(self) -> Mapping[str, Any]:
        """Fields of ``hil status``: ``root``, ``listen``, ``connect``, ``links``, ``insecure``, ``risk``
        (what programs that reach it may do, where that is not everything), and counters."""


class BridgeError(Exception):
    """Error of a bridge that cannot be opened: ``str(error)`` says why and what to do. ``option``: path to
    the one of its options that is in the way."""

    def __init__(self, why: str, option: tuple[str | int, ...] = ()) -> None:
        super().__init__(why)
        self.option = option


@dataclass(frozen=True)
class Answered:
    """Answer of another bench, and when the question left and it came, both in this bench's wall time."""

    content: Mapping[str, Any]
    asked_ns: int
    heard_ns: int


class BenchGone(Exception):
    """Error of another bench that does not answer: ``str(error)`` says which and for how long."""


class BenchProblem(NamedTuple):
    """Problem of a bench behind a door, as another one has its name: what is so, and what helps."""

    bench: str
    what: str
    remedy: str


@runtime_checkable
class BenchDoor(Protocol):
    """Bridge that reaches other benches."""

    async def ask_bench(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        """Send a command below another bench's keys, on behalf of ``source``.

        Raises:
            BenchGone: no answer in time.
            VerbRefused: it was not carried out there.
        """

    async def stop_others(self, source: Source, how: str, timeout_s: float) -> Sequence[dict[str, Any]]:
        """Stop all that moves on the other benches, on behalf of ``source``; answers a row for each, as
        ``hil.net.site_stop.Row``. Raises VerbRefused: nothing was sent."""

    async def benches(self) -> Sequence[str]:
        """Names of the other benches that are joined now."""

    def name_clash(self) -> BenchProblem | None:
        """Clash of this bench's name with another's, as it is now."""


class DoorPort(NamedTuple):
    """Port that a bridge wants to have: its name, its kind and that kind's options. ``place``: path to the
    option of the bridge that says where it is."""

    name: str
    kind: str
    options: Mapping[str, Any]
    place: tuple[str | int, ...] = ()


@runtime_checkable
class PortDoor(Protocol):
    """Bridge with ports of its own, as well."""

    def wanted_ports(self) -> Sequence[DoorPort]:
        """Ports that it wants."""

    def take_ports(self, ports: Sequence[Port]) -> None:
        """Take the ports that were wanted, in that order, before ``open``. None of them is open."""


class OptionProblem(NamedTuple):
    """Mistake in a bridge's options, which have the right form. ``path``: of the option, from the bridge's
    on; ``at_key``: the key is wrong, not its value."""

    path: tuple[str | int, ...]
    message: str
    remedy: str
    at_key: bool = False


@runtime_checkable
class BridgeOptions(Protocol):
    """Options of a bridge that can be wrong beside others of the configuration, or as to their files."""

    def wanted_ports(self) -> Sequence[DoorPort]:
        """Ports that the bridge will want, so that no other port is in the same place."""

    def problems(self, axes: Collection[str]) -> Iterable[OptionProblem]:
        """Mistakes on this bench. ``axes``: addresses of its devices and of their further axes."""

    def file_problems(self) -> Iterable[OptionProblem]:
        """Mistakes in files that the options name. They are read."""


@runtime_checkable
class BusOptions(Protocol):
    """Options of a bridge that name CAN buses."""

    def bus_problems(self, buses: Collection[str]) -> Iterable[OptionProblem]:
        """Mistakes on a bench with these buses."""
