"""Stops of a page: they pass what waits, and what they pass moves nothing afterwards."""

import asyncio

import pytest
from pages_of_tests import PagesDesk, opened

from bridges.web import web_bridge
from bridges.web.read_ahead import MOST_AHEAD, ReadAhead
from hil.net.fair_share import FairShare
from hil.vocab.operation import Operation, Target, Urgency
from hil.vocab.verbs import VerbRefused

DO = Operation("do", Target.MEMBER, "", answer=dict)
HALT = Operation("halt", Target.BENCH, "", answer=dict)


def test_what_a_stop_passed_is_refused_and_what_came_behind_it_is_not() -> None:
    async def main() -> None:
        ahead = ReadAhead()
        await ahead.put("enable", 1, Urgency.COMMAND, "m1", is_long=False)
        passed = await ahead.next()
        ahead.done()
        stop = ahead.stop("m1")
        with pytest.raises(VerbRefused, match="a stop of m1 came"):
            ahead.check(passed.place, "m1")
        with pytest.raises(VerbRefused):
            ahead.check(passed.place, "m1.elbow")
        ahead.check(passed.place, "m10")
        ahead.check(passed.place, "")
        ahead.check(stop, "m1")
        ahead.stop("")
        with pytest.raises(VerbRefused):
            ahead.check(stop, "m10")

    asyncio.run(main())


def test_nothing_is_read_behind_a_long_message() -> None:
    async def main() -> None:
        ahead = ReadAhead()
        putting = asyncio.create_task(ahead.put("text", 1, Urgency.READING, "", is_long=True))
        await ahead.next()
        await asyncio.sleep(0)
        assert not putting.done()
        ahead.done()
        await putting

    asyncio.run(main())


class HeldTurns(FairShare):
    """Turns of which there are none until a test lets them go."""

    def __init__(self) -> None:
        super().__init__()
        self.free = asyncio.Event()

    async def wait(self, urgency: Urgency = Urgency.READING, moves: str = "") -> None:
        if urgency is not Urgency.STOP:
            await self.free.wait()


def test_a_halt_is_answered_before_what_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """It needs no turn, and stands behind nobody who does."""
    monkeypatch.setattr(web_bridge, "FairShare", HeldTurns)
    answer = {"stopped": ["m1"], "runs": [], "refused": {}}

    async def use() -> None:
        desk = PagesDesk({"halt": answer})
        desk._operations = {"do": DO, "halt": HALT}
        async with opened(desk) as door, door.page() as page:
            for number in range(1, 9):
                given = {"name": "reset", "parameters": {}}
                moving = {"id": number, "do": "ask", "operation": "do", "target": "m1", "given": given}
                await page.socket.send_json(moving)
            await page.socket.send_json({"id": 90, "do": "ask", "operation": "halt"})
            assert await page.answer(90) == answer
            door.bridge._pages._around.turns.free.set()  # type: ignore[attr-defined]
            assert {(await page.answer(number))["code"] for number in range(1, 9)} == {"not_now"}
            again = {"name": "reset", "parameters": {}}
            assert "effective_at_ns" in await page.ask("ask", operation="do", target="m1", given=again)

    asyncio.run(use())


def test_a_page_has_room_for_what_waits() -> None:
    assert MOST_AHEAD >= 32  # as many as wait for their answers
