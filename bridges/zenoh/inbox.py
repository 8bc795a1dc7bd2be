"""Inbox for requests from zenoh's threads, which only fill queues; the event loop handles them, the most
urgent first, and readings in a part of its time."""

import asyncio
import json
import logging
import threading
from collections import deque
from collections.abc import Callable, Collection
from contextlib import suppress
from time import thread_time
from typing import Generic, NamedTuple, TypeVar

import zenoh

from bridges.zenoh.gate import ATTACHMENT_BYTES
from bridges.zenoh.keys import COMMAND, JSON_VERSION, KEYS
from bridges.zenoh.publications import encoding
from bridges.zenoh.sender import Sender
from hil.vocab.operation import HALT, Urgency
from hil.wire.json_text import JsonError, read_json

Item = TypeVar("Item")


class SourceLane(Generic[Item]):
    """Queue of ``room`` items, of which each source has at most half."""

    def __init__(self, room: int) -> None:
        self.room = room
        self._waiting: dict[str, deque[Item]] = {}
        """Items by source; the source whose turn is next comes first."""
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def put(self, source: str, item: Item) -> bool:
        """Queue an item. False: there is no room."""
        own = self._waiting.get(source)
        if self._count >= self.room or (own is not None and 2 * len(own) >= self.room):
            return False
        if own is None:
            own = self._waiting[source] = deque()
        own.append(item)
        self._count += 1
        return True

    def take(self) -> Item:
        """Take the next item of the source whose turn it is. Raises StopIteration: there is none."""
        source = next(iter(self._waiting))
        own = self._waiting.pop(source)
        self._count -= 1
        item = own.popleft()
        if own:
            self._waiting[source] = own  # behind the others
        return item

    def clear(self) -> None:
        self._waiting.clear()
        self._count = 0


log = logging.getLogger("hil")

COMMANDS_WAITING, READINGS_WAITING = 10_000, 2_000
"""Maximum numbers of requests that wait. What finds no room is refused; a put is dropped and counted."""
REFUSALS_WAITING = 1_000
"""Number of answers not gone out from which more queries end without one."""
SLICE = 32
"""Number of requests that are handled before others have their turn: some milliseconds."""
READING_SHARE = 0.3
"""Largest part of the loop's time for readings while more of them wait."""
READING_S = 0.002
"""Time of readings in one turn."""
_COMMANDS = {key.pattern for key in KEYS if COMMAND in key.way}
_VERBS, _PARAMETERS = "axis/<device>/cmd/<verb>", "axis/<device>/param/<name>"
_STOP = "/cmd/stop"
_REFUSED = encoding("hil.error.v1")


class Request(NamedTuple):
    """Put, or query that can be answered. ``pattern``: the row of ``KEYS`` under which it came; ``number``:
    counts requests in the order in which they came."""

    key: str
    payload: bytes | None
    attachment: bytes | None
    query: zenoh.Query | None
    pattern: str = ""
    number: int = 0

    @property
    def urgency(self) -> Urgency:
        if self.pattern not in _COMMANDS or (self.pattern == _PARAMETERS and self.query and not self.payload):
            return Urgency.READING
        is_stop = self.pattern == HALT or (self.pattern == _VERBS and self.key.endswith(_STOP))
        return Urgency.STOP if is_stop else Urgency.COMMAND


class Inbox:
    """Hands requests to ``handle`` in the loop, those of one urgency and one asker in the order in which they
    came. ``acks``, ``answers``: senders for commands and for readings; ``names``: known users, who take turns
    with each other and with all who do not sign; ``cpu_s``: time that readings have taken."""

    def __init__(
        self,
        acks: Sender,
        answers: Sender,
        handle: Callable[[Request], None],
        names: Collection[str],
        cpu_s: Callable[[], float] = thread_time,
    ) -> None:
        self._cpu_s = cpu_s
        self._loop = asyncio.get_running_loop()
        self._senders = {Urgency.STOP: acks, Urgency.COMMAND: acks, Urgency.READING: answers}
        self._handle = handle
        self._names = names
        rooms = {Urgency.STOP: COMMANDS_WAITING, Urgency.COMMAND: COMMANDS_WAITING}
        self._lanes = {u: SourceLane[Request](rooms.get(u, READINGS_WAITING)) for u in Urgency}
        self._lock = threading.Lock()
        self._is_awake = False
        """True while ``_drain`` is scheduled for the loop's next pass."""
        self._timer: asyncio.TimerHandle | None = None
        """Set while readings wait until others have had their part of the time."""
        self._is_closed = False
        self._count = 0
        self.dropped = 0
        self.refused = 0
        """Number of queries that found no room."""

    # ---- in zenoh's threads ----

    def on_put(self, pattern: str, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            attachment = sample.attachment.to_bytes() if sample.attachment else None
            self._enqueue(Request(str(sample.key_expr), sample.payload.to_bytes(), attachment, None, pattern))

    def on_query(self, pattern: str, query: zenoh.Query) -> None:
        given = query.payload
        if self._is_flooded and (pattern not in _COMMANDS or (pattern == _PARAMETERS and given is None)):
            self._end(Urgency.READING, query)  # to refuse each in words would take all the time there is
            return
        payload = given.to_bytes() if given is not None else None
        attachment = query.attachment.to_bytes() if query.attachment else None
        self._enqueue(Request(str(query.key_expr), payload, attachment, query, pattern))

    @property
    def _is_flooded(self) -> bool:
        """True if readings come faster than they can be refused."""
        return self._senders[Urgency.READING].waiting > REFUSALS_WAITING and self._is_full(Urgency.READING)

    def _is_full(self, urgency: Urgency) -> bool:
        return 2 * len(self._lanes[urgency]) >= self._lanes[urgency].room

    def _enqueue(self, request: Request) -> None:
        urgency, source = request.urgency, self._source(request.attachment)
        with self._lock:
            self._count += 1
            is_in = not self._is_closed and self._lanes[urgency].put(
                source, request._replace(number=self._count)
            )
            wakes = is_in and not self._is_awake and (urgency < Urgency.READING or self._timer is None)
            self._is_awake |= wakes
        if not is_in:
            self._turn_away(request, urgency)
        if wakes:
            with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
                self._loop.call_soon_threadsafe(self._drain)

    def _source(self, attachment: bytes | None) -> str:
        """Name of the user who says that he has signed; empty for all others. It is checked later."""
        if attachment and self._names and len(attachment) <= ATTACHMENT_BYTES:
            with suppress(JsonError):
                said = read_json(attachment)
                if isinstance(said, dict) and said.get("user") in self._names:
                    return str(said["user"])
        return ""

    def _turn_away(self, request: Request, urgency: Urgency) -> None:
        if request.query is None:
            self.dropped += 1
            return
        sender = self._senders[urgency]
        if sender.waiting > REFUSALS_WAITING:
            self._end(urgency, request.query)
            return
        self.refused += 1
        content = {"v": JSON_VERSION, "key": request.key, "code": "busy"}
        text = json.dumps(content | {"error": "too many requests wait here already; ask again later"})
        sender.reply(request.query, None, text.encode(), _REFUSED)
        sender.end(request.query)

    def _end(self, urgency: Urgency, query: zenoh.Query) -> None:
        """End a query without an answer. Not here: that can wait for a client that does not read, and would
        hold up the connection with all that comes."""
        self.refused += 1
        self._senders[urgency].end(query)

    # ---- in the loop ----

    def _drain(self) -> None:
        """Handle a few requests; the ports have their turn in between."""
        for urgency in (Urgency.STOP, Urgency.COMMAND):
            for _ in range(SLICE):
                if not self._handle_one(urgency):
                    break
        if self._timer is None:
            self._read_some()
        with self._lock:
            commands = self._lanes[Urgency.STOP] or self._lanes[Urgency.COMMAND]
            self._is_awake = bool(commands or (self._lanes[Urgency.READING] and self._timer is None))
        if self._is_awake:
            self._loop.call_soon(self._drain)

    def _read_some(self) -> None:
        """Answer readings for a while; if more wait, others have the loop for the rest of the time."""
        began_s = self._cpu_s()
        took_s = 0.0
        while took_s < READING_S and self._handle_one(Urgency.READING):
            took_s = self._cpu_s() - began_s
        with self._lock:
            if self._lanes[Urgency.READING]:
                self._timer = self._loop.call_later(took_s / READING_SHARE - took_s, self._read_on)

    def _read_on(self) -> None:
        with self._lock:
            self._timer = None
            wakes, self._is_awake = not self._is_awake, True
        if wakes:
            self._drain()

    def _handle_one(self, urgency: Urgency) -> bool:
        """Handle a request. False: there is none."""
        with self._lock:
            if not self._lanes[urgency] or self._is_closed:  # the part that would answer is closing
                return False
            request = self._lanes[urgency].take()
        try:
            self._handle(request)
        except Exception:  # hil's own error: that request is lost, all else goes on
            log.exception("zenoh: %s could not be handled", request.key)
            if request.query is not None:
                self._senders[urgency].end(request.query)
        return True

    def close(self) -> None:
        """Handle nothing any more."""
        with self._lock:
            self._is_closed = True
            for lane in self._lanes.values():
                lane.clear()
        if self._timer:
            self._timer.cancel()
