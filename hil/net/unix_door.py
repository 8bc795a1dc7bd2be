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


def open_door(path: Path, serve: Serve, line_limit: int) -> Visitors:
    """A listening unix socket. ``serve`` is run for each client, and cancelled where it waits when its client
    has to go.

    Raises:
        OSError: the socket cannot be made.
    """

    async def stay(connection: socket.socket, visit: Visit) -> None:
        try:
            reader, writer = await asyncio.open_unix_connection(sock=connection, limit=line_limit)
        except BaseException:
            connection.close()
            raise
        with closing(writer), suppress(ConnectionError):
            await serve(reader, writer, visit)

    listener = socket.socket(socket.AF_UNIX)
    try:
        listener.bind(str(path))
        listener.listen(_BACKLOG)
    except OSError:
        listener.close()
        raise
    listener.setblocking(False)
    visitors = Visitors("control socket", MAX_CLIENTS, asyncio.get_running_loop(), stay, log.warning)
    visitors.listen(listener)
    return visitors
