"""Client of a bridge that is checked: it asks, throws bytes, stays silent and says too much."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from typing import Any

from hil.testing.checks.findings import raised
from hil.testing.checks.running_checks import Wrong

STILL_S = 0.1
"""Time in which what must not happen would."""
FIRST_S = 0.5
"""Silence after which the first answer is whole."""
ENDLESS_BYTES = 4 << 20

Status = Mapping[str, Any]
Ask = Callable[[Status], Awaitable[object]]
"""Asks a bridge for something as a client, by its ``status()``; answers what came."""


class BridgeClient:
    """Client of a bridge, at the addresses of its ``status()``. ``request``: bytes that are answered at the
    first, over TCP; or ``ask``, which asks in another way."""

    def __init__(self, request: bytes | None, ask: Ask | None, patience_s: float) -> None:
        self._request, self._ask = request, ask or self._ask_by_tcp
        self._patience_s = patience_s
        self._answer_bytes = 0
        """Length of the first answer."""

    async def asked(self, status: Status) -> object:
        """Ask; answers what came.

        Raises:
            Wrong: nothing did.
        """
        try:
            async with asyncio.timeout(self._patience_s):
                answer = await self._ask(status)
        except (OSError, EOFError, TimeoutError) as error:
            raise Wrong(f"a request was not answered: {raised(error)}") from None
        if not answer:
            raise Wrong("a request was answered with nothing")
        return answer

    async def asked_byte_by_byte(self, status: Status) -> bytes:
        """Ask as ``asked``, with the request's bytes one by one."""
        try:
            async with asyncio.timeout(self._patience_s):
                return await self._ask_by_tcp(status, one_by_one=True)
        except (OSError, TimeoutError) as error:
            raise Wrong(f"a request that comes byte by byte is not answered: {raised(error)}") from None

    async def _ask_by_tcp(self, status: Status, *, one_by_one: bool = False) -> bytes:
        assert self._request is not None, "give check_bridge a request, or ask"
        reader, writer = await connected(status)
        try:
            for piece in [bytes([byte]) for byte in self._request] if one_by_one else [self._request]:
                writer.write(piece)
                await writer.drain()
                if one_by_one:
                    await asyncio.sleep(0.002)
            answer = await reader.read(1 << 16)
            while answer and len(answer) < self._answer_bytes and (more := await reader.read(1 << 16)):
                answer += more
            with suppress(TimeoutError):
                async with asyncio.timeout(STILL_S if self._answer_bytes else FIRST_S):
                    while more := await reader.read(1 << 16):
                        answer += more
            self._answer_bytes = self._answer_bytes or len(answer)
            return answer
        finally:
            writer.transport.abort()

    async def throw(self, status: Status, data: bytes) -> None:
        """Throw bytes at an address, and leave."""
        if not status["listen"]:
            return
        loop, address = asyncio.get_running_loop(), _address(status)
        with suppress(OSError, TimeoutError):
            transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, remote_addr=address)
            transport.sendto(data[:1000])
            await asyncio.sleep(0)
            transport.close()
        with suppress(OSError, TimeoutError):
            _, writer = await connected(status)
            writer.write(data)
            with suppress(OSError, TimeoutError):
                async with asyncio.timeout(STILL_S):
                    await writer.drain()
            writer.transport.abort()
        await asyncio.sleep(STILL_S)

    async def is_heard_for_ever(self, status: Status) -> bool:
        """Send one letter ``ENDLESS_BYTES`` times; answers whether all are read, and the client is kept."""
        reader, writer = await connected(status)
        is_taken = False
        try:
            async with asyncio.timeout(self._patience_s):
                for _ in range(ENDLESS_BYTES // 65536):
                    writer.write(b"a" * 65536)
                    await writer.drain()
                is_taken = True
                await reader.read(1)
                return False  # it says why not, or leaves
        except ConnectionError:
            return False
        except TimeoutError:
            return is_taken
        finally:
            writer.transport.abort()


async def connected(status: Status) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Come to the first address of a bridge, over TCP."""
    return await asyncio.open_connection(*_address(status))


def _address(status: Status) -> tuple[str, int]:
    """Host and port of the first address, as in ``127.0.0.1:80`` or ``tcp/[::1]:7447``."""
    host, _, number = str(status["listen"][0]).rpartition("/")[2].rpartition(":")
    return host.strip("[]"), int(number)
