"""The usb port's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from virtual_ports.usb.usb_options import Options

if TYPE_CHECKING:
    from hil.vocab.ports import Port, PortContext

__all__ = ["Options", "make"]


def make(options: Options, context: "PortContext") -> "Port":
    from virtual_ports.usb.usb_port import UsbPort

    return UsbPort(options, context)
