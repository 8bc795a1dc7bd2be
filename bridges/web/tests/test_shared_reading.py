"""Readings that pages share, also one that cannot be made."""

import asyncio
import logging
from typing import Any, cast

import pytest

from bridges.web.shared_reading import FAILED_S, SharedReading
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
