"""Builder of the Modbus nodes of a segment."""

from functools import partial

from bridges.modbus.card.modbus_node import ModbusNode
from bridges.modbus.card.register_server import CardAxis
from bridges.modbus.modbus_model import MODBUS, ModbusConfig
from bridges.modbus.registers.registers_protocol import device_identity
from bridges.modbus.registers.units import unit_of
from hil.config.station_names import node_name
from hil.sim.bench import BenchRuntime
from hil.sim.settable import setting_problem
from hil.sim.twin import Twin
from hil.sim.twin_info import info_of
from hil.vocab.address import address_of
from hil.vocab.bus import NodeLine
from hil.vocab.time import NS_PER_MS


def add_nodes(bench: BenchRuntime, config: ModbusConfig, line: NodeLine) -> None:
    """Put the nodes of a segment on it, in the order of the configuration."""
    for axis, unit in config.units.items():
        owner, part = address_of(axis)
        is_low_first = config.word_order == "low_first"
        card = _card_axis(bench, bench.devices[owner], part, line, is_low_first=is_low_first)
        name = node_name(card.device.axes.label(owner, part), MODBUS)
        response_ns = round(config.response_ms * NS_PER_MS)
        node = ModbusNode(name, unit, card, line.segment, line.group, baud=line.baud, response_ns=response_ns)
        bench.add_card(node)


def _card_axis(
    bench: BenchRuntime, device: Twin, part: str, line: NodeLine, *, is_low_first: bool
) -> CardAxis:
    label, short = device.axes.label(device.name, part), device.axes.short(part)
    info = info_of(device, short, line.boards[device.profile])
    return CardAxis(
        device,
        short,
        lambda: unit_of(info, is_low_first=is_low_first),
        device_identity(unit_of(info).map, bench.name, line.version),
        partial(bench.apply_unlogged, label),
        lambda field, value: setting_problem(bench.faults, device, field, value, part),
    )
