"""Builder of CAN buses with their nodes and taps."""

from hil.compose.find import make_can_bus
from hil.config.can_model import CanConfig, CanNodeConfig
from hil.config.station_names import CANOPEN, node_name
from hil.sim.bench import BenchRuntime
from hil.sim.can.bench_bus import BenchBus
from hil.sim.can.can_tap import CanTap
from hil.sim.can.canopen_card import CanOpenCard
from hil.sim.group import Group
from hil.vocab.address import Address, address_of


def add_bus(bench: BenchRuntime, name: str, config: CanConfig) -> None:
    """Put a bus into the bench, with its nodes and taps in the order of the configuration."""
    members = config.members()
    group = bench.roster.group_of(members[0]) if members else bench.open_group()
    bus = make_can_bus(group, name, config.bit_rate)
    bench.roster.add_bus(bus, group)
    for axis, node in config.nodes.items():
        _add_node(bench, axis, node, bus, group)
    for tap in config.taps:
        bench.roster.add_can_tap(CanTap(str(Address(name, tap)), bus.bus, group), group)


def _add_node(bench: BenchRuntime, axis: str, config: CanNodeConfig, bus: BenchBus, group: Group) -> None:
    owner, part = address_of(axis)
    device = bench.devices[owner]
    name = node_name(device.axes.label(owner, part), CANOPEN)
    from hil.sim.can.boot_node import BootNode

    card = CanOpenCard(name, bus, device, group, lambda send: BootNode(config.id, send))
    bench.add_can_node(card)
