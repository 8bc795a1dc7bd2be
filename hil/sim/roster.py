"""Names of a bench: devices, taps, segments and CAN buses, and the group in whose time each lives."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from hil.core import CoreAxis
from hil.sim.client_tap import ClientTap
from hil.sim.device import Device
from hil.sim.group import Group
from hil.sim.segment_tap import Tap
from hil.sim.uart import DeviceUart
from hil.vocab.address import Address, address_of, owner_of
from hil.vocab.faults import (
    CAN_NODE,
    DEVICE,
    LINE,
    MODBUS_NODE,
    OF_AXES,
    ON_LINE,
    PORT,
    SEGMENT,
    STATION,
    SUPPLIED,
    TWIN_PORT,
)
from hil.vocab.segment import Segment

if TYPE_CHECKING:
    from hil.sim.can.bench_bus import BenchBus
    from hil.sim.can.canopen_card import CanOpenCard
    from hil.sim.modbus.modbus_node import ModbusNode


@dataclass(frozen=True)
class Place:
    """Meaning of a target's name."""

    group: Group
    device: Device | None = None
    uart: DeviceUart | None = None
    axis: CoreAxis | None = None
    segment: Segment | None = None
    station: str = ""
    node: "ModbusNode | None" = None
    bus: "BenchBus | None" = None
    is_board: bool = False
    """True for the device as a whole, which its first UART and axis are, too."""

    def has(self, target: str) -> bool:
        """True if a fault that needs this kind of target can be here."""
        if target in OF_AXES:
            return self.axis is not None and target in self.axis.kind.fault_targets
        return {
            PORT: self.uart is not None,
            TWIN_PORT: self.uart is not None,
            STATION: bool(self.segment and self.station),
            SEGMENT: self.segment is not None and not self.station,
            ON_LINE: bool((self.segment or self.bus) and self.station),
            LINE: bool((self.segment or self.bus) and not self.station),
            CAN_NODE: bool(self.bus and self.station),
            MODBUS_NODE: self.node is not None,
            DEVICE: self.is_board,
            SUPPLIED: self.axis is not None and self.axis.nominal_supply_V > 0,
        }[target]


class Roster:
    """Names of a bench's parts. No two share one."""

    def __init__(self) -> None:
        self.devices: dict[str, Device] = {}
        self.taps: dict[str, ClientTap] = {}
        self.nodes: dict[str, ModbusNode] = {}
        self.segments: dict[str, Segment] = {}
        self.buses: dict[str, BenchBus] = {}
        self.can_nodes: dict[str, CanOpenCard] = {}
        self.axes: dict[str, tuple[Device, str]] = {}
        """Axes by their addresses: the device, and the axis's name there."""
        self._groups: dict[str, Group] = {}

    def add_device(self, device: Device, group: Group) -> None:
        self.devices[device.name] = device
        self._groups[device.name] = group
        self.axes |= {device.axes.label(device.name, axis): (device, axis) for axis in device.axes}

    def remove_device(self, name: str) -> tuple[Device, Group]:
        self.axes = {address: of for address, of in self.axes.items() if of[0].name != name}
        return self.devices.pop(name), self._groups.pop(name)

    def add_segment(self, name: str, segment: Segment, group: Group) -> None:
        """Add a segment without stations. All devices that join it are in this group."""
        self.segments[name] = segment
        self._groups[name] = group

    def add_tap(self, tap: Tap, group: Group) -> None:
        """Add a tap as a station of its segment, which is in this group."""
        self.taps[tap.name] = tap
        self._groups[tap.name] = group
        tap.segment.join(tap.name, tap)

    def add_bus(self, bus: "BenchBus", group: Group) -> None:
        """Add a CAN bus without nodes. All devices that have one on it are in this group."""
        self.buses[bus.name] = bus
        self._groups[bus.name] = group

    def add_can_tap(self, tap: ClientTap, group: Group) -> None:
        """Add a tap that is on its bus, which is in this group."""
        self.taps[tap.name] = tap
        self._groups[tap.name] = group

    def attach(self, bus: str, name: str) -> ClientTap:
        """Find the node of a channel of a bus, which is put there if there is none of that name yet."""
        label = str(Address(bus, name))
        if label not in self.taps:
            from hil.sim.can.channel_node import ChannelNode  # most benches have none

            self.add_can_tap(ChannelNode(label, self.buses[bus].bus), self._groups[bus])
        return self.taps[label]

    def add_can_node(self, node: "CanOpenCard") -> None:
        """Add the CANopen node of a device, which is in its bus's group."""
        self.can_nodes[node.name] = node

    def add_node(self, node: "ModbusNode") -> None:
        """Add a Modbus node of a device, which is in its segment's group."""
        self.nodes[node.name] = node

    def group_of(self, target: str) -> Group:
        """Group of a device or a part of it, of a tap, a node, a segment or a bus."""
        return self._groups.get(target) or self._groups[owner_of(target)]

    def axis_address(self, text: str) -> str | None:
        """Address of the axis that a text means, as hil writes it, or None."""
        if text in self.axes:
            return text
        name, part = address_of(text)
        axes = self.devices[name].axes if name in self.devices and text not in self.taps else ()
        return self.devices[name].axes.label(name, part) if part in axes else None

    def axis(self, address: str) -> CoreAxis:
        """Axis at an address. Raises KeyError: there is none."""
        device, name = self.axes[self.axis_address(address) or address]
        return device.axes[name]

    def place(self, target: str) -> Place | None:
        """Meaning of a name; None: nothing has it."""
        if target in self.segments:
            return Place(self._groups[target], segment=self.segments[target])
        name, part = address_of(target)
        if target in self.buses:
            return Place(self._groups[target], bus=self.buses[target])
        if target in self.taps:
            group, segment = self._groups[target], self.segments.get(name)
            return Place(group, segment=segment, bus=self.buses.get(name), station=target)
        if card := self.can_nodes.get(target):
            return Place(self._groups[name], bus=card.of, station=target)
        if node := self.nodes.get(target):
            return Place(self._groups[name], segment=node.segment, station=target, node=node)
        if (device := self.devices.get(name)) is None:
            return None
        uart, axis = device.uarts.get(part), device.axes.get(part)
        if uart is None and part:
            return Place(self._groups[name], device, axis=axis) if axis else None
        if len(device.axes) == 1:  # a target of a board with one axis has that axis's shaft
            axis = device.axes[""]
        place = Place(self._groups[name], device, uart, axis, is_board=True)
        link = uart.station if uart else None
        return replace(place, segment=link.segment, station=link.name) if link else place

    def targets(self) -> list[str]:
        labels = [
            device.uarts.label(name, uart) for name, device in self.devices.items() for uart in device.uarts
        ]
        nodes, lines = [*self.nodes, *self.can_nodes], [*self.segments, *self.buses]
        return [*dict.fromkeys([*self.devices, *labels, *self.axes, *nodes, *self.taps, *lines])]
