"""Pages that are open: they come in, have their turns, and go."""

import asyncio
import logging
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import Any

from aiohttp import WSCloseCode, web

from bridges.web.http_door import SECURITY, SUBPROTOCOL
from bridges.web.web_client import Surroundings, WebClient
from bridges.web.websocket_frames import FrameCheck
from hil.vocab.desk_protocol import Source


class _CheckedReader:
    """Reader of frames that have passed the check."""

    def __init__(self, reader: Any) -> None:
        self._reader, self._check = reader, FrameCheck()

    def feed_data(self, data: bytes) -> tuple[bool, bytes]:
        result: tuple[bool, bytes] = self._reader.feed_data(self._check.passed(data))
        return result

    def feed_eof(self) -> None:
        self._reader.feed_eof()


class PageConnection(web.RequestHandler):
    """Connection. ``ended``: set when it has; ``can_write``: set while its transport has room."""

    __slots__ = ("can_write", "ended")

    def __init__(self, *given: object, **options: object) -> None:
        super().__init__(*given, **options)  # type: ignore[arg-type]
        self.ended, self.can_write = asyncio.Event(), asyncio.Event()
        self.can_write.set()

    def set_parser(self, parser: Any, data_received_cb: Callable[[], None] | None = None) -> None:
        checked: Any = _CheckedReader(parser)
        super().set_parser(checked, data_received_cb)

    def pause_writing(self) -> None:
        super().pause_writing()
        self.can_write.clear()

    def resume_writing(self) -> None:
        super().resume_writing()
        self.can_write.set()

    def connection_lost(self, exc: BaseException | None) -> None:
        super().connection_lost(exc)
        self.ended.set()
        self.can_write.set()


HEARTBEAT_S = 6.0
"""Time after which a page that says nothing is asked whether it is there. It has half as long to answer: a
stopped tab does not, while its computer still takes some megabytes for it."""
WRITER_BYTES = 1 << 16
CLOSE_S = 2.0

log = logging.getLogger("hil")


class OpenPages:
    """Pages that are open, at most so many. ``message_bytes``: limit of their messages."""

    def __init__(self, around: Surroundings, most: int, message_bytes: int) -> None:
        self._around, self._most, self._message_bytes = around, most, message_bytes
        self._clients: dict[WebClient, str] = {}
        """Pages with their sessions."""
        self._wake = asyncio.Event()
        self._gone = {"commands": 0, "rejected": 0, "dropped": 0}
        """Counters of pages that have gone."""
        self._turns = asyncio.get_running_loop().create_task(self._give_turns())

    def __len__(self) -> int:
        return len(self._clients)

    def counters(self) -> Mapping[str, int]:
        """Commands, rejected requests, and what was dropped, so far."""
        return {
            name: count + sum(_counters(each)[name] for each in self._clients)
            for name, count in self._gone.items()
        }

    async def enter(self, request: web.BaseRequest, source: Source, session: str) -> web.StreamResponse:
        """Take a page in until it leaves."""
        if len(self._clients) >= self._most:
            return web.Response(status=503, text=f"{self._most} pages are open already.\n")
        page = web.WebSocketResponse(
            protocols=(SUBPROTOCOL,),
            heartbeat=HEARTBEAT_S,
            max_msg_size=self._message_bytes + 1,  # of so many bytes it takes none
            compress=False,
            writer_limit=WRITER_BYTES,
        )
        page.headers.update(SECURITY)
        await page.prepare(request)
        transport, connection = request.transport, request.protocol
        if not isinstance(transport, asyncio.Transport) or not isinstance(connection, PageConnection):
            return page  # it has gone meanwhile
        client = WebClient(page, source, self._around, transport, connection.can_write, self._wake.set)
        self._clients[client] = session
        try:
            await client.stay()
        finally:
            del self._clients[client]
            for name, count in _counters(client).items():
                self._gone[name] += count
        return page

    def leave(self, session: str) -> None:
        """Hang up on the pages of a session."""
        for client, own in list(self._clients.items()):
            if own == session:
                client.abort()

    async def changed(self, names: Collection[str]) -> None:
        """Tell all pages that these devices were added, removed or exchanged: they get the whole again."""
        self._around.words.changed()
        for client in list(self._clients):
            await client.changed(names)

    async def close(self) -> None:
        """Send all pages away."""
        going = [client.end(WSCloseCode.GOING_AWAY, "the bench has ended") for client in list(self._clients)]
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_S):
                await asyncio.gather(*going, return_exceptions=True)
        self._turns.cancel()
        with suppress(asyncio.CancelledError):
            await self._turns
        self._around.ports.close()
        self._around.turns.close()
        for reading in self._around.shared.values():
            reading.close()

    async def _give_turns(self) -> None:
        """Give each page its turn, all of them at the rate that the fastest one wants, in at most half of the
        time."""
        loop = asyncio.get_running_loop()
        while True:
            watching = [client for client in self._clients if len(client.watches)]
            if not watching:
                self._wake.clear()
                await self._wake.wait()
                continue
            started_s = loop.time()
            for client in watching:
                try:
                    client.turn(started_s)
                except Exception:  # hil's own error: this page is lost, all else goes on
                    log.exception("bridges.web: a page is sent away")
                    client.abort()
                await asyncio.sleep(0)
            interval_s = min(client.watches.turn_s for client in watching)
            took_s = loop.time() - started_s
            await asyncio.sleep(max(interval_s - took_s, took_s, interval_s / 4))


def _counters(client: WebClient) -> dict[str, int]:
    return {"commands": client.commands, "rejected": client.rejected, "dropped": client.watches.lost}
