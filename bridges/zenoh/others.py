"""Other benches that are reached over the same session: questions to them, and a list of them."""

import asyncio
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import zenoh

from bridges.zenoh.documents import RUN_BYTES
from bridges.zenoh.gate import Gate
from bridges.zenoh.keys import prefix
from hil.net.site_stop import STOP_ALL, stop_all
from hil.vocab.bridge_protocol import Answered, BenchGone
from hil.vocab.desk_protocol import Description, Source
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import JsonError, read_json

_LIVE_S = 1.0
_ATTACHMENT_ROOM = 4096
_REFUSED = b"{"
"""Start of a refusal; zenoh's own words on a query without an answer do not begin so."""


class Others:
    """Other benches of a session, as ``hil.vocab.bridge_protocol.BenchDoor``."""

    def __init__(self, session: zenoh.Session, here: Description, gate: Gate | None) -> None:
        self._session = session
        self._here = here
        self._gate = gate

    async def ask(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        """Ask a bench, as ``BenchDoor.ask_bench``."""
        key, payload = f"{prefix(bench)}/{rest}", json.dumps(given).encode()
        if len(payload) > RUN_BYTES - _ATTACHMENT_ROOM:
            longest = RUN_BYTES - _ATTACHMENT_ROOM
            raise VerbRefused("bad_request", f"{len(payload)} bytes for bench {bench}; {longest} at most")
        attachment = self._gate.signed(source, self._here.bench, key, payload) if self._gate else None
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[tuple[zenoh.Reply | None, int]] = loop.create_future()

        def settle(reply: zenoh.Reply | None, at_ns: int) -> None:
            if not answer.done():
                answer.set_result((reply, at_ns))

        def later(reply: zenoh.Reply | None) -> None:  # in a thread of zenoh
            with suppress(RuntimeError):  # the loop is closed: the daemon has stopped
                loop.call_soon_threadsafe(settle, reply, self._here.clock.times_ns()[1])

        def get() -> int:
            asked_ns = self._here.clock.times_ns()[1]
            self._session.get(
                key,
                zenoh.handlers.Callback(later, partial(later, None), indirect=False),
                payload=payload,
                attachment=attachment,
                encoding=zenoh.Encoding.APPLICATION_JSON,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=timeout_s,
            )
            return asked_ns

        gone = BenchGone(f"the bench {bench} did not answer within {timeout_s:g} s")
        try:
            asked_ns = await loop.run_in_executor(None, get)
            async with asyncio.timeout(timeout_s + _LIVE_S):
                reply, heard_ns = await answer
        except (TimeoutError, zenoh.ZError):
            raise gone from None
        return Answered(_content(reply, gone), asked_ns, heard_ns)

    async def stop_others(self, source: Source, how: str, timeout_s: float) -> Sequence[dict[str, Any]]:
        """Stop all others, as ``BenchDoor.stop_others``."""

        def sign(key: str, payload: bytes) -> bytes | None:
            return self._gate.signed(source, self._here.bench, key, payload) if self._gate else None

        sign(STOP_ALL, b"")  # who may not sign is refused before anything is sent
        stopping = partial(stop_all, self._session, sign, how, timeout_s, (self._here.bench,))
        return await asyncio.get_running_loop().run_in_executor(None, stopping)

    async def benches(self) -> Sequence[str]:
        """Names of the benches whose daemons are there."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(None, self._alive)

    def _alive(self) -> Sequence[str]:
        tokens = self._session.liveliness().get("hil/*/@live/daemon", timeout=_LIVE_S)
        names = {str(token.ok.key_expr).split("/")[1] for token in tokens if token.ok}
        return sorted(names - {self._here.bench})


def _content(reply: zenoh.Reply | None, gone: BenchGone) -> Mapping[str, Any]:
    if reply is not None and reply.ok is not None:
        return _object(reply.ok.payload.to_bytes(), gone)
    refusal = reply.err.payload.to_bytes() if reply is not None and reply.err is not None else b""
    if not refusal.startswith(_REFUSED):
        raise gone
    told = _object(refusal, gone)
    raise VerbRefused(str(told.get("code")), str(told.get("error")))


def _object(text: bytes, gone: BenchGone) -> Mapping[str, Any]:
    """Parse an answer as an object: whatever answers for another bench is not this program."""
    try:
        content = read_json(text)
    except JsonError:
        raise gone from None
    if not isinstance(content, dict):
        raise gone
    return content
