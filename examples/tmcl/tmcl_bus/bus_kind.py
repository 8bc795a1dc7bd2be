"""TMCL as a kind of bus: all that hil asks of it."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hil.vocab.bus import BusKind, DriveAddress, DriveKind, NodeKind, NodeLine, Raw
from hil.vocab.framing import Framing
from hil.vocab.line_format import LineFormat

if TYPE_CHECKING:
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Finding
    from hil.drives.drive_control import DriveControl
    from hil.drives.real_drive import DrivePace
    from hil.sim.bench import BenchRuntime
    from tmcl_bus.tmcl_model import TmclConfig


def _model() -> type[Any]:
    from tmcl_bus.tmcl_model import TmclConfig

    return TmclConfig


def _findings(
    segments: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from tmcl_bus.tmcl_findings import tmcl_findings

    return tmcl_findings(segments, devices, real)


def _framing(line_format: LineFormat) -> Framing:
    from tmcl_bus.framing import TMCL_FRAMING

    return TMCL_FRAMING


def _add(bench: "BenchRuntime", config: "TmclConfig", line: NodeLine) -> None:
    from tmcl_bus.segment_nodes import add_nodes

    add_nodes(bench, config, line)


def _examples() -> Iterable[str]:
    from tmcl_bus.drives.tmcl_drive_address import EXAMPLE

    return (EXAMPLE,)


def _address(text: str) -> DriveAddress:
    from tmcl_bus.drives.tmcl_drive_address import tmcl_drive_address

    return tmcl_drive_address(text)


def _place_differs(name: str, first: Any, other: Any) -> tuple[str, str] | None:
    from tmcl_bus.drives.tmcl_drive_address import place_differs

    return place_differs(name, first, other)


def _make_drive(
    name: str, address: Any, device: object, own_map: object, pace: "DrivePace", now_ns: Callable[[], int]
) -> "DriveControl":
    from tmcl_bus.drives.tmcl_control import TmclControl
    from tmcl_bus.drives.tmcl_drive import TmclDrive

    return TmclControl(TmclDrive(name, address, pace, now_ns))


BUS = BusKind(
    nodes=NodeKind(
        key="tmcl",
        about="Axes on this wire as modules of TMCL, a mapping.",
        model=_model,
        axes_key="modules",
        findings=_findings,
        framing=_framing,
        add=_add,
    ),
    drives=DriveKind(
        protocol="TMCL",
        scheme="tmcl",
        over="a serial line",
        about=" For a module of TMCL, its address: `tmcl+serial:///dev/ttyUSB0?baud=9600&module=1`.",
        example="tmcl+serial:///dev/ttyUSB0?module=1",
        line="line",
        number="module",
        examples=_examples,
        address=_address,
        place_differs=_place_differs,
        make=_make_drive,
        profile_drive="tmcl",
        no_keys={
            "units": "a TMCL module tells its microsteps itself",
            "map": "a TMCL module has no registers that a map says",
        },
    ),
    sections=(("## TMCL modules: `segments.<name>.tmcl`", "TmclConfig"),),
)
