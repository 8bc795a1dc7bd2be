"""Long work beside the loop: it ends with whoever waits for it."""

import asyncio
import threading
from itertools import count

import pytest

from hil.live.off_loop import AT_ONCE, SHORT, off_loop


def threads() -> list[threading.Thread]:
    return [each for each in threading.enumerate() if each.name == "off-loop"]


async def none_left() -> None:
    async with asyncio.timeout(60):
        while threads():
            await asyncio.sleep(0.001)


def test_what_is_short_is_done_at_once() -> None:
    here = asyncio.run(off_loop("a", threading.current_thread))
    assert here is threading.current_thread()


def test_work_has_a_result_or_an_error() -> None:
    text = "a" * (SHORT + 1)

    async def main() -> None:
        assert await off_loop(text, len, text) == SHORT + 1
        with pytest.raises(ValueError, match="invalid literal"):
            await off_loop(text, int, text)
        await none_left()

    asyncio.run(main())


def test_work_ends_with_its_asker_whether_or_not_it_has_begun() -> None:
    text = "a" * (SHORT + 1)
    counters = [count() for _ in range(AT_ONCE + 3)]

    def endless(number: int) -> None:
        for _ in counters[number]:
            pass

    async def main() -> None:
        many = [asyncio.ensure_future(off_loop(text, endless, number)) for number in range(len(counters))]
        async with asyncio.timeout(60):
            while len(threads()) < AT_ONCE:
                await asyncio.sleep(0.001)
        for each in many:
            each.cancel()
        await asyncio.gather(*many, return_exceptions=True)
        await none_left()
        assert await off_loop(text, len, text) == SHORT + 1

    asyncio.run(main())
    assert sum(next(each) > 0 for each in counters) <= AT_ONCE
