"""A motor that stalls, as the events of a daemon tell it."""

import asyncio
from pathlib import Path

import pytest
from desk_support import OPERATOR, VIEWER, Asking, Using, desk_in


@pytest.fixture
def using(tmp_path: Path) -> Using:
    """Runs what is awaited with the desk of a daemon that has started."""
    return desk_in(tmp_path)


def test_a_stall_is_an_event_at_its_time(using: Using) -> None:
    """The default motor of a SAC does not follow 2,400 rpm; who looks on has the time of the stall itself."""

    async def use(ask: Asking) -> None:
        await ask.until_ready("s10")
        await ask("type", "s10", source=OPERATOR, text="m9000v2400a1\r")

        found = list[dict[str, object]]()
        async with asyncio.timeout(60):
            while not found:
                await asyncio.sleep(0.05)
                events = (await ask("events", source=VIEWER))["events"]
                found = [each for each in events if each["kind"] == "motors"]
        (event,) = found
        shot = ask.serving.live.sim.snapshot("s10")
        assert event["at_ns"] == shot.stalled_at_ns > 0
        assert event["of"] == "s10"
        assert str(event["text"]).startswith("it lost steps once, at ")

    using(use)
