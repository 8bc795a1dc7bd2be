"""Inbox for requests from zenoh's threads, which only fill a queue; the event loop handles them."""

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import zenoh

from bridges.zenoh.sender import Sender

log = logging.getLogger("hil")

WAITING = 10_000
"""Maximum number of requests in the queue; later puts are dropped and counted, queries from twice as many."""
SLICE = 32
"""Number of requests that are handled before others have their turn: some milliseconds."""


class Request(NamedTuple):
    """Put, or query that can be answered."""

    key: str
    payload: bytes | None
    attachment: bytes | None
    query: zenoh.Query | None


class Inbox:
    """Hands requests to ``handle`` in the loop, in the order in which they came."""

    def __init__(self, sender: Sender, handle: Callable[[Request], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._sender = sender
        self._handle = handle
        self._queue: deque[Request] = deque()
        self._lock = threading.Lock()
        self._is_awake = False
        """True while ``_drain`` is scheduled."""
        self._is_closed = False
        self.dropped = 0

    # ---- in zenoh's threads ----

    def on_put(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            attachment = sample.attachment.to_bytes() if sample.attachment else None
            self._enqueue(Request(str(sample.key_expr), sample.payload.to_bytes(), attachment, None))

    def on_query(self, query: zenoh.Query) -> None:
        payload = query.payload.to_bytes() if query.payload is not None else None
        attachment = query.attachment.to_bytes() if query.attachment else None
        self._enqueue(Request(str(query.key_expr), payload, attachment, query))

    def _enqueue(self, request: Request) -> None:
        with self._lock:
            is_full = len(self._queue) >= (WAITING if request.query is None else 2 * WAITING)
            if is_full:
                self.dropped += 1
            else:
                self._queue.append(request)
            wakes = not self._is_awake
            self._is_awake = True
        if is_full and request.query is not None:
            self._sender.end(request.query)
        if wakes:
            with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
                self._loop.call_soon_threadsafe(self._drain)

    # ---- in the loop ----

    def _drain(self) -> None:
        """Handle a few requests; the ports have their turn in between."""
        for _ in range(SLICE):
            with self._lock:
                if not self._queue or self._is_closed:  # the part that would answer is closing
                    self._is_awake = False
                    return
                request = self._queue.popleft()
            try:
                self._handle(request)
            except Exception:  # hil's own error: that request is lost, all else goes on
                log.exception("zenoh: %s could not be handled", request.key)
                if request.query is not None:
                    self._sender.end(request.query)
        self._loop.call_soon(self._drain)

    def close(self) -> None:
        """Handle nothing any more."""
        self._is_closed = True
        self._queue.clear()
