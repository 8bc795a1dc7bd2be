"""Addresses of a bench's parts: the same in configuration, commands, keys, runs, faults, captures and logs.

| address | what it is |
|---|---|
| ``s1`` | a device; its first axis, or its first UART, where one of these is meant |
| ``arm.elbow`` | an axis of a device, by its name |
| ``arm.logger`` | a UART of a device, by its name |
| ``bus0.master``, ``can0.slcan0`` | a tap of a segment or a CAN bus |
| ``m1.modbus``, ``arm.elbow.modbus`` | the Modbus node of an axis |
| ``m1.canopen``, ``arm.elbow.canopen`` | the CANopen node of an axis |
| ``m1.step``, ``arm.elbow.step`` | a pin of an axis |

No two UARTs or axes of a device share a name. The first axis and the first UART may be written with their
names too; what hil writes itself has the device's name alone.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple, TypeVar

from hil.vocab.near_words import meant

NAME_PATTERN = r"^[a-z][a-z0-9_-]{0,31}$"
"""Pattern of the name of a bench, a device, a segment, a tap, a UART and an axis."""
CONTROL_SOCKET = "control.sock"
"""Name of the control socket in the bench's runtime directory. No device can have it: it has a dot."""

Part_co = TypeVar("Part_co", covariant=True)


class Address(NamedTuple):
    """Address of a device or segment (``part`` empty), or of a part of it."""

    owner: str
    part: str = ""

    def __str__(self) -> str:
        return f"{self.owner}.{self.part}" if self.part else self.owner


def address_of(text: str) -> Address:
    """Split an address at its first point. A text without one is a device or segment. No text is refused: a
    part that does not exist, also the empty one behind a point, is found nowhere."""
    owner, point, part = text.partition(".")
    return Address(owner, part or point)


def owner_of(text: str) -> str:
    """Name of the device or segment that an address is of."""
    return text.partition(".")[0]


def pin_of(text: str) -> tuple[str, str]:
    """Split the address of a pin into the address of its axis and the pin's name; the first is empty if there
    is no point."""
    axis, _, pin = text.rpartition(".")
    return axis, pin


class DeviceParts(Mapping[str, Part_co]):
    """UARTs or axes of one device by name, in their order. The empty name stands for the first one."""

    def __init__(self, by_name: Mapping[str, Part_co]) -> None:
        self._by_name = dict(by_name)
        self.first = next(iter(self._by_name), "")
        """Name of the first; empty: there is none."""

    def __getitem__(self, name: str) -> Part_co:
        return self._by_name[name or self.first]

    def __contains__(self, name: object) -> bool:
        return (name or self.first) in self._by_name

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    def short(self, name: str) -> str:
        """Name of a part as hil writes it: the first one's is empty."""
        return "" if name == self.first else name

    def label(self, device: str, name: str) -> str:
        """Address of a part as hil writes it: the first one's is the device's name."""
        return f"{device}.{name}" if name and name != self.first else device


def no_input(axis: str, pin: str, inputs: Collection[str]) -> tuple[str, str]:
    """Error text of a pin that cannot be driven, and what there is instead."""
    return f"{axis} has no input {pin!r}", meant(pin, inputs)


def no_part(device: str, what: str, name: str, known: Mapping[str, object]) -> str:
    """Error text of a UART or an axis that a device does not have; ``what``: which of these."""
    there = f"it has {', '.join(known)}" if known else "it has none"
    return f"{device} has no {what} {name!r}; {there}" if name else f"{device} has no {what}"
