"""Names of a bench: devices, wires, taps and cards, and the group in whose time each lives."""

from dataclasses import dataclass, replace

from hil.core import CoreAxis
from hil.core.core_switch import CoreSwitch
from hil.sim.card import Card
from hil.sim.client_tap import ClientTap, HasChannels
from hil.sim.group import Group
from hil.sim.twin import Twin
from hil.sim.uart import DeviceUart
from hil.vocab.address import Address, address_of, owner_of
from hil.vocab.faults import DEVICE, OF_AXES, PORT, SUPPLIED, SWITCH, TWIN_PORT
from hil.vocab.wire import Wire


@dataclass(frozen=True)
class FaultPlace:
    """Meaning of a target's name."""

    group: Group
    device: Twin | None = None
    uart: DeviceUart | None = None
    axis: CoreAxis | None = None
    wire: Wire | None = None
    station: str = ""
    card: Card | None = None
    switch: CoreSwitch | None = None
    is_board: bool = False
    """True for the device as a whole, which its first UART and axis are, too."""
    is_port: bool = False
    """True where the name is a UART's: its board's shaft has another."""

    def has(self, target: str) -> bool:
        """True if a fault that needs this kind of target can be here."""
        if target in OF_AXES:
            return self.axis is not None and target in self.axis.kind.fault_targets
        if self.is_wires(target) or self.is_cards(target):
            return True
        return {
            PORT: self.uart is not None,
            TWIN_PORT: self.uart is not None,
            DEVICE: self.is_board,
            SWITCH: self.switch is not None,
            SUPPLIED: self.axis is not None and self.axis.nominal_supply_V > 0,
        }.get(target, False)

    def fits(self, target: str) -> bool:
        """True if a new fault of this kind of target can be here: of a shaft not at a port of its board,
        where logs of before may have one."""
        return self.has(target) and not (self.is_port and target in (*OF_AXES, SUPPLIED))

    def is_wires(self, target: str) -> bool:
        """True if a fault that needs this kind of target is the wire's here."""
        return self.wire is not None and target in self.wire.fault_targets(self.station)

    def is_cards(self, target: str) -> bool:
        """True if a fault that needs this kind of target is the card's here."""
        faults = self.card.faults if self.card else None
        return faults is not None and target == faults.target


class BenchParts:
    """Names of a bench's parts. No two share one."""

    def __init__(self) -> None:
        self.devices: dict[str, Twin] = {}
        self.taps: dict[str, ClientTap] = {}
        self.cards: dict[str, Card] = {}
        self.wires: dict[str, Wire] = {}
        self.axes: dict[str, tuple[Twin, str]] = {}
        """Axes by their addresses: the device, and the axis's name there."""
        self.switches: dict[str, CoreSwitch] = {}
        """Switches along axes, by name."""
        self._switch_places: dict[str, CoreSwitch] = {}
        """The same by their addresses: the device whose axis actuates each, and its name."""
        self._groups: dict[str, Group] = {}

    def add_device(self, device: Twin, group: Group) -> None:
        self.devices[device.name] = device
        self._groups[device.name] = group
        self.axes |= {device.axes.label(device.name, axis): (device, axis) for axis in device.axes}

    def remove_device(self, name: str) -> tuple[Twin, Group]:
        places = self._switch_places.items()
        self._switch_places = {address: each for address, each in places if owner_of(address) != name}
        self.axes = {address: of for address, of in self.axes.items() if of[0].name != name}
        return self.devices.pop(name), self._groups.pop(name)

    def add_wire(self, name: str, wire: Wire, group: Group) -> None:
        """Add a wire without stations. All devices that join it are in this group."""
        self.wires[name] = wire
        self._groups[name] = group

    def add_tap(self, tap: ClientTap, group: Group) -> None:
        """Add a tap that is on its wire, which is in this group."""
        self.taps[tap.name] = tap
        self._groups[tap.name] = group

    def attach(self, wire: str, name: str) -> ClientTap:
        """Find the node of a channel of a wire, which is put there if there is none of that name yet."""
        label, on = str(Address(wire, name)), self.wires[wire]
        if label not in self.taps:
            assert isinstance(on, HasChannels)
            self.add_tap(on.channel(label), self._groups[wire])
        return self.taps[label]

    def add_card(self, card: Card) -> None:
        """Add the card of an axis, which is on a wire in its device's group."""
        self.cards[card.name] = card

    def add_switch(self, device: str, name: str, switch: CoreSwitch) -> None:
        """Add a switch at an axis of a device."""
        self.switches[name] = self._switch_places[str(Address(device, name))] = switch

    def group_of(self, target: str) -> Group:
        """Group of a device or a part of it, of a tap, a card or a wire."""
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
        device, name = self.axes.get(address) or self.axes[self.axis_address(address) or address]
        return device.axes[name]

    def place(self, target: str) -> FaultPlace | None:
        """Meaning of a name; None: nothing has it."""
        if target in self.wires:
            return FaultPlace(self._groups[target], wire=self.wires[target])
        name, part = address_of(target)
        if target in self.taps:
            return FaultPlace(self._groups[target], wire=self.wires.get(name), station=target)
        if card := self.cards.get(target):
            return FaultPlace(self._groups[name], wire=card.wire, station=target, card=card)
        if (device := self.devices.get(name)) is None:
            return None
        if switch := self._switch_places.get(target):
            return FaultPlace(self._groups[name], device, switch=switch)
        uart, axis = device.uarts.get(part), device.axes.get(part)
        if uart is None and part:
            return FaultPlace(self._groups[name], device, axis=axis) if axis else None
        if len(device.axes) == 1:  # a target of a board with one axis has that axis's shaft
            axis = device.axes[""]
        place = FaultPlace(self._groups[name], device, uart, axis, is_board=True, is_port=bool(part))
        link = uart.station if uart else None
        return replace(place, wire=link.segment, station=link.name) if link else place

    def targets(self) -> list[str]:
        labels = [
            device.uarts.label(name, uart) for name, device in self.devices.items() for uart in device.uarts
        ]
        parts = (*self.axes, *self._switch_places, *self.cards)
        return [*dict.fromkeys([*self.devices, *labels, *parts, *self.taps, *self.wires])]
