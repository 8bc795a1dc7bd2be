"""Listening sockets of doors and ports, and the one text for an address that cannot be had."""

import asyncio
import errno
import os
import socket

from hil.net.endpoint import authority, endpoint
from hil.vocab.bridge_protocol import BridgeError

_BACKLOG = 128
LISTEN = ("listen",)
"""Option that has the address."""


class ListenRefused(Exception):
    """Error of an address at which this program cannot listen: ``str(error)`` says why, and what to do.
    ``is_taken``: another program has it."""

    def __init__(self, why: str, *, is_taken: bool = False) -> None:
        super().__init__(why)
        self.is_taken = is_taken


class AddressTaken(BridgeError):
    """Error of an address at which another program listens."""


async def open_listeners(listen: str, *, names_holder: bool = True) -> list[socket.socket]:
    """Listen at each address of a name, as ::1 and 127.0.0.1 for localhost. ``listen``: as ``endpoint`` takes
    it; ``names_holder``: look for who has it.

    Raises:
        AddressTaken: another program has it.
        BridgeError: it is no address of this computer, or this program may not listen there.
    """
    try:
        return await listeners_at(*endpoint(listen), names_holder=names_holder)
    except ListenRefused as refused:
        kind = AddressTaken if refused.is_taken else BridgeError
        raise kind(str(refused), LISTEN) from None


async def why_refused(listen: str) -> ListenRefused | None:
    """Reason why nobody could listen at an address now; None: one could, or it is none of ours, as one with
    options of zenoh's behind it."""
    try:
        host, number = endpoint(listen)
    except ValueError:
        return None
    try:
        for each in await listeners_at(host, number):
            each.close()
    except ListenRefused as refused:
        return refused
    return None


async def listeners_at(
    host: str, number: int, most: int | None = None, *, names_holder: bool = True
) -> list[socket.socket]:
    """Listen at each address of a host, at the first ``most`` of them. Raises ListenRefused."""
    loop, shown = asyncio.get_running_loop(), authority(host, number)
    try:
        found = await loop.getaddrinfo(host, number, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, UnicodeError):  # socket.gaierror is an OSError
        raise ListenRefused(
            f"there is no computer {host!r}; write 127.0.0.1, or an address of this computer"
        ) from None
    listeners: list[socket.socket] = []
    for at, (family, _, _, _, address) in enumerate(found[:most]):
        try:
            listener = socket.create_server(address[:2], family=family, backlog=_BACKLOG)
        except OSError as error:
            is_last = at == len(found[:most]) - 1
            if error.errno in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT) and (listeners or not is_last):
                continue  # a computer without IPv6
            for each in listeners:
                each.close()
            raise refusal(error, shown, str(address[0]) if names_holder else "", number) from error
        listener.setblocking(False)
        listeners.append(listener)
        if number == 0:
            break  # one free port, not another for each
    return listeners


def refusal(error: OSError, listen: str, host: str = "", number: int = 0) -> ListenRefused:
    """Make words of an error of bind(2). ``listen``: as the user wrote it; ``host``: the address that it
    stands for, empty if nobody wants to know who has it."""
    match error.errno:
        case errno.EADDRINUSE:
            from hil.net.address_holder import address_holder  # nobody has it, most times

            by = f" by {who}" if (who := address_holder(host, number)) else ""
            return ListenRefused(f"{listen} is in use{by}; choose another port, or end it", is_taken=True)
        case errno.EADDRNOTAVAIL | errno.EAFNOSUPPORT:
            why = f"{listen} is no address of this computer; write 127.0.0.1, or one that `ip address` shows"
        case errno.EACCES | errno.EPERM:
            why = f"no right to listen at {listen}; choose a port above 1023, or give the right to this user"
        case number_of_error:
            why = f"cannot listen at {listen}: {os.strerror(number_of_error or 0)}; choose another address"
    return ListenRefused(why)


def address_shown(listener: socket.socket) -> str:
    """Format where a socket listens, as in ``[::1]:9464``."""
    return authority(*listener.getsockname()[:2])
