"""Reports that are made in pieces, once for all who ask meanwhile."""

import asyncio
import json
import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from hil.operations.reports import SharedReport
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
