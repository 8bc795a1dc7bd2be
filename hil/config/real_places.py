"""Checks of where real boards are: at a serial port, on Modbus or on CAN, no two at one port, no two drives
with one unit or node."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pydantic_core import PydanticCustomError

from hil.config.document import Finding, KeyPath
from hil.wire.address_keys import AddressRefused
from hil.wire.serial_address import SERIAL_FORMS, is_serial_address

if TYPE_CHECKING:  # most benches have no real drive: what reads their addresses is imported for one
    from bridges.can.drives.can_drive_address import CanDriveAddress
    from bridges.modbus.drives.modbus_drive_address import DriveAddress

FORMS = (
    f"{SERIAL_FORMS}; of a Modbus drive modbus+tcp://host:port?unit=1 or modbus+rtu:///dev/ttyUSB0?unit=1,"
    " of a CANopen drive can+socketcan://can0?node=5"
)


def real_address(value: Any) -> Any:
    """Check that a text is the address of a serial port or of a drive; other types are left to the model."""
    if isinstance(value, str) and is_real_drive(value):
        try:
            _read(value)
        except AddressRefused as error:
            said = {"what": str(error), "remedy": error.remedy}
            raise PydanticCustomError("drive_address", "{what}", said) from None
    elif isinstance(value, str) and not is_serial_address(value):
        raise PydanticCustomError("serial_url", "this is no serial port", {"remedy": FORMS})
    return value


def is_real_drive(text: str) -> bool:
    """True if a text is meant as the address of a drive, on Modbus or on CAN."""
    from bridges.can.drives.can_drive_address import is_can_address
    from bridges.modbus.drives.modbus_drive_address import is_drive_address

    return is_drive_address(text) or is_can_address(text)


def same_at(devices: Mapping[str, Mapping[str, object]]) -> Iterator[Finding]:
    """Findings of real boards at a place that another one has. Drives share a line or a bus, under units or
    nodes of their own."""
    boards: dict[str, str] = {}
    on_lines = _OnLines()
    for name, raw in devices.items():
        at, path = raw.get("at"), ("devices", name, "at")
        if not isinstance(at, str):
            continue
        drive = _drive(at)
        where = drive.place.where if drive else at
        taken = boards.get(where) or on_lines.other(where, drive)
        if drive is None:
            boards.setdefault(where, name)
        if taken:
            yield Finding(path, f"device {taken} is there", "each board has its own port")
        elif drive:
            yield from on_lines.check(path, name, drive, raw.get("setpoint_rate_Hz"))


def _read(at: str) -> "DriveAddress | CanDriveAddress":
    from bridges.can.drives.can_drive_address import can_drive_address
    from bridges.modbus.drives.modbus_drive_address import drive_address, is_drive_address

    return drive_address(at) if is_drive_address(at) else can_drive_address(at)


def _drive(at: str) -> "DriveAddress | CanDriveAddress | None":
    try:
        return _read(at) if is_real_drive(at) else None
    except AddressRefused:
        return None  # told by the model


class _OnLines:
    """Drives that were found on lines and buses. The first on each says how it is."""

    def __init__(self) -> None:
        self._first: dict[str, tuple[str, DriveAddress | CanDriveAddress]] = {}
        self._taken: dict[tuple[str, int], str] = {}
        self._rates: dict[str, object] = {}

    def other(self, where: str, drive: "DriveAddress | CanDriveAddress | None") -> str | None:
        """Name of a drive that is there and speaks another protocol; None: there is none."""
        name, first = self._first.get(where, (None, None))
        return name if type(first) is not type(drive) else None

    def check(
        self, path: KeyPath, name: str, drive: "DriveAddress | CanDriveAddress", rate: object
    ) -> Iterator[Finding]:
        from bridges.can.drives.can_drive_address import CanDriveAddress
        from bridges.modbus.drives.modbus_drive_address import RtuPlace

        where = drive.place.where
        other, first = self._first.setdefault(where, (name, drive))
        is_can = isinstance(drive, CanDriveAddress)
        number, what = (drive.node, "node") if isinstance(drive, CanDriveAddress) else (drive.unit, "unit")
        taken = self._taken.setdefault((where, number), name)
        if taken != name:
            line = "bus" if is_can else "line"
            message = f"device {taken} has {what} {number} there already"
            yield Finding(path, message, f"each drive on a {line} has a {what} of its own")
        elif isinstance(drive.place, RtuPlace) and drive.place != first.place:
            message = f"device {other} has this line: {first.place}"
            remedy = "a line has one speed and one format, and an echo or none; write the same for both"
            yield Finding(path, message, remedy)
        elif drive.place != first.place:
            message = f"device {other} has this adapter: {first.place}"
            yield Finding(path, message, "an adapter has one bit rate and one speed; write the same for both")
        elif getattr(drive, "master", None) != getattr(first, "master", None):
            message = f"device {other} is on this bus, with another master"
            yield Finding(path, message, "a bus has one master; write the same for both")
        elif is_can and self._rates.setdefault(where, rate) != rate:
            message = f"device {other} is on this bus, with another setpoint_rate_Hz"
            remedy = "write the same for both: a bus has one SYNC"
            yield Finding((*path[:-1], "setpoint_rate_Hz"), message, remedy, at_key=True)
