"""One page: its WebSocket, what it asks, what it watches and its terminals."""

import asyncio
import logging
from base64 import b64encode
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass
from inspect import isawaitable
from typing import Any

from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from bridges.web.bench_words import BenchWords, is_offered
from bridges.web.message_rate import MessageRate
from bridges.web.outbox import Outbox
from bridges.web.shared_reading import SharedReading
from bridges.web.web_messages import (
    NAME,
    OBJECT,
    TEXT,
    WHOLE,
    BadMessage,
    PageRequest,
    answer_text,
    read_request,
    read_terminal,
    refusal_text,
    taken,
)
from bridges.web.web_terminals import PageTerminals, SharedPorts
from bridges.web.web_watches import PageWatches
from bridges.web.wire_streams import Records
from hil.vocab.desk_protocol import Desk, Source
from hil.vocab.verbs import VerbRefused

MOST_TASKS = 32
"""Requests of a page that wait for their answers at a time."""
STALLED_S = 10.0
"""Time without reading after which a page loses its socket; it comes back by itself."""

log = logging.getLogger("hil")


@dataclass(frozen=True)
class Surroundings:
    """What all pages share. ``messages_per_s``, ``samples_per_s``: limits of each page."""

    desk: Desk
    words: BenchWords
    shared: Mapping[str, SharedReading]
    records: Records
    ports: SharedPorts
    messages_per_s: float
    samples_per_s: float


class WebClient:
    """Page of a user. ``woken``: called when it may want turns."""

    def __init__(
        self,
        socket: web.WebSocketResponse,
        source: Source,
        around: Surroundings,
        transport: asyncio.Transport,
        woken: Callable[[], None],
    ) -> None:
        self._socket, self._source, self._around, self._desk = socket, source, around, around.desk
        self._transport, self._woken = transport, woken
        self._outbox = Outbox(socket, transport.get_write_buffer_size)
        self.watches = PageWatches(around.desk, source, around.shared, around.records, around.samples_per_s)
        self._terminals = PageTerminals(around.desk, source, around.ports, self._outbox)
        self._rate = MessageRate(around.messages_per_s)
        self._tasks: set[asyncio.Task[None]] = set()
        self._stalled_at_s: float | None = None
        self._is_greeted = False
        self.commands = self.rejected = 0
        self._does: Mapping[str, Callable[[Mapping[str, Any]], Any]] = {
            "ask": self._ask,
            "watch": self.watches.open,
            "unwatch": self.watches.close,
            "open": self._terminals.open,
            "close": self._terminals.close,
            "send": self._send,
            "export": self._export,
        }

    async def stay(self) -> None:
        """Serve the page until it leaves."""
        sending = asyncio.create_task(self._send_all())
        try:
            self._outbox.put(await self._around.words.told("hello", self._source))
            self._is_greeted = True
            async for message in self._socket:
                await self._rate.wait(asyncio.get_running_loop().time())
                await self._outbox.room()
                self._read(message)
        finally:
            self.watches.close_all()
            self._terminals.close_all()
            for task in (sending, *self._tasks):
                task.cancel()
            await asyncio.gather(sending, *self._tasks, return_exceptions=True)

    def turn(self, now_s: float) -> None:
        """Give the page what came since its last turn; a page that does not read gets nothing, and goes."""
        if not self._outbox.is_full:
            self._stalled_at_s = None
            self.watches.take(self._outbox, now_s)
            return
        self.watches.drop()
        if self._stalled_at_s is None:
            self._stalled_at_s = now_s
        elif now_s - self._stalled_at_s > STALLED_S:
            self.abort()

    async def changed(self, names: Collection[str]) -> None:
        """Tell the page that these devices were added, removed or exchanged."""
        self.watches.devices_changed(names, self._outbox)
        if self._is_greeted:
            self._outbox.put(await self._around.words.told("changed", self._source))

    def abort(self) -> None:
        """Hang up."""
        self._transport.abort()

    async def end(self, code: WSCloseCode, why: str) -> None:
        """Close the socket: its page has to go."""
        await self._socket.close(code=code, message=why.encode())

    async def _send_all(self) -> None:
        try:
            await self._outbox.send_all()
        except OSError:
            return  # it has gone

    def _read(self, message: WSMessage) -> None:
        try:
            if message.type is WSMsgType.BINARY:
                self._terminals.typed(*read_terminal(message.data))
            elif message.type is WSMsgType.TEXT:
                self._carry_out(read_request(message.data))
        except BadMessage as error:
            self.rejected += 1
            self._outbox.put(refusal_text(error.id, error))

    def _carry_out(self, asked: PageRequest) -> None:
        try:
            if (do := self._does.get(asked.do)) is None:
                known = ", ".join(self._does)
                raise BadMessage(f"do: there is no {asked.do[:80]!r}; there are {known}", asked.id)
            answer = do(asked.given)
            if isawaitable(answer):
                self._later(asked.id, answer)
            else:
                self._answer(asked.id, answer)
        except BadMessage:
            raise
        except VerbRefused as refusal:
            self._refuse(asked.id, refusal)
        except Exception:  # hil's own error: this request is lost, all else goes on
            self._fault_of_ours(asked.id)

    def _later(self, number: int, doing: Awaitable[Any]) -> None:
        task = asyncio.ensure_future(self._answer_later(number, doing))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _answer_later(self, number: int, doing: Awaitable[Any]) -> None:
        try:
            self._answer(number, await doing)
        except VerbRefused as refusal:
            self._refuse(number, refusal)
        except Exception:  # hil's own error, as in ``_carry_out``
            self._fault_of_ours(number)

    def _answer(self, number: int, answer: Any) -> None:
        self.commands += 1
        self._outbox.put(answer_text(number, answer))
        self._woken()

    def _refuse(self, number: int, refusal: VerbRefused) -> None:
        self.rejected += 1
        self._outbox.put(refusal_text(number, refusal))

    def _fault_of_ours(self, number: int) -> None:
        log.exception("bridges.web: a request could not be carried out")
        self._refuse(number, VerbRefused("failed", "it met a fault of hil's own; the bench's log says more"))

    # ---- what a page can do ----

    def _ask(self, given: Mapping[str, Any]) -> Any:
        forms = {"operation": NAME, "target": NAME, "given": OBJECT}
        values = taken(given, forms, {"target": "", "given": {}})
        operation = values["operation"].replace("-", "_")
        known = self._desk.describe().operations
        if (found := known.get(operation)) and not is_offered(found):
            raise VerbRefused("no_verb", f"{operation} is not asked for here")
        if len(self._tasks) >= MOST_TASKS:
            raise VerbRefused("not_now", f"{MOST_TASKS} requests wait already; wait for an answer")
        return self._desk.ask(self._source, operation, values["target"], values["given"])

    def _send(self, given: Mapping[str, Any]) -> Any:
        values = taken(given, {"segment": NAME, "data_hex": TEXT, "tap": NAME}, {"tap": ""})
        segment, tap = values["segment"], values["tap"]
        if not tap:
            rows = self._desk.ask(self._source, "segments", "", {})
            row = next((each for each in rows if each["segment"] == segment), None)
            if row is None:
                known = ", ".join(each["segment"] for each in rows) or "none"
                raise VerbRefused("no_place", f"there is no segment {segment[:80]!r}; there are {known}")
            if not row["taps"]:
                remedy = f"give it one in the configuration: `{segment}: {{taps: {{web: {{port: pty}}}}}}`"
                raise VerbRefused("no_place", f"{segment} has no tap to send from; {remedy}")
            tap = row["taps"][0]["tap"]
        bursts = {"bursts": [[0, values["data_hex"].replace(" ", "")]]}
        return self._desk.ask(self._source, "play", tap, bursts)

    async def _export(self, given: Mapping[str, Any]) -> dict[str, Any]:
        recorded = self.watches.recorded(taken(given, {"watch": WHOLE}, {})["watch"])
        captured = recorded.capture("hil")
        written = await asyncio.to_thread(captured.pcapng)
        return {"pcapng_base64": b64encode(written).decode(), "events": len(captured)}
