"""Answers queries and carries out commands. Zenoh's threads only fill a queue; all else is in the loop."""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Coroutine, Mapping, Sequence
from contextlib import suppress
from typing import Any

import zenoh

from bridges.zenoh.documents import RUN_BYTES, acknowledged, read_payload, read_text, refused
from bridges.zenoh.gate import Gate
from bridges.zenoh.keys import prefix
from bridges.zenoh.opening import open_session
from bridges.zenoh.options import Options
from bridges.zenoh.others import Others
from bridges.zenoh.publications import Publications, short_state
from bridges.zenoh.readings import SLICE, Readings, encoding
from bridges.zenoh.reference import reference
from bridges.zenoh.sender import Sender
from bridges.zenoh.users import SecurityError
from hil.vocab.benches import Answered, BenchGone
from hil.vocab.bridges import BridgeError, BridgeHost, Done, Source
from hil.vocab.verbs import Role, VerbRefused

__all__ = ["Options", "make", "reference"]

log = logging.getLogger("hil")

WAITING = 10_000
"""Requests in the queue; later puts are dropped and counted, queries when there are twice as many."""
LATER = 1_000
"""Queries that wait for a motion's end."""
LONGEST_S = 3600.0
_NOBODY_THERE = "Unable to connect"

Request = tuple[str, bytes | None, bytes | None, zenoh.Query | None]


def make(options: Options, host: BridgeHost) -> "ZenohBridge":
    """The bridge, not yet open."""
    return ZenohBridge(options, host)


class ZenohBridge:
    """``hil.vocab.bridges.Bridge``."""

    def __init__(self, options: Options, host: BridgeHost) -> None:
        self._options = options
        self._host = host
        self._prefix = prefix(host.bench)
        self._queue: deque[Request] = deque()
        self._lock = threading.Lock()
        self._is_awake = False
        """``_drain`` will come."""
        self._waiting: dict[asyncio.Task[None], None] = {}
        """Answers at a motion's end, the oldest first."""
        self._working: set[asyncio.Task[None]] = set()
        """Answers that take their time otherwise."""
        self._sender: Sender
        self._session: zenoh.Session | None = None
        self._is_closed = False
        self._gate: Gate | None = None
        self._entities: list[Any] = []
        self._tokens: dict[str, Any] = {}
        """Of devices that are there."""
        self.dropped = 0
        self.commands = 0

    async def open(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._sender = Sender()
        try:
            opened = await self._loop.run_in_executor(None, open_session, self._options, self._host.bench)
        except SecurityError as error:
            raise BridgeError(str(error)) from None
        except zenoh.ZError as error:
            if self._options.listen or not str(error).startswith(_NOBODY_THERE):
                raise BridgeError(
                    f"{first_line(error)}; listen: choose another address, or [] for none"
                ) from None
            log.warning("zenoh: nobody at %s yet, tried again each second", ", ".join(self._options.connect))
            self._work(self._join())
        else:
            self._opened(*opened)

    async def _join(self) -> None:
        """The router that was away at the start."""
        while self._session is None:
            try:
                opened = await self._loop.run_in_executor(None, open_session, self._options, self._host.bench)
            except zenoh.ZError:
                continue  # it took a second
            if self._is_closed:
                await self._loop.run_in_executor(None, opened[0].close)
                return
            self._opened(*opened)
            log.info("zenoh: joined %s", ", ".join(self._options.connect))

    def _opened(self, session: zenoh.Session, gate: Gate | None) -> None:
        self._session, self._gate = session, gate
        self._others = Others(session, self._host, gate)
        self._publications = Publications(session, self._host, self._options)
        self._readings = Readings(self._host, self._publications, self._sender, self._work)
        everything = f"{self._prefix}/**"
        self._entities = [
            session.declare_subscriber(everything, self._on_put, allowed_origin=zenoh.Locality.REMOTE),
            session.declare_queryable(everything, self._on_query, complete=True),
        ]
        for name in ("daemon", *(f"segment/{name}" for name in self._host.segments)):
            self._entities.append(self._live(name))
        self._tokens = {name: self._live(f"axis/{name}") for name in self._host.devices}
        self._publications.start()

    def _live(self, name: str) -> Any:
        assert self._session
        return self._session.liveliness().declare_token(f"{self._prefix}/@live/{name}")

    async def devices_changed(self, names: Collection[str]) -> None:
        if self._session is None:
            return
        try:
            for name in names:
                if token := self._tokens.pop(name, None):
                    token.undeclare()
            self._publications.devices_changed(names)
            self._readings.refresh()
            self._tokens |= {name: self._live(f"axis/{name}") for name in names if name in self._host.devices}
        except zenoh.ZError as error:
            raise BridgeError(first_line(error)) from None

    async def close(self) -> None:
        self._is_closed = True
        if self._session is not None:
            await self._publications.stop()
        under_way = [*self._waiting, *self._working]
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)
        await self._loop.run_in_executor(None, self._sender.close)
        for entity in reversed([*self._entities, *self._tokens.values()]):
            entity.undeclare()
        self._entities.clear()
        self._tokens.clear()
        session, self._session = self._session, None
        if session is not None:
            await self._loop.run_in_executor(None, session.close)
        self._queue.clear()

    async def ask_bench(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        if self._session is None:
            raise BenchGone(f"the bench {bench} cannot be reached: this one is not joined yet")
        return await self._others.ask(source, bench, rest, given, timeout_s)

    async def benches(self) -> Sequence[str]:
        return await self._others.benches() if self._session else []

    def status(self) -> Mapping[str, Any]:
        clients = len(list(self._session.info.links())) if self._session else 0
        told = self._publications if self._session else None
        return {
            "root": self._prefix,
            "listen": list(self._options.listen),
            "connect": list(self._options.connect),
            "links": clients,
            "commands": self.commands,
            "rejected": told.rejections if told else 0,
            "dropped": self.dropped + self._sender.dropped + (told.dropped if told else 0),
            "waiting": len(self._waiting),
            "insecure": self._options.insecure,
        }

    # ---- in zenoh's threads ----

    def _on_put(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            attachment = sample.attachment.to_bytes() if sample.attachment else None
            self._enqueue((str(sample.key_expr), sample.payload.to_bytes(), attachment, None))

    def _on_query(self, query: zenoh.Query) -> None:
        payload = query.payload.to_bytes() if query.payload is not None else None
        attachment = query.attachment.to_bytes() if query.attachment else None
        self._enqueue((str(query.key_expr), payload, attachment, query))

    def _enqueue(self, request: Request) -> None:
        with self._lock:
            if len(self._queue) >= (WAITING if request[3] is None else 2 * WAITING):
                self.dropped += 1
                refused = request[3]
            else:
                self._queue.append(request)
                refused = None
            wakes = not self._is_awake
            self._is_awake = True
        if refused is not None:
            self._sender.end(refused)
        if wakes:
            with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
                self._loop.call_soon_threadsafe(self._drain)

    # ---- in the loop ----

    def _drain(self) -> None:
        """A few; the ports have their turn in between."""
        for _ in range(SLICE):
            with self._lock:
                if not self._queue or self._is_closed:  # what would answer is being put away
                    self._is_awake = False
                    return
                key, payload, attachment, query = self._queue.popleft()
            try:
                self._handle(key, payload, attachment, query)
            except Exception:  # ours: that request is lost, all else goes on
                log.exception("zenoh: %s could not be handled", key)
                if query is not None:
                    self._sender.end(query)
        self._loop.call_soon(self._drain)

    def _handle(
        self, key: str, payload: bytes | None, attachment: bytes | None, query: zenoh.Query | None
    ) -> None:
        try:
            carry_out = self._command(key, payload, attachment, query)
            if carry_out is not None:
                carry_out()
            elif query is not None:
                self._readings.read(key, query)
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)

    def _command(
        self, key: str, payload: bytes | None, attachment: bytes | None, query: zenoh.Query | None
    ) -> Callable[[], None] | None:
        """What carries out what came, or None: it is no command."""
        match key.removeprefix(self._prefix + "/").split("/"):
            case ["axis", device, "cmd", verb] if "*" not in device + verb:
                source = self._source(key, payload, attachment, Role.OPERATOR)
                given = read_payload(payload)
                return lambda: self._do(source, key, device, verb, given, query)
            case ["axis", device, "param", name] if payload and "*" not in device + name:
                source = self._source(key, payload, attachment, Role.OPERATOR)
                value = read_payload(payload, {int, float})
                return lambda: self._answer(query, key, self._host.set_field(source, device, name, value))
            case ["axis" | "segment", target, "fault"] if "*" not in target:
                source = self._source(key, payload, attachment, Role.ADMIN)
                given = read_payload(payload)
                return lambda: self._answer(query, key, self._host.fault(source, target, given))
            case ["run", "submit"]:
                source = self._source(key, payload, attachment, Role.OPERATOR)
                text = read_text(payload)
                return lambda: self._submit(query, key, source, text)
            case ["run", name, "part"] if "*" not in name:
                source = self._source(key, payload, attachment, Role.OPERATOR)
                asked = read_payload(payload, longest=RUN_BYTES)
                part = self._host.part_of_run
                return lambda: self._work(self._answer_later(query, key, part(source, name, asked)))
            case ["run", name, "cancel"] if "*" not in name:
                source = self._source(key, payload, attachment, Role.OPERATOR)
                how = read_payload(payload).get("how", "grace")
                return lambda: self._answer(query, key, self._host.cancel_run(source, name, how))
            case ["axis", _, "param", _] if not payload:
                pass
            case ["axis", _, "cmd" | "param", _] | ["axis" | "segment", _, "fault"]:
                raise VerbRefused("bad_request", "a command is for one device: write its name instead of *")
        if query is None:
            raise VerbRefused("bad_request", "nothing is put here; the reference has the keys")
        return None

    def _source(self, key: str, payload: bytes | None, attachment: bytes | None, needed: Role) -> Source:
        """Who sent it. Raises VerbRefused: nobody known, or not allowed."""
        if self._gate is None:
            return Source("zenoh", Role.ADMIN)
        source = self._gate.check(attachment, key, payload or b"", time.time_ns())
        if source.role < needed:
            raise VerbRefused(
                "forbidden", f"this needs the role {needed.name.lower()}; {source.name} has less"
            )
        return source

    def _do(
        self,
        source: Source,
        key: str,
        device: str,
        verb: str,
        given: Mapping[str, object],
        query: zenoh.Query | None,
    ) -> None:
        done = self._host.do_now(source, device, verb, given)
        if done is None:  # a real board's terminal takes its time
            self._work(self._answer_later(query, key, self._host.do(source, device, verb, given)))
            return
        self.commands += 1
        if query is None:
            return
        self._reply(query, key, done.answer, done.effective_at_ns)
        wanted = query.parameters
        if wanted.get("applied") == "true":
            self._reply(query, key, {"applied": True, "state": self._state(device)}, done.effective_at_ns)
        if wanted.get("done") == "true":
            self._await_end(self._wait(key, device, done, query))
        else:
            self._sender.end(query)

    def _submit(self, query: zenoh.Query | None, key: str, source: Source, text: str) -> None:
        submitted = self._host.submit_run(source, text)
        if isinstance(submitted, Mapping):
            self._answer(query, key, submitted)
        else:
            self._work(self._answer_later(query, key, submitted))

    def _await_end(self, waiting: Coroutine[Any, Any, None]) -> None:
        """Of too many that wait the one that has waited longest gives way: its asker may long be gone."""
        if len(self._waiting) >= LATER:
            oldest = next(iter(self._waiting))
            del self._waiting[oldest]
            self._working.add(oldest)
            oldest.add_done_callback(self._working.discard)
            oldest.cancel()
        task = self._loop.create_task(waiting)
        self._waiting[task] = None
        task.add_done_callback(lambda ended: self._waiting.pop(ended, None))

    def _work(self, working: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(working)
        self._working.add(task)
        task.add_done_callback(self._worked)

    def _worked(self, task: asyncio.Task[None]) -> None:
        self._working.discard(task)
        if not task.cancelled() and (error := task.exception()):
            log.error("zenoh: an answer could not be made", exc_info=error)

    async def _answer_later(
        self,
        query: zenoh.Query | None,
        key: str,
        doing: Coroutine[Any, Any, Done] | Coroutine[Any, Any, Mapping[str, Any]],
    ) -> None:
        try:
            done = await doing
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)
            return
        except BaseException:
            if query is not None:
                self._sender.end(query)
            raise
        self._answer(query, key, done)

    async def _wait(self, key: str, device: str, done: Done, query: zenoh.Query) -> None:
        try:
            how = await self._host.wait_until_done(device, done, LONGEST_S)
            if how is None:
                raise VerbRefused("not_now", f"it has not ended after {LONGEST_S:g} s; ask for its state")
            answer = {"done": True, "interrupted": how == "interrupted", "state": self._state(device)}
            self._reply(query, key, answer, done.effective_at_ns)
            self._sender.end(query)
        except VerbRefused as refusal:
            self._refuse(key, query, refusal)
        except asyncio.CancelledError:
            too_many = VerbRefused("not_now", f"{LATER} others wait for an end; ask for its state")
            self._refuse(key, query, too_many)
            raise

    def _state(self, device: str) -> Mapping[str, float | None]:
        return {} if self._host.devices[device].is_real else short_state(self._host, device)

    def _answer(self, query: zenoh.Query | None, key: str, done: Done | Mapping[str, Any]) -> None:
        """That something was carried out."""
        self.commands += 1
        if query is not None:
            if isinstance(done, Done):
                self._reply(query, key, done.answer, done.effective_at_ns)
            else:
                self._reply(query, key, done, None)
            self._sender.end(query)

    def _reply(
        self, query: zenoh.Query, key: str, answer: Mapping[str, Any], effective_at_ns: int | None
    ) -> None:
        text = acknowledged(answer, effective_at_ns, self._host.times_ns())
        self._sender.reply(query, key, text, ACKNOWLEDGED)

    def _refuse(self, key: str, query: zenoh.Query | None, refusal: VerbRefused) -> None:
        text = refused(refusal, key, self._host.times_ns())
        if query is not None:
            self._sender.refuse(query, text, REFUSED)
            self._sender.end(query)
        self._publications.rejected(text)


def first_line(error: Exception) -> str:
    """Of zenoh's errors, which end in a path of its sources."""
    return str(error).partition(" at /")[0].partition("\n")[0]


ACKNOWLEDGED, REFUSED = encoding("hil.ack.v1"), encoding("hil.error.v1")
