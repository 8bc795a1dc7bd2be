"""Checks of where real boards are: at a serial port or on Modbus, no two at one port, no two drives with one
unit."""

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic_core import PydanticCustomError

from hil.config.document import Finding, KeyPath
from hil.wire.drive_address import AddressRefused, DriveAddress, RtuPlace, drive_address, is_drive_address
from hil.wire.serial_address import SERIAL_FORMS, is_serial_address

FORMS = f"{SERIAL_FORMS}; of a Modbus drive modbus+tcp://host:port?unit=1 or modbus+rtu:///dev/ttyUSB0?unit=1"


def real_address(value: Any) -> Any:
    """Check that a text is the address of a serial port or of a drive; other types are left to the model."""
    if isinstance(value, str) and is_drive_address(value):
        try:
            drive_address(value)
        except AddressRefused as error:
            said = {"what": str(error), "remedy": error.remedy}
            raise PydanticCustomError("drive_address", "{what}", said) from None
    elif isinstance(value, str) and not is_serial_address(value):
        raise PydanticCustomError("serial_url", "this is no serial port", {"remedy": FORMS})
    return value


def same_at(devices: Mapping[str, Mapping[str, object]]) -> Iterator[Finding]:
    """Findings of real boards at a place that another one has. Drives share a line, under units of their
    own."""
    boards: dict[str, str] = {}
    units: dict[tuple[str, int], str] = {}
    lines: dict[str, tuple[str, DriveAddress]] = {}
    for name, raw in devices.items():
        at, path = raw.get("at"), ("devices", name, "at")
        if not isinstance(at, str):
            continue
        drive = _drive(at)
        where = drive.place.where if drive else at
        if drive is None or where in boards:
            taken = boards.get(where) or (lines[where][0] if where in lines else None)
            boards.setdefault(where, name)
            if taken:
                yield Finding(path, f"device {taken} is there", "each board has its own port")
            continue
        yield from _of_drive(path, name, drive, units, lines)


def _drive(at: str) -> DriveAddress | None:
    try:
        return drive_address(at) if is_drive_address(at) else None
    except AddressRefused:
        return None  # told by the model


def _of_drive(
    path: KeyPath,
    name: str,
    drive: DriveAddress,
    units: dict[tuple[str, int], str],
    lines: dict[str, tuple[str, DriveAddress]],
) -> Iterator[Finding]:
    where = drive.place.where
    other, first = lines.setdefault(where, (name, drive))
    taken = units.setdefault((where, drive.unit), name)
    if taken != name:
        message = f"device {taken} has unit {drive.unit} there already"
        yield Finding(path, message, "each drive on a line has a unit of its own")
    elif isinstance(drive.place, RtuPlace) and drive.place != first.place:
        message = f"device {other} has this line: {first.place}"
        yield Finding(path, message, "a line has one speed and one format; write the same for both")
