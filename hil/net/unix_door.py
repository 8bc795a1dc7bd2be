"""The control socket's listener, and what each of its visitors has to read and write."""

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable
from contextlib import closing, suppress
from pathlib import Path

from hil.net.visitors import Visit, Visitors

MAX_CLIENTS = 64
_BACKLOG = 128

log = logging.getLogger("hil")

Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter, Visit], Awaitable[None]]


def listen_at(path: Path) -> socket.socket:
    """A listening unix socket; whoever comes waits until ``let_in``.

    Raises:
        OSError: the socket cannot be made.
    """
    listener = socket.socket(socket.AF_UNIX)
    try:
        listener.bind(str(path))
        listener.listen(_BACKLOG)
    except OSError:
        listener.close()
        raise
    listener.setblocking(False)
    return listener


def let_in(listener: socket.socket, serve: Serve, line_limit: int) -> Visitors:
    """``serve`` is run for each client, and cancelled where it waits when its client has to go."""

    async def stay(connection: socket.socket, visit: Visit) -> None:
        try:
            reader, writer = await asyncio.open_unix_connection(sock=connection, limit=line_limit)
        except BaseException:
            connection.close()
            raise
        with closing(writer), suppress(ConnectionError):
            await serve(reader, writer, visit)

    visitors = Visitors("control socket", MAX_CLIENTS, asyncio.get_running_loop(), stay, log.warning)
    visitors.listen(listener)
    return visitors
