"""Readings that pages share, also one that cannot be made."""

import asyncio
import logging
from typing import Any, cast

import pytest

from bridges.web.shared_reading import FAILED_S, SharedReading
from bridges.web.streams import TAKEN_S, ToldReading
from hil.vocab.desk_protocol import LOCAL, Desk


class FailingDesk:
    """Desk whose first answer meets a fault."""

    def __init__(self) -> None:
        self.asked = 0

    async def _answer(self, number: int) -> dict[str, int]:
        if number == 1:
            raise ArithmeticError("a fault")
        return {"number": number}

    def ask(self, *given: Any) -> Any:
        self.asked += 1
        return self._answer(self.asked)


def test_a_reading_that_fails_is_logged_once_and_made_again_later(caplog: pytest.LogCaptureFixture) -> None:
    desk = FailingDesk()

    async def main() -> tuple[int, bytes]:
        reading = SharedReading(cast(Desk, desk), LOCAL, "status")

        async def read(at_s: float) -> Any:
            reading.read(at_s)
            for _ in range(3):
                await asyncio.sleep(0)
            return reading.read(at_s)

        now_s = asyncio.get_running_loop().time()
        for turn in range(10):
            await read(now_s + turn * 0.25)
        assert desk.asked == 1
        turn, parts = await read(now_s + FAILED_S)
        return turn, b"".join(parts)

    with caplog.at_level(logging.ERROR, "hil"):
        assert asyncio.run(main()) == (1, b'{"number":2}')
    assert [record.getMessage() for record in caplog.records] == ["bridges.web: status could not be read"]


class CountingDesk:
    """Desk whose answers take two turns of the loop."""

    def __init__(self) -> None:
        self.asked = 0

    async def _answer(self, number: int) -> int:
        await asyncio.sleep(0)
        return number

    def ask(self, *given: Any) -> Any:
        self.asked += 1
        return self._answer(self.asked)


def test_a_reading_is_made_and_told_at_its_rate_on_turns_that_come_often() -> None:
    desk = CountingDesk()

    async def main() -> list[str]:
        told = ToldReading(SharedReading(cast(Desk, desk), LOCAL, "status"), 7, rate_Hz=2.0)
        start_s = 1 + int(asyncio.get_running_loop().time())  # turns before the reading is free again
        found = []
        for turn in range(round(3 / TAKEN_S)):
            if message := told.next_message(start_s + turn * TAKEN_S):
                found.append(b"".join(message.parts).decode())
            for _ in range(3):
                await asyncio.sleep(0)
        return found

    assert asyncio.run(main()) == [f'{{"watch":7,"value":{number}}}' for number in range(1, 7)]
    assert desk.asked == 6
