"""Kinds of boards, ports and bridges that exist, and how each is made."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import BaseModel

from hil.compose.framings import Framings
from hil.compose.profile_infos import ProfileInfos
from hil.config import Catalogue, DeviceConfig, PortConfig
from hil.config.port_model import SERIAL
from hil.core import Core
from hil.discovery.board_loading import Boards
from hil.discovery.board_places import find_places
from hil.discovery.buses import find_buses, find_wire_infos
from hil.discovery.installed import BRIDGES, PORTS
from hil.discovery.named_kinds import Kinds
from hil.host.regular_file import read_text
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.profile import Profile

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import Bridge, DoorPort
    from hil.vocab.desk_protocol import Desk
    from hil.vocab.framing import Framing
    from hil.vocab.line_format import LineFormat
    from hil.vocab.ports import Port, PortContext
    from hil.vocab.segment import Segment
    from hil.vocab.time import Clock


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
    boards = Boards(found.places, infos, infos.parts)
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
