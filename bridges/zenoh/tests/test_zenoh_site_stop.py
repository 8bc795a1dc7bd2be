"""Stop of all benches of a site: who confirms, who refuses, who is asked again. All is in one process."""

import json
import socket
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest
import zenoh

from bridges.zenoh.gate import Gate, Rejected
from bridges.zenoh.users import User
from hil.net.signature import signed
from hil.net.site_stop import DAEMONS, STOP_ALL, stop_all
from hil.vocab.verbs import Role

NOW_NS = 1_795_254_243_000_000_000
OTTO = User("otto", Role.OPERATOR, "the-operators-password")
ANSWER = {"v": 1, "stopped": ["m1"], "runs": ["r"], "refused": {}}
Answering = Callable[[str, int, zenoh.Query], None]
"""Answers the question with this number, from 1, to a bench."""


def session(mode: str, **entries: Any) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", f'"{mode}"')
    config.insert_json5("scouting/multicast/enabled", "false")
    for name, value in entries.items():
        config.insert_json5(f"{name}/endpoints", json.dumps(value))
    return zenoh.open(config)


@pytest.fixture(scope="module")
def door() -> Iterator[str]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    with session("router", listen=[address]):
        yield address


@pytest.fixture(scope="module")
def asker(door: str) -> Iterator[zenoh.Session]:
    with session("client", connect=[door]) as opened:
        yield opened


class Benches:
    """Benches that answer as they are told."""

    def __init__(self, door: str, answering: Mapping[str, Answering]) -> None:
        self.asked: Counter[str] = Counter()
        self._session = session("client", connect=[door])
        self._kept: list[Any] = []
        for name, answers in answering.items():
            asked = self._asked(name, answers)
            self._kept.append(self._session.declare_queryable(f"hil/{name}/halt", asked, complete=True))
            self._kept.append(self._session.liveliness().declare_token(f"hil/{name}/@live/daemon"))
        with session("client", connect=[door]) as looker:
            deadline_s = time.monotonic() + 30
            while len(list(looker.liveliness().get(DAEMONS))) < len(answering):
                assert time.monotonic() < deadline_s
                time.sleep(0.01)

    def _asked(self, name: str, answers: Answering) -> Callable[[zenoh.Query], None]:
        def asked(query: zenoh.Query) -> None:
            self.asked[name] += 1
            answers(name, self.asked[name], query)

        return asked

    def __enter__(self) -> "Benches":
        return self

    def __exit__(self, *_: object) -> None:
        self._session.close()  # type: ignore[no-untyped-call]


def confirms(name: str, number: int, query: zenoh.Query) -> None:
    query.reply(f"hil/{name}/halt", json.dumps(ANSWER))


def is_silent(name: str, number: int, query: zenoh.Query) -> None:
    pass


def at_the_second(name: str, number: int, query: zenoh.Query) -> None:
    if number > 1:
        confirms(name, number, query)


def refuses(name: str, number: int, query: zenoh.Query) -> None:
    told = {"key": f"hil/{name}/halt", "code": "forbidden", "error": "halt needs the role operator"}
    query.reply_err(json.dumps(told))


def is_busy(name: str, number: int, query: zenoh.Query) -> None:
    told = {"key": str(query.key_expr), "code": "busy", "error": "too many requests wait here already"}
    query.reply_err(json.dumps(told))


def babbles(name: str, number: int, query: zenoh.Query) -> None:
    query.reply(f"hil/{name}/halt", b"\xff{[")
    query.reply_err(b"[]")


def stopped(asker: zenoh.Session, timeout_s: float = 2.0, **more: Any) -> dict[str, dict[str, Any]]:
    rows = stop_all(asker, lambda key, payload: None, "grace", timeout_s, **more)
    return {row["bench"]: row for row in rows}


def test_all_confirm_by_one_message(door: str, asker: zenoh.Session) -> None:
    names = [f"b{number}" for number in range(20)]
    with Benches(door, dict.fromkeys(names, confirms)) as benches:
        rows = stopped(asker, 10)
    assert list(rows) == sorted(names)
    assert {row["state"] for row in rows.values()} == {"confirmed"}
    assert set(benches.asked.values()) == {1}
    assert (rows["b7"]["stopped"], rows["b7"]["runs"], rows["b7"]["refused"]) == (["m1"], ["r"], {})
    assert 0 < rows["b7"]["took_s"] < 10


def test_one_that_is_silent_is_asked_again_and_told(door: str, asker: zenoh.Session) -> None:
    answering = {"a": confirms, "b": at_the_second, "c": is_silent}
    with Benches(door, answering) as benches:
        rows = stopped(asker)
    assert [row["state"] for row in rows.values()] == ["confirmed", "confirmed", "silent"]
    assert rows["c"]["why"] == "no answer within 2 s"
    assert (benches.asked["a"], benches.asked["c"]) == (1, 3)


def test_a_refusal_says_who_and_why(door: str, asker: zenoh.Session) -> None:
    with Benches(door, {"a": confirms, "b": refuses, "c": is_busy, "d": babbles}):
        rows = stopped(asker, 1.0)
    assert [row["state"] for row in rows.values()] == ["confirmed", "refused", "silent", "silent"]
    assert rows["b"]["why"] == "halt needs the role operator"
    assert rows["c"]["why"] in ("too many requests wait here already", "no answer within 1 s")


def test_the_bench_that_asks_is_left_out(door: str, asker: zenoh.Session) -> None:
    with Benches(door, {"a": confirms, "b": is_silent}):
        assert list(stopped(asker, 10, left_out=("b",))) == ["a"]


def test_nobody_is_there(asker: zenoh.Session) -> None:
    assert stopped(asker, 10) == {}


def test_a_signature_for_all_is_good_once_at_each_bench() -> None:
    attachment = signed("otto", OTTO.secret, STOP_ALL, b"{}", NOW_NS, "00112233445566778899aabbccddeeff")
    mill, lathe = Gate([OTTO]), Gate([OTTO])
    for gate in (mill, lathe):
        assert gate.check(attachment, STOP_ALL, b"{}", NOW_NS) == OTTO
        with pytest.raises(Rejected, match="used before"):
            gate.check(attachment, STOP_ALL, b"{}", NOW_NS)
    with pytest.raises(Rejected, match="signature is wrong"):
        Gate([OTTO]).check(attachment, "hil/mill/halt", b"{}", NOW_NS)
