"""``hil arduino-monitor``: joins a device's port to the serial monitor of the IDE, byte for byte.

The IDE listens on TCP, and says where by OPEN; the board's port is opened as by any other client.
"""

import os
import select
import socket
import termios
from contextlib import ExitStack
from typing import TextIO

from hil.arduino.protocol import Monitor
from hil.arduino.stdio import InputLines, send
from hil.net.port_client import PortUnreachable, opened_port

_CONNECT_S = 5.0
_READ_BYTES = 65536
_WAITING_BYTES = 65536
"""Maximum that is read from one side before the other takes it: a slow reader holds up the board."""


class LinkLost(Exception):
    """Loss of one of the two ends: ``str(error)`` says which."""


class FdLink:
    """``MonitorLink`` by two file descriptors, with what waits on the way between them."""

    def __init__(self) -> None:
        self._resources = ExitStack()
        self._client = self._port = -1
        self._is_terminal = False
        self._waiting: dict[int, bytes] = {}

    def open(self, client: tuple[str, int], address: str, baud: int) -> None:
        with ExitStack() as resources:
            try:
                port = resources.enter_context(opened_port(address))
            except PortUnreachable as error:
                raise OSError(str(error)) from error
            try:
                connection = resources.enter_context(socket.create_connection(client, timeout=_CONNECT_S))
            except (OSError, OverflowError) as error:
                raise OSError(f"nobody listens at {client[0]}:{client[1]}: {error}") from error
            connection.setblocking(False)
            os.set_blocking(port, False)
            self._port, self._client = port, connection.fileno()
            self._is_terminal = os.isatty(port)
            self.set_baud(baud)
            self._waiting = {self._port: b"", self._client: b""}
            self._resources = resources.pop_all()

    def set_baud(self, baud: int) -> None:
        if not self._is_terminal:
            return  # a socket has none
        try:
            settings = termios.tcgetattr(self._port)
            settings[4] = settings[5] = getattr(termios, f"B{baud}")
            termios.tcsetattr(self._port, termios.TCSANOW, settings)
        except termios.error as error:
            raise OSError(*error.args) from error

    def close(self) -> None:
        self._resources.close()
        self._waiting = {}

    def wants(self) -> tuple[list[int], list[int]]:
        """File descriptors to wait for, to read and to write."""
        pairs = [(self._port, self._client), (self._client, self._port)] if self._waiting else []
        reads = [source for source, sink in pairs if len(self._waiting[sink]) < _WAITING_BYTES]
        return reads, [fd for fd, data in self._waiting.items() if data]

    def move(self, readable: list[int], writable: list[int]) -> None:
        """Read and write what is possible now.

        Raises:
            LinkLost: an end has gone.
        """
        for source, sink in ((self._port, self._client), (self._client, self._port)):
            try:
                if source in readable:
                    data = os.read(source, _READ_BYTES)
                    if not data:
                        raise LinkLost(self._gone(source))
                    self._waiting[sink] += data
                if source in writable:
                    self._waiting[source] = self._waiting[source][os.write(source, self._waiting[source]) :]
            except BlockingIOError:
                continue  # another client of the port was quicker
            except OSError as error:
                raise LinkLost(self._gone(source)) from error

    def _gone(self, end: int) -> str:
        if end == self._client:
            return "lost the TCP connection with the client"
        return "the board's port has gone: its bench has stopped"


def serve(commands_fd: int, out: TextIO) -> None:
    """Serve one client, until QUIT or the end of its commands."""
    link = FdLink()
    monitor, commands = Monitor(link), InputLines(commands_fd)
    try:
        while not (monitor.dead or commands.ended):
            reads, writes = link.wants()
            readable, writable, _ = select.select([commands.fd, *reads], writes, [])
            try:
                link.move(readable, writable)
            except LinkLost as lost:
                send(monitor.lost(str(lost)), out)
            if commands.fd in readable:
                for line in commands.read():
                    send(monitor.command(line), out)
    except BrokenPipeError:
        return  # the client has gone without QUIT
    finally:
        link.close()
