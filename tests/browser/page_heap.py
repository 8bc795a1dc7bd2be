"""Measures the page's heap over eight hours: `.venv/bin/python -m pytest -s tests/browser/page_heap.py`.

It is no test of `make test-web`, and its name keeps it out of them: the bench runs sixteen times as fast as
real time, which takes half an hour.
"""

import time

from browser_pages import Bench, served
from e2e_support import READY_NS
from playwright.sync_api import Browser, Page

SPEED, HOURS = 16, 8
PLACES = ("bench", "bench/m0", "wire/bus0", "events")
"""Pages that stay open."""
FIRST_SHARE = 0.1
"""Share of the time in which a page may fill what it keeps."""
MOST_GROWTH_MB = 5.0


def heap_MB(page: Page) -> float:
    """Heap of a page after a collection."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.enable")
    for _ in range(2):
        session.send("HeapProfiler.collectGarbage")
    used: float = session.send("Runtime.getHeapUsage")["usedSize"] / 1e6
    session.detach()
    return used


def _do(bench: Bench, name: str, **parameters: float) -> None:
    for device in ("m0", "m1"):
        bench.server.ask("do", device=device, name=name, parameters=parameters)


def test_the_heap_stays(chromium: Browser) -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    sac = {"profile": "sac", "flash": {}}
    devices = {**{f"m{number}": servo for number in range(4)}, **{f"s{number}": sac for number in range(2)}}
    segment = {"stations": ["s0", "s1"]}
    content = {"bench": "heap", "speed": SPEED, "devices": devices, "segments": {"bus0": segment}}
    with served(chromium, content) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        _do(bench, "enable")
        pages = {where: bench.open(where) for where in PLACES}
        rows: list[dict[str, float]] = []
        began_s, most_s = time.monotonic(), HOURS * 3600 / SPEED
        while (passed_s := time.monotonic() - began_s) < most_s:
            if passed_s >= most_s * len(rows) / 20:
                rows.append({where: heap_MB(page) for where, page in pages.items()})
                figures = "  ".join(f"{where} {heap:.2f}" for where, heap in rows[-1].items())
                print(f"{passed_s * SPEED / 3600:5.2f} h: {figures} MB", flush=True)
            for velocity_rpm in (60.0, -60.0):  # each is an event, too
                _do(bench, "velocity", velocity_rpm=velocity_rpm)
                pages["bench"].wait_for_timeout(500)
    filled = rows[round(len(rows) * FIRST_SHARE)]
    growth_MB = {where: rows[-1][where] - filled[where] for where in PLACES}
    print(f"growth from then: {growth_MB}")
    assert max(growth_MB.values()) <= MOST_GROWTH_MB
