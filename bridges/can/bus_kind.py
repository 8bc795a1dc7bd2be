"""CAN as a kind of bus: all that hil asks of it."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hil.vocab.bus import BusKind, DriveAddress, DriveKind, DriveOption, FaceKind, LogKind, Raw, WireKind
from hil.vocab.monitoring import Metric
from hil.vocab.wire import Report, WireInfo, WireMetric, WireView, counted, errors_of, one_of

if TYPE_CHECKING:
    from pathlib import Path

    from bridges.can.cards.bench_bus import BenchBus
    from bridges.can.testing.can_faces import CanBusFace
    from bridges.can.testing.served_can import ServedCanBus
    from hil.config import BenchConfig, Catalogue
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Document, Finding
    from hil.drives.drive_control import DriveControl
    from hil.drives.real_drive import DrivePace
    from hil.sim.bench import BenchRuntime
    from hil.sim.client_tap import ClientTap
    from hil.testing import Bench, ServedBench
    from hil.testing.faces import TapFace
    from hil.vocab.desk_protocol import DeviceInfo
    from hil.vocab.problem import Problem


_OF_NODES = ("id", "state", "sent", "heard", "TEC", "REC", "errors", "drive")
_COUNTS = ("sent", "heard", "transmit_errors", "receive_errors")


def _tables(reports: Sequence[Report]) -> Iterable[WireView]:
    """Table of buses, and that of the controllers on them."""
    buses, nodes = list[Sequence[str]](), list[Sequence[str]]()
    for each in reports:
        load = f"{each['load_percent']:.1f}%"
        frames, errors = str(each["frames"]), counted(each["errors"])
        buses.append((each["bus"], str(each["bit_rate"]), load, frames, errors))
        for name, node in each["nodes"].items():
            drive, wrong = each["drives"].get(name, {}), str(sum(node["errors"].values()))
            counts = [str(node[key]) for key in _COUNTS]
            state = str(drive.get("state", ""))
            nodes.append((name, str(drive.get("id", "")), node["state"], *counts, wrong, state))
    yield WireView(("bus", "bit/s", "load", "frames", "errors"), ("bus", "errors"), buses)
    yield WireView(("node", *_OF_NODES), ("node", "state", "drive"), nodes)


def _of_nodes(name: str, kind: Any, about: str, read: Callable[[Report], float]) -> WireMetric:
    return WireMetric(
        Metric(name, kind, about, ("node",)),
        lambda _, told: [((node,), read(counters)) for node, counters in told["nodes"].items()],
    )


REPORTS = WireInfo("buses", "bus", _tables, (
    one_of("hil_can_frames_total", "counter", "frames on a CAN bus", "bus", lambda told: told["frames"]),
    errors_of("hil_can_errors_total", "errors on a CAN bus", "bus"),
    one_of("hil_can_load_ratio", "gauge", "share of the time that the bus was busy", "bus",
           lambda told: told["load_percent"] / 100),
    _of_nodes("hil_can_node_sent_total", "counter", "frames of a node or a tap", lambda of: of["sent"]),
    _of_nodes("hil_can_node_transmit_errors", "gauge", "its transmit error counter",
              lambda of: of["transmit_errors"]),
    _of_nodes("hil_can_node_receive_errors", "gauge", "its receive error counter",
              lambda of: of["receive_errors"]),
    _of_nodes("hil_can_node_bus_off", "gauge", "1 if it is bus-off",
              lambda of: int(of["state"] == "bus-off")),
), (("bus", "a client has opened a tap of a CAN bus with a wrong bit rate"),))  # fmt: skip


def _model() -> type[Any]:
    from bridges.can.can_model import CanConfig

    return CanConfig


def _findings(
    config: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from bridges.can.can_findings import can_findings

    return can_findings(config, devices, real)


def _read(
    wires: Raw, document: "Document", read_bytes: "Callable[[Path], bytes] | None"
) -> "tuple[Raw, Iterable[Finding], Iterable[Problem]]":
    nodes = (bus.get("nodes") for bus in wires.values() if isinstance(bus, dict))
    each = (node for of in nodes if isinstance(of, dict) for node in of.values())
    if not any(isinstance(node, dict) and node.get("eds") is not None for node in each):
        return wires, (), ()
    from bridges.can.maker_files import read_files

    return read_files(wires, document, read_bytes)


def _fault_places(name: str, bus: Raw, devices: "Mapping[str, ProfileInfo]") -> Mapping[str, Collection[str]]:
    from bridges.can.can_findings import fault_places

    return fault_places(name, bus, devices)


def _add(bench: "BenchRuntime", config: "BenchConfig", catalogue: "Catalogue") -> None:
    from bridges.can.can_buses import add_buses

    add_buses(bench, config, catalogue)


def _examples() -> Iterable[str]:
    from bridges.can.drives.can_drive_address import EXAMPLES

    return EXAMPLES.values()


def _address(text: str) -> DriveAddress:
    from bridges.can.drives.can_drive_address import can_drive_address

    return can_drive_address(text)


def _place_differs(name: str, first: Any, other: Any) -> tuple[str, str] | None:
    from bridges.can.drives.can_drive_address import place_differs

    return place_differs(name, first, other)


def _units() -> type[Any]:
    from bridges.can.can_model import UnitsConfig

    return UnitsConfig


def _make_drive(
    name: str, address: Any, device: Any, own_map: None, pace: "DrivePace", now_ns: Callable[[], int]
) -> "DriveControl":
    from bridges.can.canopen.master.drive_units import GivenUnits
    from bridges.can.drives.can_control import CanControl
    from bridges.can.drives.can_drive import CanDrive, CanSpec

    given = device.units.model_dump() if device.units else {}
    return CanControl(CanDrive(CanSpec(name, address, pace, GivenUnits(**given)), now_ns))


def _face(bench: "Bench", runtime: "BenchRuntime", wire: "BenchBus") -> "CanBusFace":
    from bridges.can.testing.can_faces import CanBusFace

    return CanBusFace(bench, runtime, wire)


def _served_face(bench: "ServedBench", name: str) -> "ServedCanBus":
    from bridges.can.testing.served_can import ServedCanBus

    return ServedCanBus(bench, name)


def _tap_face(runtime: "BenchRuntime", tap: "ClientTap") -> "TapFace":
    from bridges.can.cards.can_tap import CanTap
    from bridges.can.testing.can_faces import CanTapFace

    assert isinstance(tap, CanTap)
    return CanTapFace(runtime, tap)


def _logs() -> LogKind:
    from bridges.can.can_logs import LOGS

    return LOGS


def _reference(twins: "Iterable[DeviceInfo]") -> str:
    from bridges.can.canopen.cia402.object_rows import reference

    return reference()


BUS = BusKind(
    reference=_reference,
    wires=WireKind(
        key="can",
        about="CAN buses, each under a name of its own. Devices on one bus share one simulated time.",
        model=_model,
        findings=_findings,
        read=_read,
        fault_places=_fault_places,
        info=REPORTS,
        add=_add,
        kit=FaceKind(what="CAN bus", face=_face, tap_face=_tap_face, served_face=_served_face),
    ),
    drives=DriveKind(
        protocol="CANopen",
        scheme="can",
        over="CAN",
        about=" For a"
        " CANopen drive, its node on a bus: `can+socketcan://can0?node=5`,"
        " `can+slcan:///dev/ttyACM0?bitrate=1000000&node=5` (or `//host:port`; `baud=115200` is the adapter's"
        " speed), `can+udp_multicast://239.74.163.2?node=5`; drives on one bus share it. With `&master=127`"
        " they watch a heartbeat of the daemon, and stop without it.",
        example="can+socketcan://can0?node=5",
        line="bus",
        number="node",
        examples=_examples,
        address=_address,
        place_differs=_place_differs,
        make=_make_drive,
        profile_drive="canopen",
        keys={
            "units": DriveOption(
                "Units of position, speed and acceleration of a real CANopen drive; null: those that the"
                " drive tells.",
                _units,
                "only a CANopen drive has units of its own",
                "a twin says them itself",
            )
        },
        no_keys={"map": "a CANopen drive says itself what is where"},
        alike={"setpoint_rate_Hz": "write the same for both: a bus has one SYNC"},
    ),
    logs=_logs,
    sections=(
        ("## CAN buses: `can.<name>`", "CanConfig"),
        ("## CANopen nodes: `can.<name>.nodes.<axis>`\n\nThe node id alone, or a mapping.", "CanNodeConfig"),
        ("Each of `switches`:", "SwitchConfig"),
        ("Each of `objects` that is a mapping:", "ObjectLineConfig"),
        ("## Taps of a CAN bus: `can.<name>.taps.<name>`", "CanTapConfig"),
    ),
)
