"""The web bridge: what it is made of, and its connections."""

import asyncio
import logging
import socket
from collections.abc import Collection, Mapping
from ssl import SSLContext
from typing import Any

from aiohttp import web

from bridges.web.bench_words import BenchWords
from bridges.web.http_door import ANY, HostNames, HttpDoor
from bridges.web.locks import NoLock, PasswordLock, TokenLock
from bridges.web.open_pages import CLOSE_S, OpenPages, PageConnection
from bridges.web.page_files import read_page
from bridges.web.shared_reading import SharedReading
from bridges.web.tls_files import context
from bridges.web.web_client import Exports, Surroundings
from bridges.web.web_options import FIRST_PORT, LAST_PORT, PROXY, Options
from bridges.web.web_terminals import SharedPorts
from bridges.web.web_users import UsersError, read_users
from hil.net.acceptor import abort
from hil.net.endpoint import authority, has_port, is_loopback
from hil.net.fair_share import FairShare
from hil.net.listeners import LISTEN, AddressTaken, address_shown, open_listeners
from hil.net.visitors import NO_ROOM, Visit, Visitors
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Desk, Source
from hil.vocab.verbs import Role

OURS = Source("web", Role.VIEWER)
"""Source of what the bridge reads for all pages."""
HTTP_CLIENTS = 32
"""Connections beside those of pages: files, and who logs in."""
KEPT_S = 30.0
"""Time for which a connection without a request is kept."""
TLS_S = 10.0
"""Maximum time for a TLS handshake."""
SEND_BYTES = 128 * 1024
"""Buffer of the system for a page: what is in it cannot be dropped any more."""

log = logging.getLogger("hil")
_SILENT = logging.Logger("bridges.web")  # what clients do wrong is answered and counted, and not logged
_SILENT.addHandler(logging.NullHandler())


class _Server(web.Server):
    """Server of connections that tell what they do."""

    def __call__(self) -> PageConnection:
        loop = asyncio.get_running_loop()
        return PageConnection(
            self, loop=loop, access_log=None, logger=_SILENT, keepalive_timeout=KEPT_S, lingering_time=0
        )


class WebBridge:
    """Web bridge, a ``hil.vocab.bridge_protocol.Bridge``."""

    def __init__(self, options: Options, desk: Desk) -> None:
        self._options, self._desk = options, desk
        self._visitors: Visitors | None = None
        self._door: HttpDoor | None = None
        self._server: _Server | None = None
        self._tls: SSLContext | None = None
        self._pages: OpenPages | None = None
        self._listen: list[str] = []
        self._visits: dict[object, Visit] = {}
        """Visits by the connections' protocols."""

    async def open(self) -> None:
        options, loop = self._options, asyncio.get_running_loop()
        lock = await loop.run_in_executor(None, self._lock)
        page = await loop.run_in_executor(None, read_page)
        if options.tls:
            try:
                self._tls = context(options.tls.certificate, options.tls.key)
            except (OSError, ValueError) as error:
                raise BridgeError(f"tls: {error}; `hil check` says more") from None
        listeners = await self._listeners()
        port = listeners[0].getsockname()[1]
        self._listen = [address_shown(each) for each in listeners]
        hosts = HostNames("https" if self._tls else "http", options.host, port, options.names)
        shared = {name: SharedReading(self._desk, OURS, name) for name in ("status", "faults")}
        message_bytes = options.message_kb * 1024
        around = Surroundings(
            self._desk,
            BenchWords(self._desk, page.version, message_bytes),
            shared,
            {},
            SharedPorts(),
            FairShare(),
            Exports(),
            options.messages_per_s,
            options.samples_per_s,
        )
        self._pages = pages = OpenPages(around, options.sockets, message_bytes)
        self._door = HttpDoor(hosts, page, lock, f"hil-{port}", self._enter, pages.leave)
        self._server = _Server(self._door.answer)
        refusal = b"" if self._tls else NO_ROOM
        most = options.sockets + HTTP_CLIENTS
        self._visitors = Visitors("web", most, loop, self._stay, log.warning, refusal)
        for listener in listeners:
            self._visitors.listen(listener)
        if isinstance(lock, TokenLock):
            log.info("bridges.web: the token of this run is %s", lock.token)
        if risk := self._risk():
            log.warning("bridges.web: insecure: %s", risk)

    async def close(self) -> None:
        visitors, self._visitors = self._visitors, None
        if visitors is None or self._pages is None:
            return
        visitors.close()
        await self._pages.close()
        await asyncio.gather(*visitors.send_away(), return_exceptions=True)
        if self._server:
            await self._server.shutdown(CLOSE_S)

    async def devices_changed(self, names: Collection[str]) -> None:
        """Tell all pages, which get the whole description again."""
        if self._pages is not None:
            await self._pages.changed(names)

    def status(self) -> Mapping[str, Any]:
        options, pages = self._options, self._pages
        listen = self._listen or [authority(options.host, options.port or FIRST_PORT)]
        counters = pages.counters() if pages else {"commands": 0, "rejected": 0, "dropped": 0}
        turned_away = self._visitors.turned_away if self._visitors else 0
        refused = self._door.rejected if self._door else 0
        return {
            "root": self._url(listen[0]),
            "listen": listen,
            "connect": [],
            "links": len(pages) if pages else 0,
            **counters,
            "rejected": turned_away + refused + counters["rejected"],
            "insecure": bool(self._risk()),
            "risk": self._risk(),
        }

    def _url(self, listens_at: str) -> str:
        """Address of the page in a browser; by a name that it answers to, where it listens everywhere."""
        options = self._options
        host, port = listens_at.rsplit(":", 1)
        if options.host in ANY:
            host = options.names[0] if options.names else "localhost"
            if host.startswith(PROXY):
                return f"{host}/"
        at = host if has_port(host) else f"{host}:{port}"
        return f"{'https' if options.tls else 'http'}://{at}/"

    def _risk(self) -> str:
        """Risk of an open door, as a text; empty: there is none."""
        options = self._options
        if is_loopback(options.host):
            return ""
        if not (options.users or options.token):
            return "every program that can reach it may do everything"
        return "" if options.tls else "the network can read passwords and all else"

    def _lock(self) -> NoLock | TokenLock | PasswordLock:
        if self._options.token:
            return TokenLock(self._options.token)
        if not self._options.users:
            return NoLock()
        try:
            return PasswordLock(read_users(self._options.users))
        except UsersError as error:
            raise BridgeError(f"users: {error}") from None

    async def _listeners(self) -> list[socket.socket]:
        host, port = self._options.host, self._options.port
        wanted = range(FIRST_PORT, LAST_PORT + 1) if port is None else [port]
        for each in wanted:
            try:
                return await open_listeners(authority(host, each), names_holder=port is not None)
            except AddressTaken:
                if port is not None:
                    raise
        taken = (
            f"ports {FIRST_PORT} to {LAST_PORT} of {authority(host, None)} are in use; choose another port"
        )
        raise BridgeError(taken, LISTEN)

    # ---- connections ----

    async def _stay(self, connection: socket.socket, visit: Visit) -> None:
        """Serve one connection until it ends."""
        assert self._server is not None
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BYTES)
        protocol = self._server()
        self._visits[protocol] = visit
        loop = asyncio.get_running_loop()
        transport: asyncio.BaseTransport | None = None
        try:
            timeout_s = TLS_S if self._tls else None
            transport, _ = await loop.connect_accepted_socket(
                lambda: protocol, connection, ssl=self._tls, ssl_handshake_timeout=timeout_s
            )
            await protocol.ended.wait()
        except OSError:
            connection.close()  # it is no TLS, or has gone already
        finally:
            del self._visits[protocol]
            if isinstance(transport, asyncio.Transport):
                abort(transport)

    async def _enter(self, request: web.BaseRequest, source: Source, session: str) -> web.StreamResponse:
        """Take a page in. Its connection is not let go for others meanwhile."""
        assert self._pages is not None
        visit = self._visits[request.protocol]
        visit.is_busy = visit.has_asked = True
        try:
            return await self._pages.enter(request, source, session)
        finally:
            visit.is_busy = False
