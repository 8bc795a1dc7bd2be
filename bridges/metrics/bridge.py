"""Serves the metrics. A scrape is written in slices, so that a large bench's boards do not wait for it."""

import asyncio
import ipaddress
import logging
import os
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from bridges.metrics.exposition import CONTENT_TYPE, lines
from hil.vocab.bridges import BridgeError, BridgeHost

__all__ = ["Options", "make", "reference"]

log = logging.getLogger("hil")

SLICE = 50
"""Values between two turns of the others: some 0.2 ms; a scrape of 200 devices takes 10."""
CONNECTIONS = 16
REQUEST_S = 10.0
"""A client that has not asked by then, or has not read its answer, is sent away."""
REQUEST_BYTES = 16 * 1024


class Options(BaseModel):
    """``bridges.metrics``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    listen: str = Field(
        default="127.0.0.1:9464",
        description=(
            "Address and port, as in `[::1]:9464`; port 0 takes a free one. Beyond this computer it needs"
            " `insecure: true`."
        ),
    )
    insecure: bool = Field(
        default=False, description="Let other computers read the metrics; log and status say so again."
    )


def make(options: Options, host: BridgeHost) -> "MetricsBridge":
    """The bridge, not yet open."""
    return MetricsBridge(options, host)


def reference() -> str:
    """The table of metrics is the daemon's; what is served is said here."""
    return "\n".join(
        [
            "## The metrics bridge\n",
            "`GET /metrics` answers all of the above in the text format 0.0.4 of Prometheus, `GET /` says so."
            f" At most {CONNECTIONS} connections at a time; each carries one request.",
        ]
    )


class MetricsBridge:
    """``hil.vocab.bridges.Bridge``."""

    def __init__(self, options: Options, host: BridgeHost) -> None:
        self._options = options
        self._host = host
        self._server: asyncio.Server | None = None
        self._clients: dict[asyncio.Task[Any], asyncio.StreamWriter] = {}
        self._address = options.listen
        self.scrapes = 0
        self.rejected = 0

    async def open(self) -> None:
        host, port = _endpoint(self._options)
        if not _is_loopback(host):
            log.warning(
                "bridges.metrics: insecure: whoever reaches %s may read all metrics", self._options.listen
            )
        try:
            self._server = await asyncio.start_server(self._client, host, port, limit=REQUEST_BYTES)
        except OSError as error:
            why = os.strerror(error.errno or 0)
            raise BridgeError(f"listen: {self._options.listen}: {why}; choose another") from None
        bound = self._server.sockets[0].getsockname()
        self._address = f"[{bound[0]}]:{bound[1]}" if ":" in bound[0] else f"{bound[0]}:{bound[1]}"

    async def close(self) -> None:
        if self._server:
            self._server.close()
        for task, writer in list(self._clients.items()):
            writer.transport.abort()
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    async def devices_changed(self, names: Collection[str]) -> None:
        """Each scrape asks which there are."""

    def status(self) -> Mapping[str, Any]:
        return {
            "root": f"http://{self._address}/metrics",
            "listen": [self._address],
            "connect": [],
            "links": len(self._clients),
            "commands": self.scrapes,
            "rejected": self.rejected,
            "dropped": 0,
            "insecure": not _is_loopback(_endpoint(self._options)[0]),
            "risk": "whoever reaches it reads all metrics",
        }

    async def _client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        if len(self._clients) >= CONNECTIONS:
            self.rejected += 1
            writer.transport.abort()
            return
        self._clients[task] = writer
        try:
            async with asyncio.timeout(REQUEST_S):
                await self._answer(await reader.readuntil(b"\r\n\r\n"), writer)
        except (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            self.rejected += 1  # it left, is too slow, or asks for too much
            writer.transport.abort()
        finally:
            writer.close()
            del self._clients[task]

    async def _answer(self, request: bytes, writer: asyncio.StreamWriter) -> None:
        method, _, rest = request.partition(b" ")
        path = rest.partition(b" ")[0].partition(b"?")[0]
        status, body = b"200 OK", b""
        if method not in (b"GET", b"HEAD"):
            status, body = b"405 Method Not Allowed", b"GET only\n"
        elif path == b"/metrics":
            body = await self._scrape()
        elif path == b"/":
            body = b"The metrics are at /metrics.\n"
        else:
            status, body = b"404 Not Found", b"The metrics are at /metrics.\n"
        if not status.startswith(b"200"):
            self.rejected += 1
        head = f"Content-Type: {CONTENT_TYPE}\r\nContent-Length: {len(body)}\r\nConnection: close\r\n\r\n"
        writer.write(b"HTTP/1.1 " + status + b"\r\n" + head.encode() + (b"" if method == b"HEAD" else body))
        await writer.drain()

    async def _scrape(self) -> bytes:
        self.scrapes += 1
        parts = bytearray()
        for count, text in enumerate(lines(self._host.metrics()), 1):
            parts += text.encode()
            if count % SLICE == 0:
                await asyncio.sleep(0)
        return bytes(parts)


def _endpoint(options: Options) -> tuple[str, int]:
    """Address and port. Raises BridgeError."""
    host, _, port = options.listen.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not host or not port.isdigit() or int(port) > 65535:
        raise BridgeError(f"listen: {options.listen!r}: write an address and a port, as in 127.0.0.1:9464")
    if not options.insecure and not _is_loopback(host):
        raise BridgeError(
            f"listen: {options.listen} is reached from other computers, and metrics have no users; listen on"
            " 127.0.0.1 and let a proxy ask who it is, or write `insecure: true`"
        )
    return host, int(port)


def _is_loopback(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
