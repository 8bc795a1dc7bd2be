"""Cost of the page in Chromium with 32 moving axes at 60 Hz, and what it costs the daemon.

Two equal daemons run side by side, and one of them has the page. Differences between the two at the same time
are the page's: the daemon's CPU time, the core's wakes. A still page in the same Chromium at the same time is
the reference of the frames. Figures of the page are from Chromium's performance API; its CPU time is that of
its process.

Chromium draws without a graphics processor here: what draws is counted apart.
"""

import asyncio
import os
import shutil
import signal
import statistics
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import AsyncExitStack, ExitStack, contextmanager
from importlib.util import find_spec
from typing import Any, NamedTuple

import web_door
from _processes import Daemon, cpu_s, daemon, have, precise_cpu_s
from _report import is_quick, report

from hil.net.control_client import ask

AXES = web_door.AXES
SECONDS = 5 if is_quick() else 15
ROUNDS = 1 if is_quick() else 5
START_S = 6.0
"""Time that a board takes to start, with some to spare."""
GONE_S = 12.0
"""Time after which a page that does not read has lost its connection, with some to spare."""
MOVING = (("enable", {}), ("velocity", {"velocity_rpm": 60}))
FIRST_VIEW = """
const look = () => {
  const cards = document.querySelectorAll(".reading");
  const areAll = cards.length && [...cards].every((each) => /\\d/.test(each.textContent));
  if (areAll) performance.mark("first-view");
  else requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""
FRAMES = """(milliseconds) => new Promise((done) => {
  const times = [];
  const frame = (at) => {
    times.push(at);
    if (at - times[0] < milliseconds) requestAnimationFrame(frame);
    else done(times.slice(1).map((each, index) => each - times[index]));
  };
  requestAnimationFrame(frame);
})"""
SIZES = """() => [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
  .reduce((sum, each) => sum + each.encodedBodySize, 0)"""


class Side(NamedTuple):
    """Figures of one daemon: share of a core, wakes missed in a second, part of the wakes that came later
    than 0.13 ms."""

    share: float
    missed_per_s: float
    late: float


class Round(NamedTuple):
    """One measurement: the daemon with the page and that without, shares of a core, frames in ms."""

    watched: Side
    alone: Side
    page: float
    drawing: float
    frames_ms: list[float]
    still_ms: list[float]


def status(running: Daemon) -> dict[str, Any]:
    told: dict[str, Any] = ask(next(running.folder.glob("run/*/control.sock")), "status")
    return told


def url(running: Daemon) -> str:
    root: str = status(running)["bridges"]["web"]["root"]
    return root


def move(running: Daemon) -> None:
    """Let all axes turn."""
    socket = next(running.folder.glob("run/*/control.sock"))
    for axis in range(AXES):
        for name, given in MOVING:
            ask(socket, "do", device=f"m{axis}", name=name, parameters=given)


class Gauge:
    """Measures a daemon from now on."""

    def __init__(self, running: Daemon) -> None:
        self._running = running
        self._before, self._cpu_s, self._at_s = status(running), precise_cpu_s(running.pid), time.monotonic()

    def read(self) -> Side:
        passed_s = time.monotonic() - self._at_s
        share = (precise_cpu_s(self._running.pid) - self._cpu_s) / passed_s
        now = status(self._running)
        wakes = [b - a for a, b in zip(self._before["wake_latency"], now["wake_latency"], strict=True)]
        late = sum(wakes[18:]) / max(sum(wakes), 1)  # the bounds are powers of two, in ns
        return Side(share, (now["missed"] - self._before["missed"]) / passed_s, late)


def cpu_of(browser: Any, kind: str) -> dict[int, float]:
    """CPU time of Chromium's processes of a kind so far."""
    told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    return {each["id"]: cpu_s(each["id"]) for each in told["processInfo"] if each["type"] == kind}


def wait(page: Any, condition: str) -> None:
    """Wait for a condition in the page, whose policy forbids Playwright's own way."""
    deadline = time.monotonic() + 30
    while not page.evaluate(condition):
        if time.monotonic() > deadline:
            raise TimeoutError(condition)
        time.sleep(0.02)


def opened(browser: Any, address: str) -> Any:
    """A page in a profile of its own, with numbers of all axes."""
    page = browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()
    page.add_init_script(FIRST_VIEW)
    page.goto(address)
    wait(page, "performance.getEntriesByName('first-view').length > 0")
    return page


def busiest(browser: Any) -> int:
    """Process of the page that moves: others are still or kept in reserve."""
    before = cpu_of(browser, "renderer")
    time.sleep(2)
    spent_s = {pid: cpu_s - before.get(pid, 0.0) for pid, cpu_s in cpu_of(browser, "renderer").items()}
    return max(spent_s, key=spent_s.__getitem__)


def measured(browser: Any, watched: Daemon, alone: Daemon, still: Any) -> Round:
    page = opened(browser, f"{url(watched)}#/bench")
    process, (drawer,) = busiest(browser), cpu_of(browser, "GPU")
    gauges = Gauge(watched), Gauge(alone)
    page_s, drawing_s, at_s = cpu_s(process), cpu_s(drawer), time.monotonic()
    still.evaluate(f"(time_ms) => {{ window.frames_ms = ({FRAMES})(time_ms); }}", 1000 * SECONDS)
    frames_ms = page.evaluate(FRAMES, 1000 * SECONDS)
    passed_s = time.monotonic() - at_s
    shares = [(cpu_s(pid) - before) / passed_s for pid, before in ((process, page_s), (drawer, drawing_s))]
    sides = [each.read() for each in gauges]
    still_ms = still.evaluate("window.frames_ms")
    page.context.close()
    return Round(sides[0], sides[1], shares[0], shares[1], frames_ms, still_ms)


class Reader(threading.Thread):
    """A bare client that watches all axes in a thread of its own, and counts what it gets."""

    def __init__(self, address: str) -> None:
        super().__init__()
        self._address, self._end = address, threading.Event()
        self.rows_per_s = 0.0

    def run(self) -> None:
        asyncio.run(self._read())

    async def _read(self) -> None:
        async with AsyncExitStack() as stack:
            page = await web_door.page(stack, self._address)
            await page.watch([f"m{axis}" for axis in range(AXES)])
            reading = asyncio.create_task(page.read())
            await asyncio.sleep(1)
            rows, at_s = page.rows, time.monotonic()
            while not self._end.is_set():
                await asyncio.sleep(0.05)
            self.rows_per_s = (page.rows - rows) / (time.monotonic() - at_s)
            reading.cancel()

    def end(self) -> None:
        self._end.set()
        self.join()


def stopped(browser: Any, watched: Daemon, alone: Daemon) -> tuple[float, float, float]:
    """A tab is stopped: points of a core that it still costs the daemon, samples a second that another page
    gets, and how long the tab takes to come back."""
    page = opened(browser, f"{url(watched)}#/bench")
    process = busiest(browser)
    os.kill(process, signal.SIGSTOP)
    try:
        time.sleep(GONE_S)
        gauges = Gauge(watched), Gauge(alone)
        time.sleep(SECONDS)
        there, beside = (each.read() for each in gauges)
        reader = Reader(url(watched))
        reader.start()
        time.sleep(SECONDS)
        reader.end()
    finally:
        os.kill(process, signal.SIGCONT)
    at_s = time.monotonic()
    page.get_by_role("status", name="Connection: connected").wait_for(timeout=30_000)
    wait(
        page,
        f"document.querySelector('.reading').textContent !== {page.locator('.reading').first.inner_text()!r}",
    )
    back_s = time.monotonic() - at_s
    page.context.close()
    return 100 * (there.share - beside.share), reader.rows_per_s, back_s


def first_view(browser: Any, address: str) -> tuple[float, float]:
    """Time from the address to numbers of all axes in ms, and the page's size as it came, in kB."""
    page = opened(browser, address)
    at_ms = page.evaluate("performance.getEntriesByName('first-view')[0].startTime")
    size = page.evaluate(SIZES)
    page.context.close()
    return at_ms, size / 1000


def percentile(values: Sequence[float], part: float) -> float:
    return sorted(values)[min(int(len(values) * part), len(values) - 1)]


@contextmanager
def moving_daemons() -> Iterator[tuple[Daemon, Daemon]]:
    with ExitStack() as stack:
        pair = [stack.enter_context(daemon(web_door.CONFIG + web_door.DOOR)) for _ in range(2)]
        time.sleep(START_S)
        for each in pair:
            move(each)
        yield pair[0], pair[1]


def main() -> None:
    if not have("chromium", "chromium"):
        return
    if not find_spec("playwright"):
        print("skipped: needs playwright: pip install playwright", flush=True)
        return
    from playwright.sync_api import sync_playwright

    arguments = ["--no-sandbox"] if os.getuid() == 0 else []
    with moving_daemons() as (first, second), sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=arguments)
        still = browser.new_context().new_page()
        views = [first_view(browser, f"{url(first)}#/bench") for _ in range(2 * ROUNDS + 1)]
        rounds = [
            measured(browser, *((first, second) if number % 2 == 0 else (second, first)), still)
            for number in range(ROUNDS)
        ]
        points, rows_per_s, back_s = stopped(browser, first, second)
        browser.close()
    tell(rounds, views)
    print(
        f"a stopped tab: {points:.1f} points more, {rows_per_s / AXES:.1f} samples/s of each axis to"
        f" another page, back after {back_s:.1f} s"
    )


def tell(rounds: Sequence[Round], views: Sequence[tuple[float, float]]) -> None:
    middle = statistics.median
    p99_ms = middle(percentile(each.frames_ms, 0.99) for each in rounds)
    still_ms = middle(percentile(each.still_ms, 0.99) for each in rounds)
    per_s = middle(1000 * len(each.frames_ms) / sum(each.frames_ms) for each in rounds)
    for name, sides in (
        ("with the page", [each.watched for each in rounds]),
        ("without", [each.alone for each in rounds]),
    ):
        print(
            f"{name}: {100 * middle(s.share for s in sides):.1f} % of a core,"
            f" {middle(s.missed_per_s for s in sides):.1f} wakes missed a second,"
            f" {100 * middle(s.late for s in sides):.2f} % later than 0.13 ms"
        )
    print(f"{per_s:.1f} frames/s; drawing {100 * middle(each.drawing for each in rounds):.0f} % of a core")
    extra: dict[str, object] = {"reference": "what is wanted at most"}
    points = [100 * (each.watched.share - each.alone.share) for each in rounds]
    report("web_page_daemon", middle(points), "points of a core", 10.0, 1.0, extra | {"all": points})
    pages = [100 * each.page for each in rounds]
    report("web_page_cpu", middle(pages), "% of a core", 50.0, 1.0, extra | {"all": pages})
    frames = extra | {"still page": still_ms, "all": [percentile(each.frames_ms, 0.99) for each in rounds]}
    print(f"p99 of the frames of a still page beside it: {still_ms:.1f} ms")
    report("web_page_frame_p99", p99_ms, "ms", 50.0, 1.0, frames)
    times_ms = [at_ms for at_ms, _ in views]
    report("web_page_first_view", middle(times_ms), "ms", 1000.0, 1.0, extra | {"all": times_ms})
    report("web_page_size", views[0][1], "kB", 400.0, 1.0, extra)


if __name__ == "__main__":
    main()
