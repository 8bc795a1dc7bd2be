"""Timer of a line's silences: when it tells, what stops it, and a loop whose time is simulated."""

import asyncio
import os
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from hil.net import silence_timer
from hil.net.silence_timer import SilenceTimer

ms_NS = 1_000_000
PATIENCE_S = 60.0


class Told:
    """A timer and the times at which it told, by the clock of its loop."""

    def __init__(self) -> None:
        self.at_s: list[float] = []
        self._event = asyncio.Event()
        self.timer = SilenceTimer(self._tell)

    def _tell(self) -> None:
        self.at_s.append(asyncio.get_running_loop().time())
        self._event.set()

    async def once(self, silence_ns: int) -> float:
        """Time in seconds from a start until it is told."""
        self._event.clear()
        began_s = asyncio.get_running_loop().time()
        self.timer.start(silence_ns)
        async with asyncio.timeout(PATIENCE_S):
            await self._event.wait()
        return self.at_s[-1] - began_s


def with_timer(use: Callable[[Told], Awaitable[None]]) -> None:
    async def main() -> None:
        told = Told()
        try:
            await use(told)
        finally:
            told.timer.close()

    asyncio.run(main())


def test_it_tells_once_not_early_and_more_finely_than_the_loop() -> None:
    async def use(told: Told) -> None:
        took_s = [await told.once(1_100_000) for _ in range(50)]
        assert min(took_s) >= 0.0011
        assert min(took_s) < 0.0016  # the loop's timer: 0.002
        await asyncio.sleep(0.01)
        assert len(told.at_s) == 50

    with_timer(use)


def test_a_new_start_puts_it_off() -> None:
    async def use(told: Told) -> None:
        told.timer.start(ms_NS)
        assert await told.once(50 * ms_NS) >= 0.05
        assert len(told.at_s) == 1

    with_timer(use)


def test_bytes_that_came_while_the_loop_stood_still_go_first() -> None:
    async def use(told: Told) -> None:
        loop, (out, into) = asyncio.get_running_loop(), os.pipe()

        def read() -> None:
            os.read(out, 16)
            told.timer.start(ms_NS)

        loop.add_reader(out, read)
        try:
            for is_byte_first in (True, False):
                told.timer.start(ms_NS)
                if is_byte_first:
                    os.write(into, b"x")
                time.sleep(0.005)
                if not is_byte_first:
                    os.write(into, b"x")
                before = len(told.at_s)
                await asyncio.sleep(0.1)
                assert len(told.at_s) == before + 1
        finally:
            loop.remove_reader(out)
            os.close(out)
            os.close(into)

    with_timer(use)


def test_a_closed_timer_is_silent_and_its_file_is_back() -> None:
    async def use(told: Told) -> None:
        told.timer.start(ms_NS)
        time.sleep(0.003)
        before = len(list(Path("/proc/self/fd").iterdir()))
        told.timer.close()
        assert len(list(Path("/proc/self/fd").iterdir())) == before - 1
        await asyncio.sleep(0.01)
        assert told.at_s == []

    with_timer(use)


def test_without_a_file_it_is_the_loops_timer(monkeypatch: pytest.MonkeyPatch) -> None:
    class NoFile:
        def timerfd_create(self, *_: int) -> int:
            return -1

    monkeypatch.setattr(silence_timer, "_libc", NoFile())

    async def use(told: Told) -> None:
        assert await told.once(5 * ms_NS) >= 0.004  # the loop rounds
        assert len(told.at_s) == 1

    with_timer(use)
