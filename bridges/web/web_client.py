"""One page: its WebSocket, what it asks, what it watches and its terminals."""

import asyncio
import logging
from base64 import b64encode
from collections.abc import Awaitable, Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from inspect import isawaitable
from time import thread_time
from typing import Any

from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from bridges.web.bench_words import BenchWords, is_offered
from bridges.web.outbox import LongText, Outbox
from bridges.web.read_ahead import Ahead, ReadAhead
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
from bridges.web.wire_fields import wire_fields
from bridges.web.wire_streams import Captured, Records
from hil.net.acceptor import abort
from hil.net.fair_share import FairShare
from hil.vocab.desk_protocol import Desk, Encoded, Source
from hil.vocab.operation import Operation, Urgency, moved_by, urgency_of
from hil.vocab.verbs import VerbRefused

MOST_EXPORTS = 8
"""Maximum number of captures of all pages that have not gone out: each may hold some megabytes."""
_TRIPLET = 3


class Exports:
    """Captures under way, of all pages."""

    def __init__(self) -> None:
        self._under_way: set[object] = set()

    def begin(self, page: object, number: int, captured: Captured) -> LongText:
        """Message with a capture. Raises VerbRefused: the page has one under way, or too many have."""
        if page in self._under_way:
            raise VerbRefused("not_now", "a capture is under way to this page; wait for it")
        if len(self._under_way) >= MOST_EXPORTS:
            raise VerbRefused("not_now", f"{MOST_EXPORTS} captures are under way to pages; try again")
        self._under_way.add(page)
        return LongText(_message(number, captured), 0, lambda: self._under_way.discard(page))


def _message(number: int, captured: Captured) -> Iterator[bytes]:
    """Answer in parts, each of some records."""
    yield f'{{"id":{number},"answer":{{"pcapng_base64":"'.encode()
    rest = b""
    for data in captured.pcapng():
        data = rest + data
        whole = len(data) - len(data) % _TRIPLET
        rest = data[whole:]
        yield b64encode(data[:whole])
    yield b64encode(rest)
    yield f'","events":{len(captured)}}}}}'.encode()


MOST_TASKS = 32
"""Requests of a page that wait for their answers at a time."""
EXPORT = "export"
STOPS_PER_S = 20.0
"""Stops of a page in a second, at the most: they are carried out at once."""
SHORT_CHARACTERS = 1024
"""Length of a message that is read before its turn: a stop must not wait for one."""
STALLED_S = 10.0
"""Time without reading after which a page loses its socket; it comes back by itself."""

log = logging.getLogger("hil")


@dataclass(frozen=True)
class Surroundings:
    """Surroundings that all pages share. ``messages_per_s``, ``samples_per_s``: limits of each page."""

    desk: Desk
    words: BenchWords
    shared: Mapping[str, SharedReading]
    records: Records
    ports: SharedPorts
    turns: FairShare
    exports: Exports
    messages_per_s: float
    samples_per_s: float


class MessageRate:
    """Messages of a second at once, then ``messages_per_s``. Time is given by the caller."""

    def __init__(self, messages_per_s: float) -> None:
        self._interval_s = 1 / messages_per_s
        self._free_at_s = 0.0
        """Time at which all messages of a second are free again."""

    def delay_s(self, now_s: float) -> float:
        """Count a message; answers how long it has to wait."""
        self._free_at_s = max(self._free_at_s, now_s) + self._interval_s
        return max(self._free_at_s - now_s - 1.0, 0.0)

    async def wait(self, now_s: float) -> None:
        """Count a message, and wait as long as it has to."""
        if delay_s := self.delay_s(now_s):
            await asyncio.sleep(delay_s)


class WebClient:
    """Page of a user. ``can_write``: set while its transport has room; ``woken``: called when it may want
    turns.

    Long because what a page asks, watches and has open begins and ends with its socket.
    """

    def __init__(
        self,
        socket: web.WebSocketResponse,
        source: Source,
        around: Surroundings,
        transport: asyncio.Transport,
        can_write: asyncio.Event,
        woken: Callable[[], None],
    ) -> None:
        self._socket, self._source, self._around, self._desk = socket, source, around, around.desk
        self._transport, self._woken = transport, woken
        self._outbox = Outbox(socket, transport, can_write)
        self.watches = PageWatches(around.desk, source, around.shared, around.records, around.samples_per_s)
        self._terminals = PageTerminals(around.desk, source, around.ports, self._outbox)
        self._rate, self._stop_rate = MessageRate(around.messages_per_s), MessageRate(STOPS_PER_S)
        self._ahead = ReadAhead()
        self._tasks: set[asyncio.Future[Any]] = set()
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
            "fields": partial(wire_fields, self._desk),
        }

    async def stay(self) -> None:
        """Serve the page until it leaves."""
        sending, working = asyncio.create_task(self._send_all()), asyncio.create_task(self._work())
        working.add_done_callback(self._worked)
        try:
            self._outbox.put(await self._around.words.told("hello", self._source))
            self._is_greeted = True
            async for message in self._socket:
                await self._come(message)
            await self._ahead.emptied(sending, working)
        finally:
            self.watches.close_all()
            self._terminals.close_all()
            for task in (sending, working, *self._tasks):
                task.cancel()
            await asyncio.gather(sending, working, *self._tasks, return_exceptions=True)
            self._outbox.drop()

    async def _come(self, message: WSMessage) -> None:
        """Let a message wait behind those before it. A stop passes them."""
        number, urgency, moves = _wanted(message, self._desk)
        if urgency is Urgency.STOP:
            await self._stop_rate.wait(asyncio.get_running_loop().time())
            self._read(message, self._ahead.stop(moves))
        else:
            is_long = message.type is WSMsgType.TEXT and len(message.data) > SHORT_CHARACTERS
            await self._ahead.put(message, number, urgency, moves, is_long=is_long)

    async def _work(self) -> None:
        """Carry out messages, each when its turn has come."""
        while True:
            ahead: Ahead[WSMessage] = await self._ahead.next()
            await self._rate.wait(asyncio.get_running_loop().time())
            await self._outbox.room()
            await self._have_turn(ahead)
            self._ahead.done()

    def _worked(self, working: "asyncio.Task[None]") -> None:
        if not working.cancelled() and (error := working.exception()):
            log.error("bridges.web: a page is sent away", exc_info=error)  # hil's own error
            self.abort()

    async def _have_turn(self, ahead: Ahead[WSMessage]) -> None:
        """Carry out a message when its turn has come."""
        turns = self._around.turns
        try:
            await turns.wait(ahead.urgency, ahead.moves)
        except VerbRefused as refusal:
            self._refuse(ahead.number, refusal)
            return
        began_s = thread_time()
        self._read(ahead.message, ahead.place)
        turns.note(None, thread_time() - began_s)

    def turn(self, now_s: float) -> None:
        """Give the page what came since its last turn; a page that does not read gets nothing, and goes."""
        if not self._outbox.is_full:
            self._stalled_at_s = None
            self.watches.fill(self._outbox, now_s)
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
        abort(self._transport)

    async def end(self, code: WSCloseCode, why: str) -> None:
        """Close the socket: its page has to go."""
        await self._socket.close(code=code, message=why.encode())

    async def _send_all(self) -> None:
        try:
            await self._outbox.send_all()
        except OSError:
            return  # it has gone

    def _read(self, message: WSMessage, place: int) -> None:
        try:
            if message.type is WSMsgType.BINARY:
                self._terminals.typed(*read_terminal(message.data))
            elif message.type is WSMsgType.TEXT:
                self._carry_out(read_request(message.data), place)
        except BadMessage as error:
            self.rejected += 1
            self._outbox.put(refusal_text(error.id, error))

    def _carry_out(self, asked: PageRequest, place: int) -> None:
        try:
            self._check_deadline(asked)
            self._ahead.check(place, _moves(asked, self._desk))
            if asked.do == EXPORT:
                answer: Any = self._export(asked.id, asked.given)
            elif do := self._does.get(asked.do):
                answer = do(asked.given)
            else:
                known = ", ".join((*self._does, EXPORT))
                raise BadMessage(f"do: there is no {asked.do[:80]!r}; there are {known}", asked.id)
            if isawaitable(answer):
                self._later(asked.id, answer)
            else:
                self._answer(asked.id, answer)
        except BadMessage:
            raise
        except VerbRefused as refusal:
            self._refuse(asked.id, refusal)
        except Exception as error:  # hil's own error: this request is lost, all else goes on
            self._fault_of_ours(asked.id, error)

    def _check_deadline(self, asked: PageRequest) -> None:
        """Refuse what would begin too late: nobody expects it any more. Raises VerbRefused."""
        until_ms = asked.until_ms
        late_ms = 0.0 if until_ms is None else asyncio.get_running_loop().time() * 1000 - until_ms
        if late_ms <= 0:
            return
        why = f"its turn came {late_ms / 1000:.1f} s after its deadline, so it was not carried out"
        refusal = VerbRefused("not_now", f"{why}; ask for it again")
        match asked.given:
            case {"operation": str(name), "given": dict(given)} if asked.do == "ask":
                target = str(asked.given.get("target", ""))
                self._desk.note_refusal(self._source, name, target, given, refusal)
        raise refusal

    def _later(self, number: int, doing: Awaitable[Any]) -> None:
        task = asyncio.ensure_future(doing)
        self._tasks.add(task)
        task.add_done_callback(partial(self._done, number))

    def _done(self, number: int, task: "asyncio.Future[Any]") -> None:
        self._tasks.discard(task)
        if task.cancelled():
            return
        match task.exception():
            case None:
                self._answer(number, task.result())
            case VerbRefused() as refusal:
                self._refuse(number, refusal)
            case error:  # hil's own error, as in ``_carry_out``
                self._fault_of_ours(number, error)

    def _answer(self, number: int, answer: Any) -> None:
        self.commands += 1
        if isinstance(answer, Encoded):
            head = f'{{"id":{number},"answer":'.encode()
            answer = LongText((head, *answer.parts, b"}"), len(answer))
        self._outbox.put(answer if isinstance(answer, LongText) else answer_text(number, answer))
        self._woken()

    def _refuse(self, number: int, refusal: VerbRefused) -> None:
        self.rejected += 1
        self._outbox.put(refusal_text(number, refusal))

    def _fault_of_ours(self, number: int, error: BaseException) -> None:
        log.error("bridges.web: a request could not be carried out", exc_info=error)
        self._refuse(number, VerbRefused("failed", "it met a fault of hil's own; the bench's log says more"))

    # ---- what a page can do ----

    def _ask(self, given: Mapping[str, Any]) -> Any:
        forms = {"operation": NAME, "target": NAME, "given": OBJECT}
        values = taken(given, forms, {"target": "", "given": {}})
        operation = values["operation"].replace("-", "_")
        known = self._desk.describe().operations
        if (found := known.get(operation)) and not is_offered(found):
            raise VerbRefused("no_verb", f"{operation} is not asked for here")
        is_stop = found and urgency_of(found, values["given"]) is Urgency.STOP
        if len(self._tasks) >= MOST_TASKS and not is_stop:
            raise VerbRefused("busy", f"{MOST_TASKS} requests wait already; wait for an answer")
        answer = self._desk.ask(self._source, operation, values["target"], values["given"])
        if is_stop:
            self._around.turns.stopped(values["target"])
        return answer

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
                remedy = f"give it one in the configuration: `{segment}: {{taps: {{web: {{listen: pty}}}}}}`"
                raise VerbRefused("no_place", f"{segment} has no tap to send from; {remedy}")
            tap = row["taps"][0]["tap"]
        bursts = {"bursts": [[0, values["data_hex"].replace(" ", "")]]}
        return self._desk.ask(self._source, "play", tap, bursts)

    def _export(self, number: int, given: Mapping[str, Any]) -> LongText:
        recorded = self.watches.recorded(taken(given, {"watch": WHOLE}, {})["watch"])
        return self._around.exports.begin(self, number, recorded.capture("hil"))


def _wanted(message: WSMessage, desk: Desk) -> tuple[int, Urgency, str]:
    """Number of a message, its class, and the device that it tells a verb. A long one, which takes time to
    read, is a reading."""
    if message.type is WSMsgType.TEXT and len(message.data) <= SHORT_CHARACTERS:
        with suppress(BadMessage):
            asked = read_request(message.data)
            if known := _asked_for(asked, desk):
                given = asked.given.get("given", {})
                given = given if isinstance(given, dict) else {}
                return asked.id, urgency_of(known, given), _moves(asked, desk)
    return 0, Urgency.READING, ""


def _moves(asked: PageRequest, desk: Desk) -> str:
    known = _asked_for(asked, desk)
    return moved_by(known, str(asked.given.get("target", ""))) if known else ""


def _asked_for(asked: PageRequest, desk: Desk) -> Operation | None:
    """Operation that a request asks for; None: there is no such, or it asks for something else."""
    name = asked.given.get("operation")
    return desk.describe().operations.get(name) if asked.do == "ask" and isinstance(name, str) else None
