"""The event loop of doors in memory."""

import asyncio
import gc
import os
from pathlib import Path

import pytest

from hil.memory_desk.door_loop import DoorLoop
from hil.vocab.time import SimTimeNs


def _loop() -> DoorLoop:
    return DoorLoop(lambda: SimTimeNs(0))


def test_a_loop_opens_no_file() -> None:
    def files() -> int:
        return len(os.listdir(Path("/proc/self/fd")))

    before = files()
    loop = _loop()
    assert files() == before
    loop.close()


def test_a_task_that_ends_with_its_bench_is_no_error(caplog: pytest.LogCaptureFixture) -> None:
    loop = _loop()
    loop.create_task(asyncio.Event().wait())
    loop.turn()
    gc.collect()
    loop.close()
    assert caplog.text == ""


def test_an_error_in_a_callback_is_said(caplog: pytest.LogCaptureFixture) -> None:
    def fails() -> None:
        raise ValueError("no such unit")

    loop = _loop()
    loop.call_soon(fails)
    loop.turn()
    loop.close()
    assert "no such unit" in caplog.text
