"""CAN as a kind of bus: all that hil asks of it."""

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from bridges.can.bus_reports import REPORTS
from hil.vocab.bus import BusKind, Raw, WireKind

if TYPE_CHECKING:
    from hil.config import BenchConfig, Catalogue
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Finding
    from hil.sim.bench import BenchRuntime


def _model() -> type[Any]:
    from bridges.can.can_model import CanConfig

    return CanConfig


def _findings(
    config: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from bridges.can.can_findings import can_findings

    return can_findings(config, devices, real)


def _fault_places(name: str, bus: Raw, devices: "Mapping[str, ProfileInfo]") -> Mapping[str, Collection[str]]:
    from bridges.can.can_findings import fault_places

    return fault_places(name, bus, devices)


def _add(bench: "BenchRuntime", config: "BenchConfig", catalogue: "Catalogue") -> None:
    from bridges.can.can_buses import add_buses

    add_buses(bench, config, catalogue)


BUS = BusKind(
    wires=WireKind(
        key="can",
        about="CAN buses, each under a name of its own. Devices on one bus share one simulated time.",
        model=_model,
        findings=_findings,
        fault_places=_fault_places,
        info=REPORTS,
        add=_add,
    ),
    sections=(
        ("## CAN buses: `can.<name>`", "CanConfig"),
        ("## CANopen nodes: `can.<name>.nodes.<axis>`\n\nThe node id alone, or a mapping.", "CanNodeConfig"),
        ("Each of `switches`:", "SwitchConfig"),
        ("## Taps of a CAN bus: `can.<name>.taps.<name>`", "CanTapConfig"),
    ),
)
