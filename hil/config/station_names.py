"""Names of a segment's stations: which UART of a device one is, and by which addresses it is known."""

from collections.abc import Iterator, Mapping

from hil.config.catalogue import ProfileInfo
from hil.vocab.address import Address, DeviceParts, address_of
from hil.vocab.firmware import NETWORK


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
