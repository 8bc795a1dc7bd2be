"""Stop of all benches of a site: one message for all, and one more to each that is silent.

Each bench confirms under its own key, and puts a stop before all that waits there.
"""

import json
import time
from collections.abc import Callable, Collection
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

import zenoh

from hil.wire.json_text import JsonError, read_json

STOP_ALL = "hil/*/halt"
DAEMONS = "hil/*/@live/daemon"
TIMEOUT_S = 1.0
"""Time to confirm, if nothing else is said: a bench under a flood takes a tenth of it."""
ASKS = 3
"""Number of questions to a bench that is silent."""
_BUSY = "busy"
_FIELDS = {"stopped": list, "runs": list, "refused": dict}
Sign = Callable[[str, bytes], bytes | None]
"""Signature of a key and a payload; None: nobody signs."""
Row = dict[str, Any]
"""``bench``; ``state``: confirmed, refused or silent; ``why`` it is not confirmed, or None; ``took_s``: until
its answer, or None; and of a confirmed one ``stopped``, ``runs`` and ``refused`` as ``halt`` answers them."""


def stop_all(
    session: zenoh.Session, sign: Sign, how: str, timeout_s: float, left_out: Collection[str] = ()
) -> list[Row]:
    """Stop all benches behind a session, except those ``left_out``; answers a row for each that is there,
    by name. Takes ``timeout_s`` at most, and no longer than until all have answered. Blocks."""
    return _StopOfAll(session, sign, how, left_out).rows(timeout_s)


class _StopOfAll:
    def __init__(self, session: zenoh.Session, sign: Sign, how: str, left_out: Collection[str]) -> None:
        self._session, self._sign, self._left_out = session, sign, left_out
        self._payload = json.dumps({"how": how}).encode()
        self._news: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._there: set[str] = set()
        self._is_listed = False
        self._heard: dict[str, Row] = {}
        self._why: dict[str, str] = {}
        """Reasons why those are silent that had no room for the question."""
        self._began_s = time.monotonic()

    def rows(self, timeout_s: float) -> list[Row]:
        end_s = self._began_s + timeout_s
        self._ask(STOP_ALL, timeout_s)
        self._list(timeout_s)
        for number in range(1, ASKS + 1):
            self._listen(end_s if number == ASKS else self._began_s + timeout_s * number / ASKS)
            left_s = end_s - time.monotonic()
            for bench in self._silent if left_s > 0 else ():
                self._ask(f"hil/{bench}/halt", left_s)
        silent = [
            _row(bench, "silent", self._why.get(bench, f"no answer within {timeout_s:g} s"))
            for bench in self._silent
        ]
        return sorted([*self._heard.values(), *silent], key=lambda row: str(row["bench"]))

    @property
    def _silent(self) -> list[str]:
        return sorted(self._there - self._heard.keys() - set(self._left_out))

    def _listen(self, until_s: float) -> None:
        """Take answers in until a time, or until all that are there have answered."""
        while not (self._is_listed and not self._silent):
            try:
                self._news.get(timeout=max(until_s - time.monotonic(), 0.0))()
            except Empty:
                return

    # ---- what is asked; answers come in threads of zenoh ----

    def _ask(self, key: str, timeout_s: float) -> None:
        self._session.get(
            key,
            zenoh.handlers.Callback(self._answered, indirect=False),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
            payload=self._payload,
            encoding=zenoh.Encoding.APPLICATION_JSON,
            attachment=self._sign(key, self._payload),
            allowed_destination=zenoh.Locality.REMOTE,
        )

    def _answered(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            answer = (str(reply.ok.key_expr), reply.ok.payload.to_bytes(), True)
        elif reply.err is not None:
            answer = ("", reply.err.payload.to_bytes(), False)
        else:
            return
        self._news.put(partial(self._take_answer, *answer, time.monotonic() - self._began_s))

    def _list(self, timeout_s: float) -> None:
        """Ask which benches are there."""

        def found(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                self._news.put(partial(self._there.add, _bench_of(str(reply.ok.key_expr))))

        def listed() -> None:
            self._is_listed = True

        self._session.liveliness().get(
            DAEMONS,
            zenoh.handlers.Callback(found, lambda: self._news.put(listed), indirect=False),
            timeout=timeout_s,
        )

    # ---- here ----

    def _take_answer(self, key: str, payload: bytes, is_done: bool, took_s: float) -> None:
        """Take an answer in. What is none, as zenoh's own word for a time-out, is left out."""
        try:
            told = read_json(payload)
        except JsonError:
            return
        if not isinstance(told, dict):
            return
        bench = _bench_of(key or str(told.get("key", "")))
        if not bench or bench == "*" or (self._heard.get(bench) or {}).get("state") == "confirmed":
            return
        if is_done:
            fields = {name: kind(told.get(name) or ()) for name, kind in _FIELDS.items()}
            self._heard[bench] = _row(bench, "confirmed", None, took_s, **fields)
        elif told.get("code") == _BUSY:
            self._why[bench] = str(told.get("error"))
        else:
            self._heard[bench] = _row(bench, "refused", str(told.get("error")), took_s)


def _bench_of(key: str) -> str:
    parts = key.split("/")
    return parts[1] if len(parts) > 2 and parts[0] == "hil" else ""


def _row(bench: str, state: str, why: str | None, took_s: float | None = None, **told: Any) -> Row:
    row = {"bench": bench, "state": state, "why": why, "took_s": took_s}
    return row | {name: told.get(name, kind()) for name, kind in _FIELDS.items()}
