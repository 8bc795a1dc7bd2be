"""Connection of a browser: HTTP until a page's WebSocket begins, then its frames, which are checked."""

import asyncio
from collections.abc import Callable
from typing import Any

from aiohttp import web

from bridges.web.websocket_frames import FrameCheck


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
