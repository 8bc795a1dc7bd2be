"""Server of the metrics. A scrape is written in slices, so that a large bench's boards do not wait for it."""

import asyncio
import logging
import re
import socket
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from bridges.metrics.metrics_options import Options
from hil.net.acceptor import abort
from hil.net.endpoint import endpoint, is_loopback
from hil.net.listeners import address_shown, open_listeners
from hil.net.visitors import NO_ROOM, Visit, Visitors
from hil.vocab.desk_protocol import Desk, Source
from hil.vocab.monitoring import Histogram, Metric, Reading, Value
from hil.vocab.verbs import Role, VerbRefused

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


def lines(readings: Iterable[Reading]) -> Iterator[str]:
    """Format each metric's help and type, then its values, as they are asked for."""
    for metric, values in readings:
        yield f"# HELP {metric.name} {_help(metric.about)}\n# TYPE {metric.name} {metric.kind}\n"
        for labels, value in values:
            yield _sample(metric, labels, value)


def _sample(metric: Metric, labels: tuple[str, ...], value: Value) -> str:
    named = [f'{name}="{_escaped(label)}"' for name, label in zip(metric.labels, labels, strict=True)]
    if not isinstance(value, Histogram):
        return f"{metric.name}{_braces(named)} {_number(value)}\n"
    text, below = "", 0
    for bound_s, count in value.buckets:
        below += count
        text += f"{metric.name}_bucket{_bucket(named, _number(bound_s))} {below}\n"
    total = below + value.over
    text += f"{metric.name}_bucket{_bucket(named, '+Inf')} {total}\n"
    own = _braces(named)
    return f"{text}{metric.name}_sum{own} {_number(value.total_s)}\n{metric.name}_count{own} {total}\n"


def _braces(named: list[str]) -> str:
    return "{" + ",".join(named) + "}" if named else ""


def _bucket(named: list[str], bound: str) -> str:
    return _braces([*named, f'le="{bound}"'])


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else repr(float(value))


def _escaped(label: str) -> str:
    return label.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")


def _help(text: str) -> str:
    return text.replace("\\", r"\\").replace("\n", r"\n")


log = logging.getLogger("hil")

SCRAPER = Source("metrics", Role.VIEWER)
SLICE = 50
"""Values between two turns of others: some 0.2 ms; a scrape of 200 devices takes 10."""
CONNECTIONS = 16
REQUEST_S = 10.0
"""Maximum time for a client to ask, or to read its answer; then it is sent away."""
REQUEST_BYTES = 16 * 1024
_AUTHORITY = re.compile(rb"https?://[^/?]*", re.I)
"""Start of a target in absolute form, as proxies get it and each server has to take it (RFC 9112, 3.2.2)."""


def reference() -> str:
    """Part of the reference about what is served; the table of metrics is the daemon's."""
    return (
        "## The metrics bridge\n\n"
        "`GET /metrics` answers all of the above in the text format 0.0.4 of Prometheus, `GET /` says so."
        f" At most {CONNECTIONS} connections at a time, of which silent ones give way; each carries one"
        " request."
    )


class MetricsBridge:
    """Metrics bridge, a ``hil.vocab.bridge_protocol.Bridge``."""

    def __init__(self, options: Options, desk: Desk) -> None:
        self._options = options
        self._desk = desk
        self._visitors: Visitors | None = None
        self._addresses = [options.listen]
        self.scrapes = 0
        self._refused = 0

    async def open(self) -> None:
        if not is_loopback(endpoint(self._options.listen)[0]):
            log.warning(
                "bridges.metrics: insecure: every program that can reach %s can read all metrics",
                self._options.listen,
            )
        listeners = await open_listeners(self._options.listen)
        self._addresses = [address_shown(each) for each in listeners]
        loop = asyncio.get_running_loop()
        self._visitors = Visitors("metrics", CONNECTIONS, loop, self._stay, log.warning, NO_ROOM)
        for listener in listeners:
            self._visitors.listen(listener)

    async def close(self) -> None:
        if self._visitors:
            self._visitors.close()
            await asyncio.gather(*self._visitors.send_away(), return_exceptions=True)

    async def devices_changed(self, names: Collection[str]) -> None:
        """Ignored: each scrape asks which there are."""

    def status(self) -> Mapping[str, Any]:
        inside, turned_away = 0, 0
        if self._visitors:
            inside, turned_away = len(self._visitors.visits), self._visitors.turned_away
        return {
            "root": f"http://{self._addresses[0]}/metrics",
            "listen": list(self._addresses),
            "connect": [],
            "links": inside,
            "commands": self.scrapes,
            "rejected": self._refused + turned_away,
            "dropped": 0,
            "insecure": not is_loopback(endpoint(self._options.listen)[0]),
            "risk": "every program that can reach it can read all metrics",
        }

    async def _stay(self, connection: socket.socket, visit: Visit) -> None:
        try:
            reader, writer = await asyncio.open_connection(sock=connection, limit=REQUEST_BYTES)
        except BaseException:
            connection.close()
            raise
        try:
            async with asyncio.timeout(REQUEST_S):
                request = await reader.readuntil(b"\r\n\r\n")
                visit.is_busy = True
                await self._answer(request, writer)
                writer.close()
                await writer.wait_closed()  # until the client has read it all
        except (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            self._refused += 1  # it left, is too slow, or asks for too much
        finally:
            abort(writer.transport)

    async def _answer(self, request: bytes, writer: asyncio.StreamWriter) -> None:
        method, _, rest = request.partition(b" ")
        path = _AUTHORITY.sub(b"", rest.partition(b" ")[0], count=1).partition(b"?")[0] or b"/"
        status, body = b"200 OK", b""
        if method not in (b"GET", b"HEAD"):
            status, body = b"405 Method Not Allowed", b"GET only\n"
        elif path == b"/metrics":
            try:
                body = await self._scrape()
            except VerbRefused as refusal:
                status, body = b"503 Service Unavailable", f"{refusal.code}: {refusal}\n".encode()
        elif path == b"/":
            body = b"The metrics are at /metrics.\n"
        else:
            status, body = b"404 Not Found", b"The metrics are at /metrics.\n"
        if not status.startswith(b"200"):
            self._refused += 1
        head = f"Content-Type: {CONTENT_TYPE}\r\nContent-Length: {len(body)}\r\nConnection: close\r\n\r\n"
        writer.write(b"HTTP/1.1 " + status + b"\r\n" + head.encode() + (b"" if method == b"HEAD" else body))
        await writer.drain()

    async def _scrape(self) -> bytes:
        self.scrapes += 1
        parts = bytearray()
        for count, text in enumerate(lines(self._desk.ask(SCRAPER, "metrics", "", {})), 1):
            parts += text.encode()
            if count % SLICE == 0:
                await asyncio.sleep(0)
        return bytes(parts)
