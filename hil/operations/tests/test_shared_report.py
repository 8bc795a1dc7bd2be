"""Reports that are made in pieces, once for all who ask meanwhile."""

import asyncio
import json
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hil.host.real_time import Grant
from hil.live.places import Places
from hil.live.run_recording import RunRecording
from hil.operations.health import Health
from hil.operations.reports import Reports, SharedReport
from hil.vocab.monitoring import HealthProblem
from hil.wire.json_text import ITEMS, json_pieces


def test_pieces_are_the_whole() -> None:
    for content in (
        {},
        {"a": 1},
        {"rows": list(range(3 * ITEMS + 1)), "few": [1, 2], "none": []},
        {"nan": [math.nan] * (ITEMS + 1), 'quo"te': math.inf},
        [1, 2, 3],
    ):
        told = json.loads(b"".join(json_pieces(content)))
        assert told == json.loads(json.dumps(content).replace("NaN", "null").replace("Infinity", "null"))


def test_items_of_an_iterator_are_encoded_one_by_one() -> None:
    for rows in ([], [1], [{"a": [1, 2]}, math.nan, "x"]):
        told = b"".join(json_pieces({"rows": iter(rows), "more": 1}))
        assert told == b"".join(json_pieces({"rows": rows, "more": 1}))


def test_each_asker_gets_a_report_that_was_begun_after_the_question() -> None:
    begun = 0

    def made() -> Iterator[Any]:
        nonlocal begun
        begun += 1
        number = begun
        for _ in range(5):
            yield None
        yield {"number": number}

    async def ask(report: SharedReport) -> int:
        encoded = await report.read()
        return int(json.loads(b"".join(encoded.parts))["number"])

    async def main() -> None:
        report = SharedReport(made)
        assert await asyncio.gather(*(ask(report) for _ in range(50))) == [1] * 50
        first = asyncio.ensure_future(ask(report))
        await asyncio.sleep(0)
        first.cancel()  # others still get theirs
        assert await ask(report) == 2

    asyncio.run(main())
    assert begun == 2


def test_a_report_of_a_thousand_rows_leaves_turns_to_others() -> None:
    """Turns of the loop are counted in rows, not in time, which depends on the machine's load."""
    rows, now_s = 1000, [0.0]
    begun = 0

    def made() -> Iterator[Any]:
        nonlocal begun
        begun += 1
        for _ in range(rows):
            now_s[0] += 0.0005
            yield None
        yield {"devices": [{"device": f"m{n}", "axes": []} for n in range(rows)]}

    async def main() -> None:
        loop, turns = asyncio.get_running_loop(), list[float]()
        loop.time = lambda: now_s[0]  # type: ignore[method-assign]
        report = SharedReport(made)
        askers = [loop.create_task(report.read()) for _ in range(20)]
        while not all(asker.done() for asker in askers):
            turns.append(now_s[0])
            await asyncio.sleep(0)
        assert len({id(asker.result()) for asker in askers}) == 1
        steps = [after - before for before, after in pairwise(turns)]
        assert max(steps) <= 0.005
        assert len(json.loads(b"".join(askers[0].result().parts))["devices"]) == rows

    asyncio.run(main())
    assert begun == 1


class SlowDevice:
    """Device that has failed, each look at which takes half a millisecond of a simulated clock."""

    def __init__(self, name: str, now_s: list[float]) -> None:
        self.name, self._now_s = name, now_s

    def _look(self) -> None:
        self._now_s[0] += 0.0005

    def listed(self, kinds: Any) -> dict[str, Any]:
        self._look()
        return {"axes": [self.name]}

    def status(self) -> dict[str, Any]:
        self._look()
        return {"note": None}

    def problems(self, is_service: bool) -> Iterator[HealthProblem]:
        self._look()
        yield HealthProblem("port", self.name, "away", "wait")
        yield HealthProblem("device", self.name, "stopped", "reset it")

    def echoes(self) -> Iterator[Any]:
        self._look()
        echo = SimpleNamespace(state="there", as_dict=lambda: {"state": "there"})
        yield self.name, echo


def bench_of(devices: dict[str, Any]) -> Reports:
    rt = dict.fromkeys(("elapsed_ns", "ticks", "missed", "overruns"), 0) | {"wake_latency": []}
    sim: Any = SimpleNamespace(
        core=SimpleNamespace(native=SimpleNamespace(rt_stats=lambda: rt)),
        **{
            "devices": {},
            "wires": {},
            "cards": {},
            "segments": {},
            "now_ns": 0,
            "real_time": SimpleNamespace(lag=[], is_held=False),
        },
    )
    config = SimpleNamespace(profile="p", hardware=None, port=None, ports_by_uart=dict)
    configured: Any = SimpleNamespace(
        config=SimpleNamespace(
            **{"bench": "t", "devices": dict.fromkeys(devices, config), "tap_ports": dict},
            **{"rate_hz": 1000, "speed": 1.0, "switches": {}},
        ),
        catalogue=SimpleNamespace(profiles={"p": SimpleNamespace(greeting="")}, wire_infos={}),
    )
    commits: Any = SimpleNamespace(failures={})
    vitals: Any = SimpleNamespace(missed_share=0.0, loop_worst_ns=0)
    nothing: Any = SimpleNamespace(listed=list, under_way=list)
    known: Any = devices
    grant, places = Grant(80, 1, {}), Places()
    health = Health(sim, known, places, commits, vitals, grant, Path(), False, {})
    return Reports(sim, configured, places, known, nothing, {}, grant, health, nothing, RunRecording())


@pytest.mark.parametrize("is_reloaded", [False, True])
def test_a_status_of_a_thousand_devices_leaves_turns_to_others(is_reloaded: bool) -> None:
    """Turns are counted in looks at devices. A reload takes some away meanwhile."""
    now_s, rows = [0.0], 1000
    devices = {f"m{n}": SlowDevice(f"m{n}", now_s) for n in range(rows)}
    reports, turns = bench_of(devices), list[float]()

    async def read() -> dict[str, Any]:
        loop = asyncio.get_running_loop()
        loop.time = lambda: now_s[0]  # type: ignore[method-assign]
        asked = loop.create_task(SharedReport(reports.status).read())
        while not asked.done():
            turns.append(now_s[0])
            if is_reloaded and len(turns) % 5 == 0:
                devices.popitem()
            await asyncio.sleep(0)
        told: dict[str, Any] = json.loads(b"".join(asked.result().parts))
        return told

    told = asyncio.run(read())
    assert max(after - before for before, after in pairwise(turns)) <= 0.005
    if not is_reloaded:
        names = list(devices)
        assert [row["device"] for row in told["devices"]] == list(told["echoes"]) == names
        problems = told["health"]["problems"]
        assert [problem["about"] for problem in problems] == 2 * names
        assert [problem["kind"] for problem in problems] == rows * ["device"] + rows * ["port"]
        assert problems[0] == {"kind": "device", "about": "m0", "what": "stopped", "remedy": "reset it"}
