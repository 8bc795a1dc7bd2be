"""``serial.tools.list_ports`` of a program on simulated time: the ports of its bench."""

from collections.abc import Callable, Mapping

from serial.tools.list_ports_common import ListPortInfo

from hil.testing.serial_ports.port_terminal import PortTerminal


def lister(bench: str, terminals: Mapping[str, PortTerminal]) -> Callable[..., list[ListPortInfo]]:
    """Make ``comports`` for ports by the names that the program has for them: of several, the last."""
    names = {id(terminal): name for name, terminal in terminals.items()}

    def comports(include_links: bool = False) -> list[ListPortInfo]:
        """List the ports, with what a USB says of each."""
        return [_info(name, bench, terminals[name]) for name in names.values()]

    return comports


def _info(name: str, bench: str, terminal: PortTerminal) -> ListPortInfo:
    info, identity = ListPortInfo(name, skip_link_detection=True), terminal.identity
    info.vid, info.pid = identity.vendor_id, identity.product_id
    info.serial_number = f"{bench}.{terminal.name}"  # as of the port usb
    info.manufacturer, info.product = identity.manufacturer, identity.product
    info.apply_usb_info()
    return info
