"""Listening sockets of a bridge."""

import asyncio
import errno
import os
import socket

from hil.net.endpoint import endpoint
from hil.vocab.bridge_protocol import BridgeError

_BACKLOG = 128


class AddressTaken(BridgeError):
    """Error of an address at which another program listens."""


async def open_listeners(listen: str) -> list[socket.socket]:
    """Listen at each address of a name, as ::1 and 127.0.0.1 for localhost. ``listen``: as ``endpoint`` takes
    it.

    Raises:
        AddressTaken: another program has it.
        BridgeError: it is no address of this computer, or this program may not listen there.
    """
    try:
        return await _listeners(*endpoint(listen))
    except (socket.gaierror, UnicodeError):
        raise BridgeError(
            f"listen: {listen}: no such host; use 127.0.0.1, or an address of this machine"
        ) from None
    except OSError as error:
        why = os.strerror(error.errno or 0)
        kind = AddressTaken if error.errno == errno.EADDRINUSE else BridgeError
        raise kind(f"listen: {listen}: {why}; choose another") from None


async def _listeners(host: str, number: int) -> list[socket.socket]:
    loop = asyncio.get_running_loop()
    found = await loop.getaddrinfo(host, number, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    listeners: list[socket.socket] = []
    for at, (family, _, _, _, address) in enumerate(found):
        try:
            listener = socket.create_server(address, family=family, backlog=_BACKLOG)
        except OSError as error:
            is_last = at == len(found) - 1
            if error.errno in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT) and (listeners or not is_last):
                continue  # a computer without IPv6
            for each in listeners:
                each.close()
            raise
        listener.setblocking(False)
        listeners.append(listener)
        if number == 0:
            break  # one free port, not another for each
    return listeners


def address_shown(listener: socket.socket) -> str:
    """Format where a socket listens, as in ``[::1]:9464``."""
    host, number = listener.getsockname()[:2]
    return f"[{host}]:{number}" if ":" in host else f"{host}:{number}"
