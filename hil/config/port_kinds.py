"""Kinds of a bench's ports, by the names of the places where they are."""

from hil.config.model import BenchConfig
from hil.vocab.address import Address


def port_kinds(config: BenchConfig) -> dict[str, str]:
    """Kinds by label: ``m1`` and ``s1.network`` of devices, ``bus0.master`` of taps."""
    kinds = {
        str(Address(name, uart)): port.kind
        for name, device in config.devices.items()
        for uart, port in device.ports_by_uart().items()
    }
    return kinds | {label: port.kind for label, port in config.tap_ports().items()}
