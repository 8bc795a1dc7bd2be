"""Names of a bench: devices, taps and segments, and the group in whose time each lives."""

from dataclasses import dataclass

from hil.core.fields import OF_KIND
from hil.sim.device import Device
from hil.sim.group import Group
from hil.sim.segment_tap import Tap
from hil.sim.uart import DeviceUart
from hil.vocab.faults import PORT, SEGMENT, SERVO, STATION, SUPPLIED, TWIN_PORT
from hil.vocab.firmware import MAIN
from hil.vocab.segment import Segment

SERVO_FIELD = "raw"
"""Field that only axes with an encoder have."""


@dataclass(frozen=True)
class Place:
    """Meaning of a target's name."""

    group: Group
    device: Device | None = None
    uart: DeviceUart | None = None
    segment: Segment | None = None
    station: str = ""

    def has(self, target: str) -> bool:
        """Whether a fault that needs this kind of target can be here."""
        return {
            PORT: self.uart is not None,
            TWIN_PORT: self.uart is not None,
            STATION: bool(self.segment and self.station),
            SEGMENT: self.segment is not None and not self.station,
            SUPPLIED: self.device is not None and self.device.axis.nominal_supply_V > 0,
            SERVO: self.device is not None and SERVO_FIELD in OF_KIND[self.device.axis.kind],
        }.get(target, self.device is not None)


class Roster:
    """Names of a bench's parts. No two share one."""

    def __init__(self) -> None:
        self.devices: dict[str, Device] = {}
        self.taps: dict[str, Tap] = {}
        self.segments: dict[str, Segment] = {}
        self._groups: dict[str, Group] = {}

    def add_device(self, device: Device, group: Group) -> None:
        self.devices[device.name] = device
        self._groups[device.name] = group

    def remove_device(self, name: str) -> tuple[Device, Group]:
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

    def group_of(self, target: str) -> Group:
        """Group of a device or one of its UARTs, of a tap or a segment."""
        return self._groups.get(target) or self._groups[target.partition(".")[0]]

    def place(self, target: str) -> Place | None:
        """Meaning of a name; None: nothing has it."""
        if target in self.segments:
            return Place(self._groups[target], segment=self.segments[target])
        if target in self.taps:
            return Place(self._groups[target], segment=self.taps[target].segment, station=target)
        name, dot, uart_name = target.partition(".")
        device = self.devices.get(name)
        uart = device.uarts.get(uart_name if dot else MAIN) if device else None
        return Place(self._groups[name], device, uart, uart.segment, uart.station) if uart else None

    def targets(self) -> list[str]:
        ports = [f"{name}.{uart}" for name, d in self.devices.items() for uart in d.uarts if uart != MAIN]
        return [*self.devices, *ports, *self.taps, *self.segments]
