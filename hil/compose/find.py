"""Kinds of boards, ports and bridges that exist, and how each is made."""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from hil.compose.framings import Framings
from hil.config import Catalogue, ConfigError, DeviceConfig, PortConfig, ProfileInfo, profile_from_yaml
from hil.config.port_model import SERIAL
from hil.core import Core
from hil.discovery.board_loading import Boards, Named
from hil.discovery.board_places import YAML, BoardPlace, BoardPlaces, find_places
from hil.discovery.installed import BRIDGES, PORTS
from hil.discovery.named_kinds import Kinds, find_buses, find_wire_infos
from hil.host.regular_file import read_regular, read_text
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.bus import MapKind
from hil.vocab.problem import not_text
from hil.vocab.profile import Profile

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import Bridge, DoorPort
    from hil.vocab.desk_protocol import Desk
    from hil.vocab.framing import Framing
    from hil.vocab.line_format import LineFormat
    from hil.vocab.ports import Port, PortContext
    from hil.vocab.segment import Segment
    from hil.vocab.time import Clock


_profile = lru_cache(profile_from_yaml)  # by text: a bench of the test kit is made in 1 ms, not in 25


class ProfileInfos(Mapping[str, ProfileInfo]):
    """Descriptions of boards by name, in the order of the names. One that cannot be used is not there, and is
    in ``refused`` of the places once it was asked for. ``maps``: the kind of maps of registers."""

    def __init__(self, found: BoardPlaces, maps: MapKind | None) -> None:
        self._found, self._maps = found, maps
        self._read: dict[str, ProfileInfo | None] = {}

    def __getitem__(self, name: str) -> ProfileInfo:
        if name not in self._read and name in self._found.places:
            self._read[name] = None if name in self._found.refused else self._info(self._found.places[name])
        if (info := self._read.get(name)) is None:
            raise KeyError(name)
        return info

    def __iter__(self) -> Iterator[str]:
        return (name for name in sorted(self._found.places) if name in self)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def parts(self, name: str) -> Named:
        """Names of a board's UARTs and axes. Raises KeyError as for the board."""
        info = self[name]
        return tuple(info.uarts), tuple(info.named_axes)

    def programmed(self, name: str) -> Profile | None:
        """Profile of a board that its processor or its table alone makes one; None: it has neither."""
        if (table := self[name].dialogue) is not None:
            from hil.compose.instrument_profile import instrument_profile

            return instrument_profile(self[name].first_uart, table)
        if self[name].processor is None:
            return None
        from hil.compose.programmed_profile import programmed_profile

        return programmed_profile(tuple(self[name].uarts))

    def _info(self, place: BoardPlace) -> ProfileInfo | None:
        try:
            text = (place.folder / YAML).read_text()
            return _profile(text, place.folder, place.name, self._maps)
        except ConfigError as error:
            problems = error.problems
        except UnicodeDecodeError as error:
            problems = [not_text(str(place.folder / YAML), error)]
        except OSError as error:
            remedy = "a board is described in this file: hil profile new writes one"
            problems = [place.problem(YAML, error.strerror or "it cannot be read", remedy)]
        self._found.refused[place.name] = problems
        return None


def _ports(extra: Mapping[str, type[BaseModel]] | None = None) -> Kinds:
    return Kinds("virtual_ports", PORTS, "port", extra)


def _bridges() -> Kinds:
    return Kinds("bridges", BRIDGES, "bridge")


def find_catalogue(
    extra_ports: Mapping[str, type[BaseModel]] | None = None, path: Sequence[Path] = ()
) -> Catalogue:
    """Find all boards and kinds of ports and bridges. ``extra_ports`` are the caller's own; ``path`` are
    folders in which there are more boards. A board or kind that cannot be used is reported when it is asked
    for."""
    path = tuple(folder.resolve() for folder in path)
    found = find_places(path)
    buses, problems = find_buses()
    infos = ProfileInfos(found, next((bus.maps for bus in buses if bus.maps), None))
    boards = Boards(found.places, infos, infos.parts, infos.programmed)
    return Catalogue(
        infos,
        _ports(extra_ports),
        _bridges(),
        boards,
        found.refused,
        path,
        found.wrong_paths,
        lambda folders: find_catalogue(extra_ports, folders),
        _refused_motors,
        read_text,
        read_regular,
        Framings(boards),
        buses,
        problems,
        find_wire_infos(),
    )


def find_boards() -> Mapping[str, Profile]:
    """Find what all boards of this installation say of themselves, by their names."""
    return find_catalogue().boards


def _refused_motors(plans: Mapping[str, AxisPlan]) -> dict[str, str]:
    """Try motors in a core of their own: how stiff one may be is the integrator's to say."""
    core, refused = Core(len(plans) or 1), {}
    for name, plan in plans.items():
        try:
            core.open_axis(core.native.group_open(0), plan)
        except ValueError as error:
            refused[name] = str(error)
    return refused


def make_bridge(kind: str, options: BaseModel, desk: "Desk") -> "Bridge":
    """Make the bridge that a configuration describes, not yet open. Raises BridgeError: a package that it
    needs cannot be imported."""
    from hil.vocab.bridge_protocol import BridgeError

    try:
        bridge: Bridge = _bridges().attribute(kind, "make")(options, desk)
    except ImportError as error:
        raise BridgeError(f"bridges.{kind}: {error}; install what is missing") from None
    return bridge


def make_memory_door(kind: str, options: BaseModel, desk: "Desk", time: object) -> Any:
    """Make the door that a bridge has in a bench in memory, not yet open: no socket is opened for it.
    ``time``: the time of those who wait there, a ``hil.testing.doors.door_time.DoorTime``. Raises Unusable: a
    bridge of this kind has none."""
    return _bridges().attribute(kind, "in_memory")(options, desk, time)


def make_port(config: PortConfig, context: "PortContext") -> "Port":
    """Make the port that a configuration describes, not yet open."""
    port: Port = _ports().attribute(config.kind, "make")(config.options, context)
    return port


def make_door_port(wanted: "DoorPort", context: "PortContext") -> "Port":
    """Make a port that a bridge wants, not yet open."""
    options = _ports()[wanted.kind](**wanted.options)
    return make_port(PortConfig(kind=wanted.kind, options=options), context)


def serial_port_config(device: DeviceConfig) -> PortConfig:
    """Configuration of the port that a real board is at."""
    options = _ports()[SERIAL](url=device.at, baud=device.baud, echo=device.echo)
    return PortConfig(kind=SERIAL, options=options)


def bridge_reference(kind: str) -> str:
    """Part of the reference that a bridge writes, Markdown."""
    text: str = _bridges().attribute(kind, "reference")()
    return text


def make_segment(name: str, clock: "Clock", framing: "Framing", line_format: "LineFormat") -> "Segment":
    """Make a wire without stations, on which things happen at times of ``clock``."""
    kind = next(bus.segments for bus in find_buses()[0] if bus.segments)
    return kind.make(clock, framing, line_format, name)
