"""``attach`` of a kernel in Python: its end of the socket is served by the event loop of the port."""

import asyncio
import socket

from linux_host import LinuxHost

from virtual_ports.usb.vhci import VhciError


class FakeKernel:
    """Kernel with a virtual controller, served by the event loop that it is made on. ``hosts``: one for each
    device that was ever plugged in."""

    def __init__(self, makes_tty: bool = True) -> None:
        self.hosts: list[LinuxHost] = []
        self.plugged: list[FakeAttachment] = []
        self.refuses: str | None = None
        self.makes_tty = makes_tty
        self.loop = asyncio.get_running_loop()

    @property
    def host(self) -> LinuxHost:
        return self.hosts[-1]

    def attach(self, sock: socket.socket, bus_id: int) -> "FakeAttachment":
        if self.refuses:
            raise VhciError(self.refuses)
        host = LinuxHost(bus_id)
        attachment = FakeAttachment(self, sock, host)
        self.hosts.append(host)
        self.plugged.append(attachment)
        self.loop.call_soon_threadsafe(attachment.start)
        return attachment


class FakeAttachment:
    """Device at the kernel. ``step`` moves its bytes."""

    def __init__(self, kernel: FakeKernel, sock: socket.socket, host: LinuxHost) -> None:
        self._kernel = kernel
        self._sock = sock
        self.host = host
        self.is_detached = False
        self.number = len(kernel.hosts) + 1
        self._unsent = b""

    def start(self) -> None:
        if not self.is_detached:
            self._sock.setblocking(False)
            self._kernel.loop.add_reader(self._sock, self._readable)
            self.host.enumerate()
            self.step()

    def _readable(self) -> None:
        try:
            data = self._sock.recv(1 << 16)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.pull_out()
            return
        self.host.receive(data)
        self.step()

    def step(self) -> None:
        """Send what the host has for the device."""
        self._unsent += self.host.take()
        if self._unsent and not self.is_detached:
            try:
                self._unsent = self._unsent[self._sock.send(self._unsent) :]
            except BlockingIOError:
                pass
            except OSError:
                self.pull_out()
                return
            self._kernel.loop.remove_writer(self._sock)
            if self._unsent:
                self._kernel.loop.add_writer(self._sock, self.step)

    def send(self, data: bytes) -> None:
        """Send bytes of another kind."""
        self._unsent += data
        self.step()

    def pull_out(self) -> None:
        """Pull the device out, as the kernel does."""
        if not self.is_detached:
            self.is_detached = True
            if not self._kernel.loop.is_closed():
                self._kernel.loop.remove_reader(self._sock)
                self._kernel.loop.remove_writer(self._sock)
            self._sock.close()

    def tty(self) -> str | None:
        is_there = self.host.is_bound and not self.is_detached and self._kernel.makes_tty
        return f"/dev/ttyACM{90 + self.number}" if is_there else None

    def detach(self) -> None:
        self.pull_out()
