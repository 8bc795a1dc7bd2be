"""Signals to the daemon, which are answered also where others have filled the way to the loop."""

import asyncio
import signal

import pytest

from hil.host import signals

MANY = 10_000
"""Number that the socket of an event loop has no room for."""


@pytest.mark.parametrize("bells", [0, MANY])
def test_a_signal_after_many_others_is_answered_once(bells: int) -> None:
    rung = []

    async def main() -> list[str]:
        loop, came, calls = asyncio.get_running_loop(), asyncio.Event(), []
        numbers = {signal.SIGUSR1: lambda: calls.append("one"), signal.SIGUSR2: came.set}
        signals.answer(loop, numbers)
        try:
            for _ in range(bells):  # the loop does not run meanwhile
                signal.raise_signal(signal.SIGVTALRM)
            signal.raise_signal(signal.SIGUSR1)
            signal.raise_signal(signal.SIGUSR2)
            await asyncio.wait_for(came.wait(), 10)
            await asyncio.sleep(0)
        finally:
            signals.ignore(loop, numbers)
        return calls

    before = signal.signal(signal.SIGVTALRM, lambda number, frame: rung.append(number))
    try:
        assert asyncio.run(main()) == ["one"]
    finally:
        signal.signal(signal.SIGVTALRM, before)
    assert len(rung) == bells
    assert signal.getsignal(signal.SIGUSR1) == signal.SIG_DFL
