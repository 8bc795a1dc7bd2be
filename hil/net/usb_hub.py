"""Hub ports of the kernel's virtual USB controllers, as its module vhci-hcd tells them in sysfs."""

from pathlib import Path

from hil.vocab.late_dataclass import dataclass

FREE, USED = 4, 6
"""States of a hub port: nothing is plugged in; a device is there and has its address. Between the two are 5,
until the kernel has given the address, and 7, after an error. Source: enum usbip_device_status of Linux."""
_HUBS = _HIGH, _SUPER = "hs", "ss"
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
    is_left: bool
    """True if the kernel has noted that the last device was pulled out, which it does after the port is
    ``FREE``. A device of the same descriptors that is plugged in before would be taken for the last one."""

    @property
    def can_be_taken(self) -> bool:
        return self.state == FREE and self.is_left


def controller(sysfs: Path = Path("/sys")) -> Path | None:
    """Folder of the first controller, which has the files of all; None: the module is not loaded. Linux
    before 4.9 knows one controller, without a number."""
    return next((each.parent for each in sorted(sysfs.glob("devices/platform/vhci_hcd*/attach"))), None)


def hub_ports(folder: Path) -> list[HubPort]:
    """Read the hub ports of all controllers, lowest number first.

    Raises:
        OSError: a file cannot be read.
    """
    ports: list[HubPort] = []
    for file in folder.glob("status*"):
        # Linux before 4.9 has one controller, without a number.
        own = folder.with_name(f"{folder.stem}{file.suffix}") if file.suffix else folder
        there = {each.name.partition("-")[2] for each in own.glob("usb*/*-*")}
        places: dict[str, int] = {}
        for words in map(str.split, file.read_text(errors="replace").splitlines()):
            # Linux before 4.13 has no first column, and one hub.
            hub = words.pop(0) if words and words[0] in _HUBS else _HIGH
            if len(words) >= 6 and words[0].isdigit():
                places[hub] = places.get(hub, 0) + 1
                ports.append(_hub_port(hub, words, str(places[hub]) not in there))
    return sorted(ports, key=lambda port: port.number)


def _hub_port(hub: str, words: list[str], is_left: bool) -> HubPort:
    number, state, _speed, device_id, _socket, bus_name = words[:6]
    return HubPort(int(number), hub == _SUPER, int(state), int(device_id, 16), bus_name, is_left)
