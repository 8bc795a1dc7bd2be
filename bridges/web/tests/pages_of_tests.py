"""A door in the tests' own loop, its pages, and a desk that tells what a test wants."""

import asyncio
import base64
import json
import os
import socket
import struct
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from fractions import Fraction
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import aiohttp

from bridges.web.bridge import Options, make
from hil.testing import RecordingDesk
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import AxisField, DeviceInfo, Source, Watch, Watched
from hil.vocab.verbs import table_of

PATIENCE_S = 90.0
PACKED = struct.Struct("<qfid")
FIELDS = (
    AxisField("at_ns", "i64", "ns", "time", 0, False, True),
    AxisField("r", "f32", "deg", "set-point", 8, False, True),
    AxisField("n", "i32", "", "a count", 12, True, True),
    AxisField("x", "f64", "deg", "angle", 16, False, True),
)


class Watching:
    """Watch that a test fills."""

    def __init__(
        self, desk: "PagesDesk", call: Callable[..., object], interval_ns: int | Fraction, points: int
    ) -> None:
        self._desk, self.call, self.interval_ns, self.points = desk, call, interval_ns, points
        self.waiting: list[bytes] = []
        self.lost = 0

    def flush(self) -> None:
        waiting, self.waiting = self.waiting, []
        for packed in [*waiting, *self._desk.endless]:
            self.call(packed)

    def close(self) -> None:
        self._desk.watching = [each for each in self._desk.watching if each[2] is not self]


class PagesDesk(RecordingDesk):
    """Desk with an axis ``m1`` of four fields. ``watching``: kind, target and watch, of those that are open;
    ``endless``: samples that come at each take."""

    def __init__(self, answers: Mapping[str, Any] | None = None) -> None:
        super().__init__(
            {"list": LISTED, "status": {"bench": "check"}, "faults": [], "runs": [], **(answers or {})}
        )
        fields = {field.name: field for field in FIELDS}
        self.devices["m1"] = DeviceInfo("m1", "specimen", False, table_of(()), fields)
        self.watching: list[tuple[Watched, str, Watching]] = []
        self.endless: list[bytes] = []

    def watch(
        self,
        source: Source,
        what: Watched,
        target: str,
        call: Callable[..., object],
        *,
        interval_ns: int | Fraction = 0,
        points: int = 1,
    ) -> Watch:
        watching = Watching(self, call, interval_ns, points)
        self.watching.append((what, target, watching))
        return watching


LISTED: Mapping[str, Any] = {"bench": "check", "devices": [], "taps": [], "nodes": []}


class Page:
    """A page's WebSocket. ``hello``: what it was told first."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self.hello: dict[str, Any] = {}
        self.pushed: list[Any] = []
        """Messages that were no answers and were not taken yet: objects, and bytes."""
        self._last = 0

    async def ask(self, do: str, **given: Any) -> Any:
        """Ask; answers the answer, or the error."""
        self._last += 1
        await self.socket.send_json({"id": self._last, "do": do, **given})
        return await self.answer(self._last)

    async def answer(self, number: int | None) -> Any:
        """Answer of the request with this number."""
        found = await self.until(
            lambda each: isinstance(each, dict) and "id" in each and each["id"] == number
        )
        return found.get("answer", found.get("error"))

    async def until(self, fits: Callable[[Any], bool]) -> Any:
        """First message that fits; those before it stay."""
        async with asyncio.timeout(PATIENCE_S):
            while True:
                for message in self.pushed:
                    if fits(message):
                        self.pushed.remove(message)
                        return message
                self.pushed.append(await self._next())

    async def _next(self) -> Any:
        message = await self.socket.receive()
        if message.type is aiohttp.WSMsgType.TEXT:
            return json.loads(message.data)
        assert message.type is aiohttp.WSMsgType.BINARY, (message, self.socket.close_code)
        return message.data

    async def closed(self) -> int | None:
        """Wait for the end; answers its code."""
        async with asyncio.timeout(PATIENCE_S):
            while not self.socket.closed:
                await self.socket.receive()
        return self.socket.close_code


class Block(NamedTuple):
    watch: int
    lost: int
    rows: list[tuple[float, ...]]


def blocks(data: bytes) -> list[Block]:
    """Blocks of samples in a message."""
    found, at = [], 0
    while at < len(data):
        kind, fields, zero, watch, lost, rows = struct.unpack_from("<BBHIII", data, at)
        assert (kind, zero) == (1, 0)
        at += 16
        size = 8 * (1 + fields)
        found.append(
            Block(
                watch,
                lost,
                [struct.unpack_from(f"<{1 + fields}d", data, at + row * size) for row in range(rows)],
            )
        )
        at += rows * size
    assert at == len(data)
    return found


class Door(NamedTuple):
    """A door that is open, and somebody who asks it."""

    bridge: Bridge
    desk: PagesDesk
    url: str
    session: aiohttp.ClientSession

    @asynccontextmanager
    async def page(self, **options: Any) -> AsyncIterator[Page]:
        async with self.session.ws_connect(
            f"{self.url}ws", protocols=("hil.v1",), max_msg_size=0, **options
        ) as ws:
            page = Page(ws)
            page.hello = (await page.until(lambda each: "hello" in each))["hello"]
            yield page

    async def until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not condition():
                await asyncio.sleep(0.005)


@asynccontextmanager
async def opened(desk: PagesDesk | None = None, **options: Any) -> AsyncIterator[Door]:
    """Open a door at a free port; nothing is checked of certificates."""
    desk = desk or PagesDesk()
    bridge = make(Options.model_validate({"listen": 0, **options}, strict=False), desk)
    await bridge.open()
    try:
        connector = aiohttp.TCPConnector(ssl=False)
        jar = aiohttp.CookieJar(unsafe=True)  # of an address, too
        async with aiohttp.ClientSession(connector=connector, cookie_jar=jar) as session:
            yield Door(bridge, desk, bridge.status()["root"], session)
    finally:
        await bridge.close()


def frame(text: str | bytes, *, opcode: int = 1) -> bytes:
    """WebSocket frame as a browser sends it, masked with zeros."""
    data = text.encode() if isinstance(text, str) else text
    head = bytes([0x80 | opcode])
    if len(data) < 126:
        head += bytes([0x80 | len(data)])
    else:
        head += bytes([0x80 | 127]) + struct.pack(">Q", len(data))
    return head + bytes(4) + data


async def raw_page(url: str) -> socket.socket:
    """Connection whose WebSocket is open, with little room for what comes, and nobody who reads it."""
    loop, parts = asyncio.get_running_loop(), urlsplit(url)
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.setblocking(False)
    assert parts.hostname is not None
    await loop.sock_connect(connection, (parts.hostname, parts.port))
    key = base64.b64encode(os.urandom(16)).decode()
    lines = [
        *("GET /ws HTTP/1.1", f"Host: {parts.netloc}", "Connection: Upgrade", "Upgrade: websocket"),
        *(f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Protocol: hil.v1"),
    ]
    await loop.sock_sendall(connection, "\r\n".join([*lines, "", ""]).encode())
    assert (await loop.sock_recv(connection, 1024)).startswith(b"HTTP/1.1 101 ")
    return connection
