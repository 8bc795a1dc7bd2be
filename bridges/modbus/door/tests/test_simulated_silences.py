"""Silences of a line on a loop whose time is simulated."""

import asyncio

import pytest
from simulated_loop import Simulated

from hil.net.silence_timer import SilenceTimer


def test_a_silence_takes_simulated_time() -> None:
    async def use() -> None:
        loop, at_s = asyncio.get_running_loop(), []
        timer = SilenceTimer(lambda: at_s.append(loop.time()))
        timer.start(8_000_000_000)
        await asyncio.sleep(60)
        assert at_s == [pytest.approx(8)]
        timer.start(1_000_000)
        timer.close()
        await asyncio.sleep(60)
        assert len(at_s) == 1

    with asyncio.Runner(loop_factory=Simulated) as runner:
        runner.run(use())
