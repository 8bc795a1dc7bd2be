"""HTTP of the door: the page's files, logging in, and the way to the WebSocket."""

import asyncio
import logging
import secrets
from collections.abc import Awaitable, Callable, Iterable, Mapping
from math import ceil
from typing import Any, Protocol

from aiohttp import web

from bridges.web.login_sessions import LoginLimit, Sessions
from bridges.web.page_files import PageFiles
from bridges.web.web_options import PROXY
from hil.net.endpoint import authority, has_port
from hil.vocab.desk_protocol import Source
from hil.wire.json_text import JsonError, json_text, read_json

LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANY = ("0.0.0.0", "::")
"""Hosts that stand for all addresses of this computer."""
_DEFAULT_PORT = {"http": 80, "https": 443}


class HostNames:
    """Names of the door. ``scheme``: http or https; ``names``: as the options have them."""

    def __init__(self, scheme: str, host: str, port: int, names: Iterable[str]) -> None:
        own = {authority(each, port) for each in (*LOOPBACK, *([] if host in ANY else [host]))}
        own |= {_with_port(name, port) for name in names if not name.startswith(PROXY)}
        proxies = {_with_port(name.removeprefix(PROXY), 443) for name in names if name.startswith(PROXY)}
        self._schemes = _as_headers(own, scheme) | _as_headers(proxies, "https")
        """Scheme by which browsers reach each name, as the header ``Host`` has it: http or https."""

    def is_known(self, host: str | None) -> bool:
        """True if the header ``Host`` has a name of the door."""
        return host is not None and host.lower() in self._schemes

    def is_own(self, origin: str | None, host: str) -> bool:
        """True if the header ``Origin`` names the page that ``host`` has, or is not there: browsers send it
        with each WebSocket, and whenever something is posted."""
        return origin is None or origin.lower() == f"{self.scheme_of(host)}://{host.lower()}"

    def scheme_of(self, host: str) -> str:
        """Scheme by which browsers reach a name that is known: http or https."""
        return self._schemes[host.lower()]


def _as_headers(names: Iterable[str], scheme: str) -> dict[str, str]:
    """Names as browsers write them, with and without the port that belongs to ``scheme``."""
    ending = f":{_DEFAULT_PORT[scheme]}"
    short = {name.removesuffix(ending) for name in names}
    return dict.fromkeys((name.lower() for name in {*names, *short}), scheme)


def _with_port(name: str, port: int) -> str:
    return name if has_port(name) else f"{name}:{port}"


SUBPROTOCOL = "hil.v1"
WEBSOCKET_VERSION = "13"
"""The only one of RFC 6455 (4.1); the library lets drafts pass."""
LOGIN_BYTES = 4096
LOGIN_S = 10.0
"""Maximum time for a browser to say who it is."""
SECURITY: Mapping[str, str] = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:;"
        " connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "Server": "hil",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
"""Headers of every answer."""

log = logging.getLogger("hil")

Enter = Callable[[web.BaseRequest, Source, str], Awaitable[web.StreamResponse]]
"""Takes a page in, with its user and session, until it leaves."""


class Lock(Protocol):
    """Check of those who come to the door. ``way``: none, token or password."""

    way: str
    open_to: Source | None
    """The source that everybody is, if nobody has to log in."""

    async def opened(self, given: Mapping[str, Any]) -> Source | None:
        """User who is meant by what was given, or None."""


class HttpDoor:
    """Answers requests. ``enter``: takes in those who come to the WebSocket; ``left``: ends a session's
    pages."""

    def __init__(
        self,
        hosts: HostNames,
        page: PageFiles,
        lock: Lock,
        cookie: str,
        enter: Enter,
        left: Callable[[str], None],
    ) -> None:
        self._hosts, self._page, self._lock, self._cookie = hosts, page, lock, cookie
        self._enter, self._left = enter, left
        self._sessions, self._limit = Sessions(), LoginLimit()
        self.rejected = 0

    async def answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request; of hil's own errors 500."""
        try:
            response = await self._routed(request)
        except web.HTTPException as error:
            response = _text(error.status, error.text or "")
        except Exception:  # hil's own error: this request is lost, the door stays open
            log.exception("bridges.web: %r could not be answered", request.path)
            response = _text(500, "It met a fault of hil's own; the bench's log says more.")
        if response.status >= 400:
            self.rejected += 1
        if not response.prepared:
            response.headers.update(SECURITY)
        return response

    async def _routed(self, request: web.BaseRequest) -> web.StreamResponse:
        host = request.headers.get("Host")
        if host is None or not self._hosts.is_known(host):
            return _text(421, "This bench has another name; `names` in bridges.web says which it answers to.")
        if not self._hosts.is_own(request.headers.get("Origin"), host):
            return _text(403, "Pages of other sites may not talk to this bench.")
        match request.method, request.path:
            case "GET", "/ws":
                return await self._socket(request)
            case "GET" | "HEAD", "/api/hello":
                return _json(self._hello(request))
            case "POST", "/api/login":
                return await self._log_in(request)
            case "POST", "/api/logout":
                return self._log_out(request)
            case _, "/ws" | "/api/hello":
                return _not_so("GET")
            case _, "/api/login" | "/api/logout":
                return _not_so("POST")
            case "GET" | "HEAD", path:
                return self._file(request, path)
        return _not_so("GET")

    def _hello(self, request: web.BaseRequest) -> dict[str, Any]:
        user = self._user(request)
        told = {"version": self._page.version, "login": self._lock.way}
        return told | {"user": user.name if user else None, "role": user.role.name.lower() if user else None}

    def _user(self, request: web.BaseRequest) -> Source | None:
        if self._lock.open_to:
            return self._lock.open_to
        return self._sessions.find(request.cookies.get(self._cookie, ""), _now_s())

    async def _socket(self, request: web.BaseRequest) -> web.StreamResponse:
        if (user := self._user(request)) is None:
            return _text(401, "Log in first.")
        offered = request.headers.get("Sec-WebSocket-Protocol", "")
        if request.headers.get("Upgrade", "").lower() != "websocket":
            return _text(426, "This is for WebSockets.", Upgrade="websocket")
        if request.headers.get("Sec-WebSocket-Version") != WEBSOCKET_VERSION:
            version = {"Sec-WebSocket-Version": WEBSOCKET_VERSION}
            return _text(426, f"The version is {WEBSOCKET_VERSION}.", Upgrade="websocket", **version)
        if SUBPROTOCOL not in [each.strip() for each in offered.split(",")]:
            return _text(400, f"The subprotocol is {SUBPROTOCOL}.")
        session = request.cookies.get(self._cookie, "")
        with self._sessions.in_use(session, _now_s):
            return await self._enter(request, user, session)

    async def _log_in(self, request: web.BaseRequest) -> web.StreamResponse:
        if self._lock.open_to:
            return _empty(204)
        if request.content_type != "application/json":
            return _text(415, "Write application/json.")
        given = await _given(request)
        if given is None:
            return _text(400, 'Write {"user": "...", "password": "..."}, or {"token": "..."}.')
        if wait_s := self._limit.wait_s(request.remote or "", _now_s()):
            return _text(429, "Too many attempts; wait a little.", **{"Retry-After": f"{ceil(wait_s)}"})
        if (user := await self._lock.opened(given)) is None:
            log.warning("bridges.web: somebody at %s could not log in", request.remote)
            return _text(401, "That is not right.")
        self._limit.succeeded(request.remote or "")
        key = secrets.token_urlsafe(32)
        self._sessions.begin(key, user, _now_s())
        response = _empty(204)
        response.set_cookie(
            self._cookie,
            key,
            path="/",
            httponly=True,
            samesite="Strict",
            secure=self._hosts.scheme_of(request.headers["Host"]) == "https",
        )
        return response

    def _log_out(self, request: web.BaseRequest) -> web.StreamResponse:
        if key := request.cookies.get(self._cookie, ""):
            self._sessions.end(key)
            self._left(key)
        response = _empty(204)
        response.del_cookie(self._cookie, path="/", httponly=True, samesite="Strict")
        return response

    def _file(self, request: web.BaseRequest, path: str) -> web.Response:
        if (file := self._page.files.get(path)) is None:
            return _text(404, "There is nothing here.")
        headers = {"ETag": file.etag, "Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
        if file.etag in request.headers.get("If-None-Match", ""):
            return web.Response(status=304, headers=headers)
        body, headers["Content-Type"] = file.content, file.content_type
        if file.compressed and "gzip" in request.headers.get("Accept-Encoding", ""):
            body, headers["Content-Encoding"] = file.compressed, "gzip"
        return web.Response(body=body, headers=headers)


async def _given(request: web.BaseRequest) -> dict[str, Any] | None:
    try:
        async with asyncio.timeout(LOGIN_S):
            data = b""
            while len(data) <= LOGIN_BYTES and (more := await request.content.read(LOGIN_BYTES + 1)):
                data += more
        found = read_json(data) if len(data) <= LOGIN_BYTES else None
    except (JsonError, TimeoutError, web.RequestPayloadError, OSError):
        return None  # also where it says how it is packed, and is not; or where the client has gone
    return found if isinstance(found, dict) else None


def _now_s() -> float:
    return asyncio.get_running_loop().time()


def _text(status: int, text: str, **headers: str) -> web.Response:
    return web.Response(status=status, text=f"{text}\n", headers={"Cache-Control": "no-store", **headers})


def _json(content: Mapping[str, Any]) -> web.Response:
    headers = {"Cache-Control": "no-store"}
    return web.Response(text=json_text(content), content_type="application/json", headers=headers)


def _empty(status: int) -> web.Response:
    return web.Response(status=status, headers={"Cache-Control": "no-store"})


def _not_so(allowed: str) -> web.Response:
    return _text(405, f"{allowed} only.", Allow=allowed)
