"""Names of a segment's stations: which UART of a device one is, by which addresses it is known; nodes of
segments and of CAN buses."""

from collections.abc import Iterator, Mapping
from typing import Any

from hil.config.catalogue import ProfileInfo
from hil.vocab.address import Address, DeviceParts, address_of
from hil.vocab.bus import NodeKind
from hil.vocab.firmware import NETWORK

CANOPEN = "canopen"
"""Name of a CANopen node, behind its axis's."""


def node_name(axis: str, kind: str) -> str:
    """Name of the node of the axis at an address, which hil writes so. ``kind``: its protocol."""
    return f"{axis}.{kind}"


def station_uart(uarts: Mapping[str, object]) -> str | None:
    """Name of the UART with which a device is a station, where none is named; None: nobody can tell."""
    return NETWORK if NETWORK in uarts else next(iter(uarts)) if len(uarts) == 1 else None


def station_addresses(station: str, devices: Mapping[str, ProfileInfo]) -> Iterator[str]:
    """Addresses that a station of a configuration has as a target, as hil writes it and with its UART's name;
    none for a device that is not there."""
    device, part = address_of(station)
    if device in devices:
        uarts = DeviceParts(devices[device].uarts)
        uart = part or station_uart(uarts) or ""
        yield from dict.fromkeys((uarts.label(device, uart), str(Address(device, uart))))


def node_addresses(
    kind: NodeKind, segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo]
) -> Iterator[str]:
    """Addresses of the nodes of a kind on a segment of a configuration, those with a device that is there."""
    nodes = segment.get(kind.key)
    yield from nodes_of(nodes.get(kind.axes_key) if isinstance(nodes, dict) else None, devices, kind.key)


def nodes_of(by_axis: object, devices: Mapping[str, ProfileInfo], kind: str) -> Iterator[str]:
    """Addresses of the cards of axes of a configuration, those with a device that is there. ``kind``: as
    ``node_name`` has it."""
    for axis in by_axis if isinstance(by_axis, dict) else ():
        device, part = address_of(str(axis))
        if device in devices and (not part or part in devices[device].axes):
            yield node_name(DeviceParts(devices[device].axes).label(device, part), kind)
