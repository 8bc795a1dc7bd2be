"""Commands: requests to the desk by key and payload, and the replies."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from contextlib import suppress
from dataclasses import replace
from inspect import isawaitable
from typing import Any, NamedTuple

import zenoh

from bridges.zenoh.documents import OURS, RUN_BYTES, STRANGER, dumped, read_payload, read_text
from bridges.zenoh.gate import Gate
from bridges.zenoh.inbox import Request
from bridges.zenoh.keys import prefix
from bridges.zenoh.publications import Publications, encoding, short_state
from bridges.zenoh.readings import Readings
from bridges.zenoh.sender import Sender
from hil.net.site_stop import STOP_ALL
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import BenchProblem
from hil.vocab.desk_protocol import Desk, Done, Proof, Source
from hil.vocab.operation import HALT, STOP_VERB
from hil.vocab.verbs import VerbRefused

log = logging.getLogger("hil")

LATER = 1_000
"""Maximum number of queries that wait for a motion's end."""


class Work:
    """Tasks in the loop, until ``close``."""

    def __init__(self) -> None:
        self._working: set[asyncio.Task[None]] = set()
        self._waiting: dict[asyncio.Task[None], None] = {}
        """Tasks that wait for a motion's end, the oldest first."""

    @property
    def waiting(self) -> int:
        """Number of tasks that wait for a motion's end."""
        return len(self._waiting)

    def begin(self, working: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(working)
        self._working.add(task)
        task.add_done_callback(self._worked)
        return task

    def _worked(self, task: asyncio.Task[None]) -> None:
        self._working.discard(task)
        self._waiting.pop(task, None)
        if not task.cancelled() and (error := task.exception()):
            log.error("zenoh: an answer could not be made", exc_info=error)

    def await_end(self, waiting: Coroutine[Any, Any, None]) -> None:
        """Await a motion's end. Of too many the longest waiting gives way: its asker may be gone."""
        if len(self._waiting) >= LATER:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            self._working.add(oldest)
            oldest.cancel()
        task = asyncio.get_running_loop().create_task(waiting)
        self._waiting[task] = None
        task.add_done_callback(self._worked)

    async def close(self) -> None:
        under_way = [*self._waiting, *self._working]
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)


ACKNOWLEDGED, REFUSED = encoding("hil.ack.v1"), encoding("hil.error.v1")


class Command(NamedTuple):
    """Request to the desk, as a key and a payload give it."""

    operation: str
    target: str
    given: Mapping[str, object]

    @property
    def is_stop(self) -> bool:
        """True if it stops an axis, or all."""
        return self.operation == HALT or (self.operation == "do" and self.given.get("name") == STOP_VERB)


Reader = Callable[[bytes | None], Command]
"""Reader of a payload. Raises VerbRefused."""


class CommandHandler:
    """Commands to one bench. ``gate``: knows its users, where it has some."""

    def __init__(
        self,
        desk: Desk,
        gate: Gate | None,
        publications: Publications,
        readings: Readings,
        sender: Sender,
        work: Work,
        clash: Callable[[], BenchProblem | None] = lambda: None,
    ) -> None:
        self._desk, self._gate = desk, gate
        self._here = desk.describe()
        self._prefix = prefix(self._here.bench)
        self._publications, self._readings = publications, readings
        self._sender, self._work = sender, work
        self._clash = clash
        self._stopped: dict[str, int] = {}
        """Number of the last stop of each device, or axis of one; empty: of all."""
        self.carried_out = 0

    def handle(self, request: Request) -> None:
        """Carry out a command and answer it, or answer a reading."""
        key, query = request.key, request.query
        if request.pattern == HALT and key == STOP_ALL:
            key = f"{self._prefix}/{HALT}"  # each bench answers under its own
        try:
            reader = command_at(key.removeprefix(self._prefix + "/"), bool(request.payload))
            if reader is not None:
                source, command = self._source(request, reader), reader(request.payload)
                self._is_meant(command)
                self._in_order(command, request.number)
                self._carry_out(source, key, command, query)
                self._note_stop(command, request.number)
            elif query is not None:
                self._readings.read(request.pattern, key, query)
            else:
                raise VerbRefused("bad_request", "this key takes no put; the reference lists the keys")
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)

    def _source(self, request: Request, reader: Reader) -> Source:
        """Source of a request. Raises VerbRefused: the sender is unknown."""
        if self._gate is None:
            return OURS
        payload = request.payload or b""
        try:
            user = self._gate.check(request.attachment, request.key, payload, time.time_ns())
        except VerbRefused as refusal:
            with suppress(VerbRefused):  # it is no command either
                self._desk.note_refusal(STRANGER, *reader(request.payload), refusal)
            raise
        return replace(user, via="zenoh", proof=Proof(request.key, payload, request.attachment or b""))

    def _is_meant(self, command: Command) -> None:
        """Check that a command is for this bench and no other. A stop is for all. Raises VerbRefused."""
        if (clash := self._clash()) and not command.is_stop:
            raise VerbRefused("not_now", f"{clash.what}; {clash.remedy}")

    def _in_order(self, command: Command, number: int) -> None:
        """Check that no stop has overtaken a verb: a stop comes before all that waits, and what was asked for
        earlier must not move the axis afterwards. Raises VerbRefused."""
        names = {command.target, owner_of(command.target), ""}
        if command.operation != "do" or command.is_stop:
            return
        if number < max(self._stopped.get(name, 0) for name in names):
            raise VerbRefused(
                "not_now", f"a stop of {command.target} came while this waited; ask for it again"
            )

    def _note_stop(self, command: Command, number: int) -> None:
        if command.is_stop:
            axes = command.given.get("axes")
            for target in axes if command.operation == HALT and isinstance(axes, list) and axes else ():
                self._stopped[target] = number
            if command.operation != HALT or not axes:
                self._stopped[command.target] = number

    def _carry_out(self, source: Source, key: str, command: Command, query: zenoh.Query | None) -> None:
        answer = self._desk.ask(source, command.operation, command.target, command.given)
        if isawaitable(answer):
            doing = asyncio.ensure_future(answer)
            task = self._work.begin(self._answer_later(source, key, command, query, doing))
            task.add_done_callback(lambda _: doing.cancel())  # one that never began has not awaited it
        else:
            self._answer_done(source, key, command, query, answer)

    def _answer_done(
        self, source: Source, key: str, command: Command, query: zenoh.Query | None, answer: Any
    ) -> None:
        """Reply that a command was carried out, and of a verb's motion again when it has ended."""
        if command.operation == "do" and query is not None and isinstance(answer, Done):
            self._answer_verb(source, key, command.target, answer, query)
        else:
            self._answer(query, key, answer)

    def _answer_verb(self, source: Source, key: str, device: str, done: Done, query: zenoh.Query) -> None:
        """Reply to a verb at once, and on demand again when its motion has ended, with the state then."""
        self.carried_out += 1
        self._reply(query, key, done.answer, done.effective_at_ns)
        is_seen = self._here.devices[device].is_seen
        wanted = query.parameters
        if is_seen and wanted.get("applied") == "true":
            state = short_state(self._desk, self._here.devices, device)
            self._reply(query, key, {"applied": True, "state": state}, done.effective_at_ns)
        if is_seen and wanted.get("done") == "true":
            self._work.await_end(self._wait(source, key, device, done, query))
        else:
            self._sender.end(query)

    async def _wait(self, source: Source, key: str, device: str, done: Done, query: zenoh.Query) -> None:
        given = {name: done.answer[name] for name in ("ends_after_ns", "set_point") if name in done.answer}
        given["effective_at_ns"] = done.effective_at_ns
        try:
            ended = await self._desk.ask(source, "wait", device, given)
            answer = {"done": True, **ended, "state": short_state(self._desk, self._here.devices, device)}
            self._reply(query, key, answer, done.effective_at_ns)
            self._sender.end(query)
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)
        except asyncio.CancelledError:
            too_many = VerbRefused("not_now", f"{LATER} others wait for an end; ask for its state")
            self._refuse(key, query, too_many)
            raise

    async def _answer_later(
        self, source: Source, key: str, command: Command, query: zenoh.Query | None, doing: Awaitable[Any]
    ) -> None:
        try:
            answer = await doing
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)
            return
        except BaseException:
            if query is not None:
                self._sender.end(query)
            raise
        self._answer_done(source, key, command, query, answer)

    def _answer(self, query: zenoh.Query | None, key: str, answer: Any) -> None:
        """Reply that something was carried out."""
        self.carried_out += 1
        if query is not None:
            if isinstance(answer, Done):
                self._reply(query, key, answer.answer, answer.effective_at_ns)
            else:
                self._reply(query, key, answer, None)
            self._sender.end(query)

    def _reply(
        self, query: zenoh.Query, key: str, answer: Mapping[str, Any], effective_at_ns: int | None
    ) -> None:
        effect = {} if effective_at_ns is None else {"effective_at_ns": effective_at_ns}
        self._sender.reply(query, key, dumped({**effect, **answer}, self._here.clock), ACKNOWLEDGED)

    def _refuse(self, key: str, query: zenoh.Query | None, refusal: VerbRefused) -> None:
        content = {"key": key, "code": refusal.code, "error": str(refusal)}
        text = dumped(content, self._here.clock)
        if query is not None:
            self._sender.reply(query, None, text, REFUSED)
            self._sender.end(query)
        self._publications.rejected(text)


def command_at(rest: str, has_payload: bool) -> Reader | None:
    """Reader for the command under a key below the bench's; None: it is no command.

    Raises:
        VerbRefused: a command for many devices.
    """
    match rest.split("/"):
        case ["axis", device, "cmd", verb] if "*" not in device + verb:
            return lambda payload: Command("do", device, {"name": verb, "parameters": read_payload(payload)})
        case ["axis", device, "param", field] if has_payload and "*" not in device + field:
            return lambda payload: Command(
                "set", device, {"field": field, "value": read_payload(payload, {int, float})}
            )
        case ["axis" | "segment", target, "fault"] if "*" not in target:
            return lambda payload: _fault(target, read_payload(payload))
        case ["halt"]:
            return lambda payload: Command(HALT, "", read_payload(payload))
        case ["lease", ("take" | "renew" | "give" | "break") as do]:
            return lambda payload: Command(f"{do}_lease", "", read_payload(payload))
        case ["run", "submit"]:
            return lambda payload: Command("run", "", {"text": read_text(payload)})
        case ["run", name, "part"] if "*" not in name:
            return lambda payload: Command("part", name, {"given": read_payload(payload, longest=RUN_BYTES)})
        case ["run", name, "cancel"] if "*" not in name:
            return lambda payload: Command(
                "cancel_run", name, {"how": read_payload(payload).get("how", "grace")}
            )
        case ["axis", _, "param", _] if not has_payload:
            return None
        case ["axis", _, "cmd" | "param", _] | ["axis" | "segment", _, "fault"]:
            raise VerbRefused("bad_request", "a command is for one device: write its name instead of *")
    return None


def _fault(key_target: str, given: dict[str, object]) -> Command:
    """Read a command that begins a fault on what the key names or on something of it, or ends it."""
    if "clear" in given:
        which = given.pop("clear")
        if given:
            raise VerbRefused("bad_parameter", "clear: give nothing else with it")
        return Command("clear", "", {"number": which, "on": key_target})
    target = given.pop("target", key_target)
    if not isinstance(target, str) or owner_of(target) != owner_of(key_target):
        raise VerbRefused("bad_parameter", f"target: {key_target}, or something of it")
    named = {"fault": given.pop("fault")} if "fault" in given else {}
    return Command("inject", target, {**named, "parameters": given})
