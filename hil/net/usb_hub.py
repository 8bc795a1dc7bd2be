"""Hub ports of the kernel's virtual USB controllers, as its module vhci-hcd tells them in sysfs."""

from dataclasses import dataclass
from pathlib import Path

FREE, USED = 4, 6
"""States of a hub port: nothing is plugged in; a device is there and has its address. Between the two are 5,
until the kernel has given the address, and 7, after an error. Source: enum usbip_device_status of Linux."""
GROUP = "hil-usb"
"""Group that gets the right to plug in, where ``make install-service`` or the Debian package were told so."""


@dataclass(frozen=True)
class HubPort:
    """Hub port. ``number``: what ``attach`` takes, counted over all controllers."""

    number: int
    is_super: bool
    """True if it takes devices of SuperSpeed alone; False: of full and high speed."""
    state: int
    device_id: int
    """Number that the server gave with ``attach``; 0 while the port is free."""
    bus_name: str
    """Folder of the device in /sys/bus/usb/devices, as in ``1-1``, once the port is ``USED``."""


def controller(sysfs: Path = Path("/sys")) -> Path | None:
    """Folder of the first controller, which has the files of all; None: the module is not loaded. Linux
    before 4.9 knows one controller, without a number."""
    return next((each.parent for each in sorted(sysfs.glob("devices/platform/vhci_hcd*/attach"))), None)


def hub_ports(folder: Path) -> list[HubPort]:
    """Read the hub ports of all controllers, lowest number first.

    Raises:
        OSError: a file cannot be read.
    """
    texts = (path.read_text(errors="replace") for path in folder.glob("status*"))
    return sorted(
        (port for text in texts for line in text.splitlines() if (port := _hub_port(line.split()))),
        key=lambda port: port.number,
    )


def _hub_port(words: list[str]) -> HubPort | None:
    """Hub port of a line; None: the headline. Linux before 4.13 has no first column, and one hub."""
    hub = words.pop(0) if words and words[0] in ("hs", "ss") else "hs"
    if len(words) < 6 or not words[0].isdigit():
        return None
    number, state, _speed, device_id, _socket, bus_name = words[:6]
    return HubPort(int(number), hub == "ss", int(state), int(device_id, 16), bus_name)
