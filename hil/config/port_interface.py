"""Port of a board as a source of captures."""

from hil.config.station_names import station_uart
from hil.sim.twin import Twin
from hil.wire.pcapng import RAW, Interface


def port_interface(name: str, device: Twin, uart: str) -> Interface:
    """Source of a capture of a port: packets at the UART with which its board could be on a segment, else
    bytes. ``uart``: the UART's name."""
    at = device.uarts[uart]
    if device.framing and at is device.uarts.get(str(station_uart(device.uarts))):
        return Interface(name, device.framing.name, at.baud or 0)
    return Interface(name, RAW)
