"""Modbus as a kind of bus: all that hil asks of it."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hil.vocab.bus import BusKind, DriveAddress, DriveKind, MapKind, NodeKind, NodeLine, Raw
from hil.vocab.faults import MODBUS_NODE

if TYPE_CHECKING:
    from bridges.modbus.modbus_model import ModbusConfig
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Document, Finding, KeyPath
    from hil.drives.drive_control import DriveControl
    from hil.drives.real_drive import DrivePace
    from hil.sim.bench import BenchRuntime
    from hil.vocab.desk_protocol import DeviceInfo
    from hil.vocab.framing import Framing
    from hil.vocab.line_format import LineFormat


def _model() -> type[Any]:
    from bridges.modbus.modbus_model import ModbusConfig

    return ModbusConfig


def _findings(
    segments: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from bridges.modbus.modbus_findings import modbus_findings

    return modbus_findings(segments, devices, real)


def _framing(line_format: "LineFormat") -> "Framing":
    from bridges.modbus.protocol.rtu_framing import modbus_rtu

    return modbus_rtu(line_format)


def _add(bench: "BenchRuntime", config: "ModbusConfig", line: NodeLine) -> None:
    from bridges.modbus.segment_nodes import add_nodes

    add_nodes(bench, config, line)


def _examples() -> Iterable[str]:
    from bridges.modbus.drives.modbus_drive_address import EXAMPLES

    return EXAMPLES.values()


def _address(text: str) -> DriveAddress:
    from bridges.modbus.drives.modbus_drive_address import modbus_drive_address

    return modbus_drive_address(text)


def _place_differs(name: str, first: Any, other: Any) -> tuple[str, str] | None:
    from bridges.modbus.drives.modbus_drive_address import place_differs

    return place_differs(name, first, other)


def _make_drive(
    name: str, address: Any, device: object, own_map: Any, pace: "DrivePace", now_ns: Callable[[], int]
) -> "DriveControl":
    from bridges.modbus.drives.map_control import MapControl
    from bridges.modbus.drives.register_control import RegisterControl
    from bridges.modbus.drives.register_drive import RegisterDrive, RegisterSpec

    control = RegisterControl if own_map.version == 1 else MapControl
    return control(RegisterDrive(RegisterSpec(name, address, own_map, pace), now_ns))


def _map_model() -> type[Any]:
    from bridges.modbus.maps.drive_map_model import MapText

    return MapText


def _map_findings(
    document: "Document", path: "KeyPath", parameters: Collection[str] | None
) -> "Iterable[Finding]":
    from bridges.modbus.maps.drive_map_text import map_findings

    return map_findings(document, path, parameters)


def _read_map(text: str, file: str, parameters: Collection[str] | None) -> object:
    from bridges.modbus.maps.drive_map_text import read_map_text

    return read_map_text(text, file, parameters)


def _registers(info: "DeviceInfo") -> Mapping[str, Any]:
    from bridges.modbus.registers.map_rows import map_rows
    from bridges.modbus.registers.units import unit_of

    return map_rows(unit_of(info).map)


def _own_map(of: Any) -> object:
    from bridges.modbus.maps.drive_map_text import drive_map_of

    return drive_map_of(of)


def _reference(twins: "Iterable[DeviceInfo]") -> str:
    from bridges.modbus.registers.map_rows import register_maps

    return register_maps({info.profile: _registers(info) for info in twins})


BUS = BusKind(
    nodes=NodeKind(
        key="modbus",
        about="Axes on this wire as nodes of Modbus RTU, a mapping.",
        model=_model,
        axes_key="units",
        findings=_findings,
        framing=_framing,
        add=_add,
        has_other_formats=True,
        fault_target=MODBUS_NODE,
    ),
    drives=DriveKind(
        protocol="Modbus",
        scheme="modbus",
        over="Modbus",
        about=" For a drive with a"
        " `map`, its address on Modbus: `modbus+tcp://host:502?unit=1`, or"
        " `modbus+rtu:///dev/ttyUSB0?baud=19200&format=8E1&unit=3`; drives on one line have one path.",
        example="modbus+tcp://host:port?unit=1 or modbus+rtu:///dev/ttyUSB0?unit=1",
        line="line",
        number="unit",
        examples=_examples,
        address=_address,
        place_differs=_place_differs,
        make=_make_drive,
        no_keys={"units": "a drive with a map has them there, as scale"},
    ),
    maps=MapKind(
        about="Map of a Modbus drive's registers: the path of a file, from the configuration's folder,"
        " or the map itself; null: that of its profile.",
        model=_map_model,
        findings=_map_findings,
        read=_read_map,
        registers=_registers,
        own_map=_own_map,
    ),
    sections=(
        ("## Modbus nodes: `segments.<name>.modbus`", "ModbusConfig"),
        (
            "## Map of a drive's registers: `devices.<name>.map`\n\nIn a file of its own, or written out."
            " Bits are `{input: 4, bit: 0}`, `{holding: 20, bit: 0}`, `{discrete: 7}` or `{coil: 3}`; values"
            " `{input: 0, type: i32, scale: 0.01}` or `{holding: ...}`. No two have a register or a bit in"
            " common.",
            "MapText",
        ),
        ("`identity`:", "IdentityText"),
        ("`status`:", "StatusText"),
        ("`control`:", "ControlText"),
        ("Each entry:", "PlaceText"),
        ("Each of `cells`:", "CellText"),
        ("Each of `commands`:", "ByValueText"),
        ("`mode`:", "ModeText"),
        ("Each of `states`:", "StateRowText"),
        ("Each of `blocks`:", "BlockText"),
        ("`moves`:", "MovesText"),
        ("`protocol`:", "ProtocolText"),
    ),
    reference=_reference,
)
