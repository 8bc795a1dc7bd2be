"""Modbus bridge of a bench in memory: its TCP door without sockets, in simulated time."""

import ssl
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bridges.modbus.door.door_options import Options
from bridges.modbus.door.modbus_bridge import ModbusBridge
from bridges.modbus.door.tcp_client import TcpClient, TcpConnections
from bridges.modbus.testing.bench_clients import AsyncBenchTcpClient, BenchTcpClient
from bridges.modbus.testing.memory_connection import MemoryConnection
from hil.net.endpoint import endpoint
from hil.net.fair_share import FairShare
from hil.testing.doors.door_time import DoorTime
from hil.vocab.desk_protocol import Desk


class _EqualTurns(FairShare):
    """Turns that do not depend on the computer's speed."""

    def note(self, client: object | None, took_s: float) -> None:
        """Count no time: simulated time stands still meanwhile."""


class _Connections(TcpConnections):
    """Connections in memory. Handshakes of TLS are left out: a client's certificate is taken as it is."""

    async def connect(self, connection: Any, client: TcpClient) -> None:
        connection.occupy(client)


class MemoryModbusDoor:
    """Door of a bench for pymodbus's clients."""

    def __init__(self, options: Options, desk: Desk, time: DoorTime) -> None:
        self._options, self._time = options, time
        self._bridge = ModbusBridge(options, desk)
        self._connections: TcpConnections | None = None

    async def open(self) -> None:
        """Let clients in. Raises BridgeError: as the bridge does."""
        self._connections = self._bridge.connections(
            lambda handler, certificates: _Connections(handler, certificates, _EqualTurns)
        )
        self._connections.listen([])

    def connect(self, certificate: bytes | None, heard: Callable[[bytes], None]) -> MemoryConnection | None:
        """Connect to the door; None: it lets nobody in, or not this one."""
        if self._connections is None:
            return None
        made = MemoryConnection(self._time, certificate, heard)
        self._connections.admit(made)
        self._time.loop.turn()
        return None if made.is_closing() else made

    def client(self, options: Mapping[str, Any]) -> BenchTcpClient:
        """Client that is connected. ``options``: of pymodbus's ``ModbusTcpClient``, and ``certificate``, a
        path, where the door asks for one."""
        host, port, certificate, given = self._given(options)
        made = BenchTcpClient(self._time, lambda heard: self.connect(certificate, heard), host, port, given)
        made.connect()
        return made

    def async_client(self, options: Mapping[str, Any]) -> AsyncBenchTcpClient:
        """Client for the event loop that runs now, not yet connected; ``options`` as for ``client``."""
        loop = self._time.join_running_loop()
        host, port, certificate, given = self._given(options)
        return AsyncBenchTcpClient(loop, lambda heard: self.connect(certificate, heard), host, port, given)

    def _given(self, options: Mapping[str, Any]) -> tuple[str, int, bytes | None, dict[str, Any]]:
        given = dict(options)
        path = given.pop("certificate", None)
        certificate = ssl.PEM_cert_to_DER_cert(Path(path).read_text()) if path else None
        host, port = endpoint(self._options.listen)
        return host, port, certificate, given

    def close(self) -> None:
        """Cut the clients off, and let nobody in any more."""
        connections, self._connections = self._connections, None
        if connections:
            self._time.loop.complete(self._bridge.close())
