"""Units of the door: which number is which axis, and its registers."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from bridges.modbus.door.door_options import UNITS
from bridges.modbus.protocol.pdu import Code, Refused
from bridges.modbus.registers.registers_protocol import Registers
from bridges.modbus.registers.units import unit_of
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Desk, DeviceInfo

_ANY = (0, 255)
"""Numbers with which clients mean a device that is no gateway (Messaging on TCP/IP V1.0b, 3.1.3)."""


@dataclass(eq=False)
class DoorUnit:
    """Unit of the door. ``info``: of its axis."""

    number: int
    info: DeviceInfo
    registers: Registers = field(repr=False)


class DoorUnits:
    """Units by number. ``wanted``: numbers by axis; None: axes in the order of the bench, from 1 on."""

    def __init__(self, desk: Desk, wanted: Mapping[str, int] | None, is_low_first: bool) -> None:
        self._desk, self._wanted, self._is_low_first = desk, wanted, is_low_first
        self._units: dict[int, DoorUnit] = {}

    def open(self) -> None:
        """Make the units. Raises BridgeError: an axis is not there, or two have one number."""
        devices, wanted = self._desk.describe().devices, self._wanted or {}
        if len(set(wanted.values())) < len(wanted):
            raise BridgeError(f"units: {dict(wanted)}: give each a number of its own")
        for axis in wanted:
            if axis not in devices:
                known = ", ".join(devices)
                raise BridgeError(f"units: there is no axis {axis!r}; there are {known}")
        self.renew(())

    def renew(self, names: Collection[str]) -> None:
        """Make the units of these devices again, and those of axes that have another number now."""
        devices, old = self._desk.describe().devices, self._units
        numbers = self._wanted or dict(zip(devices, UNITS, strict=False))
        self._units = {}
        for axis, number in numbers.items():
            unit = old.get(number)
            if unit and unit.info.name == axis and owner_of(axis) not in names:
                self._units[number] = unit
            elif info := devices.get(axis):
                registers = unit_of(info, is_low_first=self._is_low_first)
                self._units[number] = DoorUnit(number, info, registers)

    def find(self, number: int) -> DoorUnit:
        """The unit that a number means. Raises Refused: as a gateway says it."""
        if unit := self._units.get(number):
            return unit
        if number in _ANY and len(self._units) == 1:
            return next(iter(self._units.values()))
        if self._wanted and number in self._wanted.values():
            raise Refused(Code.GATEWAY_TARGET_FAILED, f"the axis of unit {number} has gone")
        raise Refused(Code.GATEWAY_PATH_UNAVAILABLE, f"there is no unit {number}")

    def all(self) -> Sequence[DoorUnit]:
        """All units, by number."""
        return [self._units[number] for number in sorted(self._units)]

    def shown(self) -> dict[str, str]:
        """Axes by number, for the status."""
        return {str(unit.number): unit.info.name for unit in self.all()}
