"""Client of a port by its address, as any other client."""

import os
import socket
import termios
import tty
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager


class PortUnreachable(Exception):
    """Error of a port that cannot be opened: ``str(error)`` has its address and the reason."""


@contextmanager
def opened_port(address: str) -> Iterator[int]:
    """Open a port: its file descriptor, of a terminal in raw mode or of a socket.

    Raises:
        PortUnreachable: the address cannot be opened.
    """
    with ExitStack() as resources:
        try:
            if address.startswith("socket://"):
                host, _, number = address.removeprefix("socket://").rpartition(":")
                connection = socket.create_connection((host.strip("[]"), int(number)))
                port = resources.enter_context(connection).fileno()
            else:
                port = os.open(address, os.O_RDWR | os.O_NOCTTY)
                resources.callback(os.close, port)
                tty.setraw(port)
        except (OSError, ValueError, termios.error) as error:
            raise PortUnreachable(f"{address}: {error}") from error
        yield port
