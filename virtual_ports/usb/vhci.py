"""Plugging a virtual device into the kernel's virtual USB controller, and finding its tty.

The kernel is the client of USB/IP: it gets its end of a connected socket by ``attach``. Numbers of speeds:
enum usb_device_speed of Linux; what ``attach`` takes: drivers/usb/usbip/vhci_sysfs.c.
"""

import os
import socket
import time
from contextlib import suppress
from errno import EACCES, EAGAIN, EBUSY, ENOENT, EPERM, EROFS
from pathlib import Path

from hil.net.usb_hub import FREE, GROUP, USED, HubPort, controller, hub_ports

FULL_SPEED, HIGH_SPEED, SUPER_SPEED = 2, 3, 5
_TRY_NEXT = (EBUSY, EAGAIN)
"""Answers of a hub port that another program has just taken, or whose controller is not ready."""
_LEAVE_S = 5.0
"""Maximum time for the kernel to note that a device has left; most often it takes 0.1 s."""
_HUB_LOOK_S = 0.05
_DOCTOR = "`hil usb doctor` says more"


class VhciError(Exception):
    """Error of a device that could not be plugged in: ``str(error)`` has reason and remedy."""


class Attachment:
    """Device that is plugged in."""

    def __init__(self, sock: socket.socket, controller: Path, port: int, bus_id: int, sysfs: Path) -> None:
        self.controller = controller
        self.port = port
        """Number of the hub port, counted over all controllers."""
        self._bus_id = bus_id
        self._sysfs = sysfs
        self._sock: socket.socket | None = sock

    def tty(self) -> str | None:
        """Path as ``/dev/ttyACM0``, or None until the kernel has a driver at the device. Never waits."""
        if self._sock is None:
            return None
        with suppress(OSError):
            for port in hub_ports(self.controller):
                if (port.number, port.state, port.device_id) == (self.port, USED, self._bus_id):
                    found = (self._sysfs / "bus/usb/devices").glob(f"{port.bus_name}:*/tty/*")
                    return next((f"/dev/{each.name}" for each in found), None)
        return None

    def detach(self) -> None:
        """Pull it out. Safe to call twice.

        The kernel pulls a device out whose socket ends. Its file ``detach`` takes the number of a hub port,
        at which there may be another program's device by now.
        """
        if self._sock:
            with suppress(OSError):
                self._sock.shutdown(socket.SHUT_RDWR)
            self._sock.close()
            self._sock = None


def attach(
    sock: socket.socket, bus_id: int, speed: int = FULL_SPEED, sysfs: Path = Path("/sys")
) -> Attachment:
    """Plug a device in, at the first free hub port of its speed. The kernel asks for its descriptors at once,
    at the other end of ``sock``. It waits, for seconds at most, where the last device has only just left.

    Arguments:
        sock: the kernel's end of a connected stream socket; it is the attachment's from then on.
        bus_id: number of the device, 32 bits, which each request of the kernel has in it.
        speed: ``FULL_SPEED``, ``HIGH_SPEED`` or ``SUPER_SPEED``.

    Raises:
        VhciError: it cannot be plugged in.
    """
    found = controller(sysfs)
    if found is None:
        raise VhciError(f"the kernel's module vhci-hcd is not loaded; as root `modprobe vhci-hcd`; {_DOCTOR}")
    try:
        file = os.open(found / "attach", os.O_WRONLY)
        try:
            end_s = time.monotonic() + _LEAVE_S
            while True:
                ports = [port for port in hub_ports(found) if port.is_super == (speed == SUPER_SPEED)]
                for port in ports:
                    if port.can_be_taken and _taken(file, port, sock, bus_id, speed):
                        return Attachment(sock, found, port.number, bus_id, sysfs)
                if time.monotonic() > end_s or not any(port.state == FREE for port in ports):
                    break
                time.sleep(_HUB_LOOK_S)
        finally:
            os.close(file)
    except OSError as error:
        raise VhciError(_why(error, found)) from error
    raise VhciError(
        f"all {len(ports)} hub ports of the virtual USB controllers are taken; stop another bench, or unplug"
        " a device (`usbip port`, `usbip detach`); a kernel has more that was built with a greater"
        " CONFIG_USBIP_VHCI_HC_PORTS (at most 15) or CONFIG_USBIP_VHCI_NR_HCS (at most 128)"
    )


def _taken(file: int, port: HubPort, sock: socket.socket, bus_id: int, speed: int) -> bool:
    """Take a hub port; False: it was not free any more. The kernel lets only one of several have it, so a
    lock against other daemons is not needed."""
    try:
        os.write(file, f"{port.number} {sock.fileno()} {bus_id} {speed}".encode())
    except OSError as error:
        if error.errno in _TRY_NEXT:
            return False
        raise
    return True


def _why(error: OSError, found: Path) -> str:
    if error.errno in (EACCES, EPERM):
        return (
            f"user {os.geteuid()} may not write {found}/attach; as root `usermod -aG {GROUP} USER` and log in"
            f" again, where the group {GROUP} has the right; {_DOCTOR}"
        )
    if error.errno == EROFS:
        return f"{found} is read-only here; of the service, link the drop-in usb.conf: `hil docs service`"
    if error.errno == ENOENT:
        return f"the kernel's module vhci-hcd was removed; as root `modprobe vhci-hcd`; {_DOCTOR}"
    return f"{found}/attach refuses the device ({os.strerror(error.errno or 0)}); {_DOCTOR}"
