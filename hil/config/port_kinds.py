"""Kinds of a bench's ports, by the names of the places where they are."""

from itertools import chain

from hil.config.model import BenchConfig
from hil.vocab.address import Address


def port_kinds(config: BenchConfig) -> dict[str, str]:
    """Kinds by label: ``m1`` and ``s1.network`` of devices, ``bus0.master`` of taps."""
    kinds = {
        str(Address(name, uart)): port.kind
        for name, device in config.devices.items()
        for uart, port in device.ports_by_uart().items()
    }
    taps = chain(
        ((name, tap, each.port) for name, line in config.segments.items() for tap, each in line.taps.items()),
        ((name, tap, each.port) for name, bus in config.can.items() for tap, each in bus.taps.items()),
    )
    return kinds | {str(Address(name, tap)): port.kind for name, tap, port in taps}
