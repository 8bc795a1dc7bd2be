"""Cost of the page in Chromium: 64 cards of moving axes, and the plots of one; what it costs the daemon.

Two equal daemons run side by side, and one of them has the page. Differences between the two at the same time
are the page's: the daemon's CPU time, the core's wakes. A still page in the same Chromium at the same time is
the reference of the frames. Figures of the page are from Chromium's performance API.

CPU time of the page is that of all processes of its Chromium, which draws without a graphics processor here;
that of an empty page is told beside it. Frames are counted after it: who counts asks for 60 a second, where
the page itself asks for those alone in which it draws.
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

AXES = 64
PLACES = {"cards": "bench", "plots": "bench/m0"}
"""Pages that are measured, and their places."""
MOST = {"cards": 35.0, "plots": 30.0, "first_view_ms": 800.0, "frame_p99_ms": 34.0, "size_kB": 150.0}
"""Most that is wanted: % of a core for the two pages."""
SECONDS = 5 if is_quick() else 15
ROUNDS = 1 if is_quick() else 5
START_S = 6.0
"""Time that a board takes to start, with some to spare."""
AHEAD_S = 6.0
"""Time in which a page has loaded its other views ahead, with some to spare."""
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


def cpu_of(browser: Any) -> float:
    """CPU time of all of Chromium's processes so far."""
    told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    return sum(cpu_s(each["id"]) for each in told["processInfo"])


def renderers(browser: Any) -> dict[int, float]:
    """CPU time of each page's process so far."""
    told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
    return {each["id"]: cpu_s(each["id"]) for each in told["processInfo"] if each["type"] == "renderer"}


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
    before = renderers(browser)
    time.sleep(2)
    spent_s = {pid: cpu_s - before.get(pid, 0.0) for pid, cpu_s in renderers(browser).items()}
    return max(spent_s, key=spent_s.__getitem__)


def measured(browser: Any, place: str, watched: Daemon, alone: Daemon, still: Any) -> Round:
    page = opened(browser, f"{url(watched)}#/bench")
    if place != PLACES["cards"]:
        page.goto(f"{url(watched)}#/{place}")
        wait(page, "document.querySelectorAll('.pane-plot canvas').length > 0")
    time.sleep(AHEAD_S)
    gauges = Gauge(watched), Gauge(alone)
    share = cpu_share(browser)
    sides = [each.read() for each in gauges]
    still.evaluate(f"(time_ms) => {{ window.frames_ms = ({FRAMES})(time_ms); }}", 1000 * SECONDS)
    frames_ms = page.evaluate(FRAMES, 1000 * SECONDS)
    still_ms = still.evaluate("window.frames_ms")
    page.context.close()
    return Round(sides[0], sides[1], share, frames_ms, still_ms)


def cpu_share(browser: Any) -> float:
    """Share of a core that all of Chromium's processes take, over the usual time."""
    before_s, at_s = cpu_of(browser), time.monotonic()
    time.sleep(SECONDS)
    return (cpu_of(browser) - before_s) / (time.monotonic() - at_s)


def empty(browser: Any) -> float:
    """Share of a core that Chromium takes with pages that are still."""
    page = browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()
    share = cpu_share(browser)
    page.context.close()
    return share


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
        pair = [stack.enter_context(daemon(web_door.config_of(AXES) + web_door.DOOR)) for _ in range(2)]
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
        pairs = [(first, second) if number % 2 == 0 else (second, first) for number in range(ROUNDS)]
        blank = statistics.median(empty(browser) for _ in pairs)
        rounds = {
            name: [measured(browser, place, *pair, still) for pair in pairs] for name, place in PLACES.items()
        }
        points, rows_per_s, back_s = stopped(browser, first, second)
        browser.close()
    print(f"an empty page: {100 * blank:.0f} % of a core")
    for name, of_it in rounds.items():
        tell(name, of_it)
    extra = {"reference": "what is wanted at most"}
    times_ms = [at_ms for at_ms, _ in views]
    middle_ms = statistics.median(times_ms)
    report("web_page_first_view", middle_ms, "ms", MOST["first_view_ms"], 1.0, extra | {"all": times_ms})
    report("web_page_size", views[0][1], "kB", MOST["size_kB"], 1.0, extra)
    print(
        f"a stopped tab: {points:.1f} points more, {rows_per_s / AXES:.1f} samples/s of each axis to"
        f" another page, back after {back_s:.1f} s"
    )


def tell(name: str, rounds: Sequence[Round]) -> None:
    middle = statistics.median
    p99_ms = middle(percentile(each.frames_ms, 0.99) for each in rounds)
    still_ms = middle(percentile(each.still_ms, 0.99) for each in rounds)
    per_s = middle(1000 * len(each.frames_ms) / sum(each.frames_ms) for each in rounds)
    for which, sides in (
        ("with the page", [each.watched for each in rounds]),
        ("without", [each.alone for each in rounds]),
    ):
        print(
            f"{name}, {which}: {100 * middle(s.share for s in sides):.1f} % of a core,"
            f" {middle(s.missed_per_s for s in sides):.1f} wakes missed a second,"
            f" {100 * middle(s.late for s in sides):.2f} % later than 0.13 ms"
        )
    extra: dict[str, object] = {"reference": "what is wanted at most"}
    points = [100 * (each.watched.share - each.alone.share) for each in rounds]
    print(f"{name}: {middle(points):.1f} points of the daemon, {per_s:.1f} frames/s")
    pages = [100 * each.page for each in rounds]
    report(f"web_page_{name}", middle(pages), "% of a core", MOST[name], 1.0, extra | {"all": pages})
    frames = extra | {"still page": still_ms, "all": [percentile(each.frames_ms, 0.99) for each in rounds]}
    print(f"{name}: p99 of the frames of a still page beside it: {still_ms:.1f} ms")
    report(f"web_page_{name}_frame_p99", p99_ms, "ms", MOST["frame_p99_ms"], 1.0, frames)


if __name__ == "__main__":
    main()
