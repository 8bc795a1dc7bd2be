"""Clients of pymodbus whose connection is one to a door in memory."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from pymodbus.client import AsyncModbusTcpClient, ModbusTcpClient
from pymodbus.exceptions import ConnectionException

from bridges.modbus.testing.memory_connection import MemoryConnection
from hil.testing.doors.door_time import DoorTime
from hil.vocab.time import NS_PER_S

Connect = Callable[[Callable[[bytes], None]], MemoryConnection | None]
"""Connects to a door; called with what hears the door. None: there is no connection."""


class _Received:
    """The client's end of a connection, in place of a socket."""

    def __init__(self) -> None:
        self.connection: MemoryConnection | None = None
        self.held = bytearray()
        self.has_ended = False

    def hear(self, data: bytes) -> None:
        self.held += data
        self.has_ended |= not data

    def send(self, data: bytes) -> int:
        """Send to the door. Whether it has hung up shows when its answer is read, as at a socket."""
        if self.connection:
            self.connection.send(data)
        return len(data)

    def close(self) -> None:
        if self.connection:
            self.connection.hang_up()


class BenchTcpClient(ModbusTcpClient):
    """``ModbusTcpClient`` at a bench: a request lets simulated time pass until its answer, or the time-out.
    ``options``: those of pymodbus."""

    def __init__(
        self, time: DoorTime, connect: Connect, host: str, port: int, options: Mapping[str, Any]
    ) -> None:
        super().__init__(host, **{"port": port} | dict(options))
        self._time, self._connect = time, connect

    def connect(self) -> bool:
        """Connect to the door; answers whether there is a connection."""
        if not self.socket:
            received = _Received()
            if connection := self._connect(received.hear):
                received.connection = connection
                self.socket = received  # type: ignore[assignment]
        return self.socket is not None

    def recv(self, size: int | None) -> bytes:
        """Receive what comes first, within the time-out of simulated time; nothing: it is over."""
        received: Any = self.socket
        if not received:
            raise ConnectionException(str(self))
        began_ns = self._time.now_ns()
        until_ns = began_ns + round((self.comm_params.timeout_connect or 0) * NS_PER_S)
        self._time.wait(lambda: received.held or received.has_ended, until_ns, "an answer")
        if received.has_ended and not received.held:
            waited_s = (self._time.now_ns() - began_ns) / NS_PER_S
            return self._handle_abrupt_socket_close(size, [], waited_s)
        data = bytes(received.held[:size])
        del received.held[: len(data)]
        return data


class AsyncBenchTcpClient(AsyncModbusTcpClient):
    """``AsyncModbusTcpClient`` at a bench, whose time passes while all tasks of its event loop wait."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        connect: Connect,
        host: str,
        port: int,
        options: Mapping[str, Any],
    ) -> None:
        super().__init__(host, **{"port": port} | dict(options))
        self._loop, self._connect = loop, connect
        self.ctx.call_create = self._create

    async def _create(self) -> tuple[asyncio.Transport, asyncio.BaseProtocol]:
        transport = _ClientTransport(self._loop, self.ctx)
        transport.connection = self._connect(transport.hear)
        if transport.connection is None:
            raise ConnectionRefusedError("the door of the bench lets nobody in")
        self.ctx.connection_made(transport)
        return transport, self.ctx


class _ClientTransport(asyncio.Transport):
    """Transport of an asynchronous client."""

    def __init__(self, loop: asyncio.AbstractEventLoop, protocol: Any) -> None:
        super().__init__()
        self.connection: MemoryConnection | None = None
        self._loop, self._protocol = loop, protocol
        self._is_closing = False

    def hear(self, data: bytes) -> None:
        """Hand on what the door sends, in the client's loop."""
        if not self._loop.is_closed():
            self._loop.call_soon(self._hand_on, data)

    def _hand_on(self, data: bytes) -> None:
        if self._is_closing:
            return
        if data:
            self._protocol.data_received(data)
        else:
            self._is_closing = True
            self._protocol.connection_lost(None)

    def write(self, data: Any) -> None:
        if self.connection and not self._is_closing:
            self.connection.send(data)

    def is_closing(self) -> bool:
        return self._is_closing

    def close(self) -> None:
        """Hang up. The client notes it itself."""
        if not self._is_closing:
            self._is_closing = True
            if self.connection:
                self.connection.hang_up()

    abort = close
