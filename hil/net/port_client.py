"""Client of a port by its address, as any other client."""

import os
import re
import socket
import termios
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

_PIECE = 4096
_LAST_S = 1.0
_ESCAPE = b"\xff"
"""Telnet's character that begins a command, and stands twice where it is data (RFC 854)."""
_COMMAND = re.compile(
    rb"\xff(?:(\xff)|[\xfb-\xfe].|\xfa(?:[^\xff]|\xff[^\xf0])*\xff\xf0|[^\xff\xfa-\xfe])", re.DOTALL
)
"""A whole command: data, an option, a subnegotiation, or one of two bytes."""


class PortUnreachable(Exception):
    """Error of a port that cannot be opened: ``str(error)`` has its address and the reason."""


def close_serial(port: Any) -> None:
    """Close a port of pyserial, and its socket too.

    pyserial 3.5 leaves the socket of ``socket://`` open if the peer has reset it, since its ``shutdown``
    fails first.
    """
    connection = getattr(port, "_socket", None)
    with suppress(OSError, ValueError, termios.error):
        port.close()
    if connection is not None:
        connection.close()


@contextmanager
def opened_port(address: str) -> Iterator[int]:
    """Open a port: its file descriptor, of a terminal in raw mode or of a socket.

    Raises:
        PortUnreachable: the address cannot be opened.
    """
    with ExitStack() as resources:
        try:
            scheme, is_url, place = address.rpartition("://")
            if is_url and scheme in ("socket", "rfc2217"):
                host, _, number = place.rpartition(":")
                connection = socket.create_connection((host.strip("[]"), int(number)))
                connection = resources.enter_context(connection)
                if scheme == "rfc2217":
                    connection = resources.enter_context(_unescaped(connection))
                port = connection.fileno()
            else:
                port = os.open(address, os.O_RDWR | os.O_NOCTTY)
                resources.callback(os.close, port)
                tty.setraw(port)
        except (OSError, ValueError, termios.error) as error:
            raise PortUnreachable(f"{address}: {error}") from error
        yield port


class TelnetData:
    """Data in a stream of Telnet, without its commands. ``held``: the beginning of one."""

    def __init__(self) -> None:
        self.held = b""

    def unescaped(self, data: bytes) -> bytes:
        """Return the data of the stream's next piece."""
        data, self.held = self.held + data, b""
        found, at = bytearray(), 0
        while (escape := data.find(_ESCAPE, at)) >= 0:
            found += data[at:escape]
            if not (command := _COMMAND.match(data, escape)):
                self.held = data[escape:]
                return bytes(found)
            found += command[1] or b""
            at = command.end()
        return bytes(found) + data[at:]


@contextmanager
def _unescaped(port: socket.socket) -> Iterator[socket.socket]:
    """Socket with the bytes of a connection to a port of RFC 2217: threads double and undouble its escapes.

    Offers of the port are left unanswered, so it has no baud of this client.
    """
    ours, theirs = socket.socketpair()

    def send() -> None:
        _carry(theirs, port, lambda data: data.replace(_ESCAPE, 2 * _ESCAPE))

    def receive() -> None:
        _carry(port, theirs, TelnetData().unescaped)

    threads = [threading.Thread(target=each, daemon=True) for each in (send, receive)]
    with ours, theirs:
        for thread in threads:
            thread.start()
        try:
            yield ours
        finally:
            with suppress(OSError):
                ours.shutdown(socket.SHUT_WR)
            threads[0].join(_LAST_S)  # what was written goes out first, if the board takes it
            with suppress(OSError):
                port.shutdown(socket.SHUT_RDWR)


def _carry(source: socket.socket, sink: socket.socket, change: Callable[[bytes], bytes]) -> None:
    """Carry changed bytes until the source has ended, which ends the sink, or the sink has gone."""
    with suppress(OSError):
        while data := source.recv(_PIECE):
            sink.sendall(change(data))
        sink.shutdown(socket.SHUT_WR)
