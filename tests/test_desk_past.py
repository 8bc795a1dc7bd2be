"""The desk of a bench that runs, asked about any time of its run."""

import asyncio
import json
import os
import signal
from pathlib import Path
from typing import Any

from desk_support import CONFIG, VIEWER, Asking, desk_in, refusal

from hil.net.answers import misfit


async def past(ask: Asking, at_least_s: float) -> dict[str, Any]:
    """Overview, when the recording is known up to a time."""
    while True:
        told: dict[str, Any] = await ask("past", source=VIEWER)
        if told["end_ns"] >= at_least_s * 1e9:
            return told
        await asyncio.sleep(0.05)


def test_any_time_of_the_run_can_be_seen(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        await ask.until_ready("m1")
        at_ns = (await ask.verb("m1", "enable")).effective_at_ns
        moved = await ask.verb("m1", "position", position_deg=90.0)
        number = (await ask("inject", "m1", fault="shaft_load", parameters={"torque_Nm": 0.01}))["number"]
        await ask("type", "s1", text="?\r")
        then_s = moved.effective_at_ns / 1e9 + 5
        told = await past(ask, then_s + 5)
        assert misfit("past", told) == ""
        assert told["is_growing"]
        assert told["problem"] == ""
        marks = {(mark["lane"], mark["text"]) for mark in told["marks"]}
        assert {("verbs", "m1 enable"), ("verbs", "m1 position position_deg=90")} <= marks
        assert ("faults", "shaft_load torque_Nm=0.01") in marks

        state = await ask("past_state", source=VIEWER, at_s=then_s)
        assert misfit("past_state", state) == ""
        assert state["axes"]["m1"]["r"] == 90.0
        assert [fault["number"] for fault in state["faults"]] == [number]
        before = await ask("past_state", at_s=at_ns / 1e9 - 0.1)
        assert (before["axes"]["m1"]["loop_on"], before["faults"]) == (0, [])

        samples = await ask("past_samples", fields=["m1.e", "m1.yw"], from_s=then_s - 5, to_s=then_s)
        assert misfit("past_samples", samples) == ""
        assert samples["series"][0]["rows"] > 1000
        heard = await ask("past_bytes", port="s1", at_s=then_s)
        assert misfit("past_bytes", heard) == ""
        assert b"?\r".hex() in [each["hex"] for each in heard["items"] if each["to"] == "board"]
        assert misfit("past_packets", await ask("past_packets", wire="bus0", at_s=then_s)) == ""

        found = await ask("past_find", condition="m1.yw > 45", from_s=0)
        assert misfit("past_find", found) == ""
        assert moved.effective_at_ns < found["found_ns"] < moved.effective_at_ns + 2e9
        back = await ask("past_find", condition="m1.yw > 45", from_s=then_s, back=True)
        assert back["found_ns"] == found["found_ns"]

    desk_in(tmp_path)(use)


def test_what_cannot_be_looked_at_is_refused(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        await past(ask, 1)
        assert "position_deg" in (await refusal(ask("past_samples", fields=["m1.x"], from_s=0, to_s=1)))[1]
        assert (await refusal(ask("past_samples", fields=["m1.e"], from_s=2, to_s=1)))[0] == "bad_parameter"
        assert "s1" in (await refusal(ask("past_bytes", port="s7", at_s=0)))[1]
        assert "bus0" in (await refusal(ask("past_packets", wire="bus7", at_s=0)))[1]
        assert (await refusal(ask("past_state", at_s=-1)))[0] == "bad_parameter"
        assert "m1" in (await refusal(ask("past_find", condition="m7.e > 1", from_s=0)))[1]
        assert (await refusal(ask("past_find", condition="e >", from_s=0)))[0] == "bad_parameter"

    desk_in(tmp_path)(use)


def test_a_run_that_is_not_recorded_says_so(tmp_path: Path) -> None:
    config = json.dumps(json.loads(CONFIG) | {"recordings": {"keep_runs": 0}})

    async def use(ask: Asking) -> None:
        code, why = await refusal(ask("past"))
        assert code == "not_now"
        assert "not recorded" in why

    desk_in(tmp_path, config)(use)


def test_a_process_that_is_killed_is_begun_again(tmp_path: Path) -> None:
    async def use(ask: Asking) -> None:
        await past(ask, 1)
        pid = _process_of(tmp_path)
        asked = asyncio.ensure_future(ask("past_samples", fields=["m1.e"], from_s=0, to_s=1e6))
        await asyncio.sleep(0)
        os.kill(pid, signal.SIGKILL)
        [ended] = await asyncio.gather(asked, return_exceptions=True)
        assert not isinstance(ended, Exception) or "ask again" in str(ended)
        assert (await past(ask, 1))["end_ns"] > 0
        assert _process_of(tmp_path) != pid

    desk_in(tmp_path)(use)


def _process_of(folder: Path) -> int:
    """The first of the processes that look at a recording below a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                line = (entry / "cmdline").read_bytes().decode()
            except OSError:
                continue
            if "hil.lookback" in line and str(folder) in line:
                found.append(int(entry.name))
    return min(found)
