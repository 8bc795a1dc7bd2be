"""Order of requests at the bridge: stops, commands, readings; shares of askers; refusals where it is full."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any, cast

from bridges.zenoh.inbox import COMMANDS_WAITING, READINGS_WAITING, Inbox, Request, SourceLane, Urgency
from bridges.zenoh.keys import COMMAND, KEYS, PUBLISH, expression
from bridges.zenoh.sender import Sender

VERBS, STATE = "axis/<device>/cmd/<verb>", "axis/<device>/state"


class Told:
    """Stand-in for a sender, which keeps what it is given."""

    def __init__(self) -> None:
        self.refused: list[dict[str, Any]] = []
        self.ended: list[Any] = []

    waiting = 0

    def reply(self, query: Any, key: str | None, content: bytes, encoding: Any) -> None:
        self.refused.append(json.loads(content))

    def end(self, query: Any) -> None:
        self.ended.append(query)


def handled_by(
    work: Callable[[Inbox, list[str]], Awaitable[None]], acks: Told | None = None, answers: Told | None = None
) -> list[str]:
    """Keys in the order in which they were handled, when ``work`` has ended."""
    handled: list[str] = []

    async def main() -> None:
        senders = cast(Sender, acks or Told()), cast(Sender, answers or Told())
        inbox = Inbox(*senders, lambda request: handled.append(request.key), ("otto", "vera"))
        await work(inbox, handled)
        inbox.close()

    asyncio.run(main())
    return handled


def query(inbox: Inbox, pattern: str, key: str, user: str = "") -> None:
    attachment = json.dumps({"user": user}).encode() if user else None
    inbox._enqueue(Request(key, b"{}" if "cmd" in key else None, attachment, cast(Any, key), pattern))


async def until_handled(handled: list[str], count: int) -> None:
    async with asyncio.timeout(30):
        while len(handled) < count:
            await asyncio.sleep(0)


def test_a_stop_comes_before_commands_and_these_before_readings() -> None:
    async def work(inbox: Inbox, handled: list[str]) -> None:
        for n in range(100):
            query(inbox, STATE, f"state{n}")
        for n in range(3):
            query(inbox, VERBS, f"hil/b/axis/m1/cmd/go{n}")
        query(inbox, VERBS, "hil/b/axis/m1/cmd/stop")
        await until_handled(handled, 104)

    handled = handled_by(work)
    goes = [f"hil/b/axis/m1/cmd/go{n}" for n in range(3)]
    assert handled[:4] == ["hil/b/axis/m1/cmd/stop", *goes]
    assert handled[4:] == [f"state{n}" for n in range(100)]


def test_a_parameter_is_read_as_a_reading_and_set_as_a_command() -> None:
    on = "axis/<device>/param/<name>"
    asked: Any = "query"
    assert Request("k", None, None, asked, on).urgency is Urgency.READING
    assert Request("k", b"3", None, asked, on).urgency is Urgency.COMMAND
    assert Request("k", b"3", None, None, on).urgency is Urgency.COMMAND
    assert Request("hil/b/run/stop/cancel", b"", None, asked, "run/<id>/cancel").urgency is Urgency.COMMAND


def test_known_users_take_turns_with_each_other_and_with_strangers() -> None:
    async def work(inbox: Inbox, handled: list[str]) -> None:
        for n in range(50):
            query(inbox, STATE, f"stranger{n}")
            query(inbox, STATE, f"forger{n}", "nobody-here")
        query(inbox, STATE, "otto", "otto")
        query(inbox, STATE, "vera", "vera")
        await until_handled(handled, 102)

    assert set(handled_by(work)[1:3]) == {"otto", "vera"}


def test_what_finds_no_room_is_refused_and_commands_go_on() -> None:
    acks, answers = Told(), Told()

    async def work(inbox: Inbox, handled: list[str]) -> None:
        for n in range(READINGS_WAITING):
            query(inbox, STATE, f"state{n}")
        for _ in range(COMMANDS_WAITING):
            query(inbox, VERBS, "hil/b/axis/m1/cmd/go")
        query(inbox, STATE, "ottos", "otto")
        query(inbox, VERBS, "hil/b/axis/m1/cmd/stop")
        await asyncio.sleep(0)
        assert handled[0].endswith("/stop")
        assert inbox.refused == READINGS_WAITING / 2 + COMMANDS_WAITING / 2
        await until_handled(handled, READINGS_WAITING // 2 + COMMANDS_WAITING // 2 + 2)

    handled = handled_by(work, acks, answers)
    assert "ottos" in handled
    assert len(answers.refused) == len(answers.ended) == READINGS_WAITING / 2
    assert {told["code"] for told in (*answers.refused, *acks.refused)} == {"busy"}
    assert len(acks.refused) == COMMANDS_WAITING / 2


def test_readings_take_a_part_of_the_time(monkeypatch: Any) -> None:
    clock = SimpleNamespace(now_s=0.0)
    pauses: list[float] = []

    async def main() -> None:
        def handle(request: Request) -> None:
            clock.now_s += 0.003

        inbox = Inbox(cast(Sender, Told()), cast(Sender, Told()), handle, (), lambda: clock.now_s)
        loop = asyncio.get_running_loop()
        later = loop.call_later
        monkeypatch.setattr(loop, "call_later", lambda s, call: (pauses.append(s), later(0, call))[1])
        for n in range(5):
            query(inbox, STATE, f"state{n}")
        async with asyncio.timeout(30):
            while len(pauses) < 4:
                await asyncio.sleep(0)
        inbox.close()

    asyncio.run(main())
    assert [round(pause, 6) for pause in pauses] == [0.007] * 4


def test_a_lane_gives_each_source_its_turn_and_half_of_the_room() -> None:
    lane = SourceLane[int](6)
    assert [lane.put("a", n) for n in range(4)] == [True, True, True, False]
    assert [lane.put("b", 10), lane.put("c", 20)] == [True, True]
    assert [lane.take() for _ in range(len(lane))] == [0, 10, 20, 1, 2]


def test_no_key_that_is_told_is_taken_as_a_command() -> None:
    """Else two benches of one name would refuse what the other tells, and refuse the refusals."""
    import zenoh

    taken = [zenoh.KeyExpr(expression("b", key.pattern)) for key in KEYS if COMMAND in key.way]
    for key in KEYS:
        if PUBLISH in key.way:
            assert not any(each.intersects(zenoh.KeyExpr(expression("b", key.pattern))) for each in taken)
