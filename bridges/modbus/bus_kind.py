"""Modbus as a kind of bus: all that hil asks of it."""

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hil.vocab.bus import BusKind, NodeKind, NodeLine, Raw
from hil.vocab.faults import MODBUS_NODE
from hil.vocab.framing import Framing
from hil.vocab.line_format import LineFormat

if TYPE_CHECKING:
    from bridges.modbus.modbus_model import ModbusConfig
    from hil.config.catalogue import ProfileInfo
    from hil.config.document import Finding
    from hil.sim.bench import BenchRuntime


def _model() -> type[Any]:
    from bridges.modbus.modbus_model import ModbusConfig

    return ModbusConfig


def _findings(
    segments: Raw, devices: "Mapping[str, ProfileInfo]", real: Collection[str]
) -> "Iterable[Finding]":
    from bridges.modbus.modbus_findings import modbus_findings

    return modbus_findings(segments, devices, real)


def _framing(line_format: LineFormat) -> Framing:
    from bridges.modbus.protocol.rtu_framing import modbus_rtu

    return modbus_rtu(line_format)


def _add(bench: "BenchRuntime", config: "ModbusConfig", line: NodeLine) -> None:
    from bridges.modbus.segment_nodes import add_nodes

    add_nodes(bench, config, line)


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
    sections=(("## Modbus nodes: `segments.<name>.modbus`", "ModbusConfig"),),
)
