"""Clients of Modbus TCP: who is let in, and who has to go."""

import asyncio
import logging
import socket
import ssl
from collections import Counter
from collections.abc import Mapping

from bridges.modbus.door import certificate_files
from bridges.modbus.door.client_role import NoRole, role_of
from bridges.modbus.door.door_options import Certificates
from bridges.modbus.door.request_handler import Asker, RequestHandler
from bridges.modbus.door.tcp_client import TcpClient
from hil.net.fair_share import FairShare
from hil.net.visitors import Limit, Visit, Visitors
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import Role

log = logging.getLogger("hil")

CONNECTIONS = 64
HANDSHAKE_S = 5.0
_ANYBODY = Source("modbus client", Role.OPERATOR)


class TcpConnections:
    """Connections of Modbus TCP. ``certificates``: None: every client is an operator. ``closed``:
    connections that were closed by the door, by reason."""

    def __init__(self, handler: RequestHandler, certificates: Certificates | None) -> None:
        self._handler = handler
        self._roles: Mapping[str, str] = certificates.roles if certificates else {}
        self._tls = _context(certificates) if certificates else None
        self._visitors: Visitors | None = None
        self.closed: Counter[str] = Counter()

    def listen(self, listeners: list[socket.socket]) -> None:
        loop = asyncio.get_running_loop()
        self._said = Limit(log.info, loop)
        self._turns = FairShare()
        self._visitors = Visitors("modbus", CONNECTIONS, loop, self._stay, log.warning)
        for listener in listeners:
            self._visitors.listen(listener)

    @property
    def count(self) -> int:
        return len(self._visitors.visits) if self._visitors else 0

    @property
    def turned_away(self) -> int:
        return self._visitors.turned_away if self._visitors else 0

    async def close(self) -> None:
        if self._visitors:
            self._visitors.close()
            self._turns.close()
            await asyncio.gather(*self._visitors.send_away(), return_exceptions=True)
            self._said.close()

    async def _stay(self, connection: socket.socket, visit: Visit) -> None:
        client = TcpClient(self._handler, self._turns, visit, self._known)
        # Asyncio does so for its own sockets alone; without it an answer waits 40 ms for the one before.
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: client,
                connection,
                ssl=self._tls,
                ssl_handshake_timeout=HANDSHAKE_S if self._tls else None,
            )
        except OSError as error:  # of ssl, too
            self._close("tls", str(error))
            connection.close()
            return
        except BaseException:
            client.forget()  # with TLS its first request may be there already
            connection.close()
            raise
        await client.serve()
        if client.fault:
            self._close("framing", client.fault)

    def _known(self, transport: asyncio.Transport) -> Asker | None:
        """The client's address and role. None: it has no role."""
        if self._tls is None:
            return Asker(_ANYBODY)
        certificate = transport.get_extra_info("ssl_object").getpeercert(binary_form=True)
        try:
            name, role = role_of(certificate or b"", self._roles)
        except NoRole as error:
            self._close("role", str(error))
            return None
        return Asker(Source(f"modbus client {name}", role))

    def _close(self, reason: str, why: str) -> None:
        self.closed[reason] += 1
        self._said.reached(f"bridges.modbus: a connection was closed: {why}")


def _context(certificates: Certificates) -> ssl.SSLContext:
    """TLS of the door. Raises BridgeError: a file cannot be used."""
    files = certificates.files
    for option, message, remedy in certificate_files.problems(files):
        raise BridgeError(f"tls.{option}: {message}; {remedy}")
    try:
        return certificate_files.context(files)
    except (OSError, ValueError) as error:  # what no check finds
        raise BridgeError(f"tls: {error}") from None
