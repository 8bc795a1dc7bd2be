"""A driver that is too hot, as events and status of a daemon tell it."""

import asyncio
from pathlib import Path

from desk_support import OPERATOR, VIEWER, Asking, desk_in

CONFIG = """
bench: h
speed: 20
devices:
  m1: {profile: mechaduino, parameters: {iMAX: 2.0}}
faults:
  - {fault: shaft_jam, target: m1}
"""


def test_shutdown_and_return_are_events_at_their_times(tmp_path: Path) -> None:
    """The loop pushes a shaft that is stuck: its driver switches off by its heat, and on again."""

    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        await ask("type", "m1", source=OPERATOR, text="xyr90\n")
        texts = set[str]()
        async with asyncio.timeout(60):
            while len(texts) < 2:
                await asyncio.sleep(0.05)
                events = (await ask("events", source=VIEWER))["events"]
                found = [each for each in events if "driver" in str(each["text"])]
                texts = {"back" if "back since" in each["text"] else each["text"] for each in found}
        assert texts == {"its driver is too hot: no current until it has cooled", "back"}
        assert {(each["of"], each["kind"]) for each in found} == {("m1", "motors")}
        shot = ask.serving.live.sim.snapshot("m1")
        assert all(17e9 < each["at_ns"] <= max(shot.too_hot_at_ns, shot.cooled_at_ns) for each in found)
        assert "its driver " in str(await ask("status", source=VIEWER))

    desk_in(tmp_path, CONFIG)(use)
