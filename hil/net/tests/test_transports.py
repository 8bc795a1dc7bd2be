"""Connections that are ended more than once."""

import asyncio
import socket

from hil.net.acceptor import abort


def test_a_connection_that_sent_its_last_words_can_be_aborted() -> None:
    async def run() -> bytes:
        ours, theirs = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        loop, ended = asyncio.get_running_loop(), asyncio.Event()

        class Ends(asyncio.Protocol):
            def connection_lost(self, error: Exception | None) -> None:
                ended.set()

        transport, _ = await loop.connect_accepted_socket(Ends, ours)
        transport.write(bytes(1 << 20))
        transport.close()
        reader, writer = await asyncio.open_connection(sock=theirs)
        read = await reader.read(-1)
        await ended.wait()
        abort(transport)
        abort(transport)
        writer.close()
        return read

    assert len(asyncio.run(run())) == 1 << 20


def test_what_waits_to_be_sent_is_dropped() -> None:
    async def run() -> int:
        ours, theirs = socket.socketpair()
        transport, _ = await asyncio.get_running_loop().connect_accepted_socket(asyncio.Protocol, ours)
        transport.write(bytes(1 << 24))
        transport.close()
        abort(transport)
        reader, writer = await asyncio.open_connection(sock=theirs)
        read = await reader.read(-1)
        writer.close()
        return len(read)

    assert asyncio.run(run()) < 1 << 24
