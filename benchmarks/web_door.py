"""Cost of a page for the daemon: CPU time with pages open above nobody watching, and the core's wakes.

1. 32 axes at 60 Hz, five fields of each, and the status, to one page. Wanted: at most 10 points above nobody.
2. The same with a page beside it that does not read: no more than a page that reads.
3. 50 pages, each with one axis at 60 Hz: all get their samples.
4. One axis at 1 kHz, and the status. Wanted: at most 3 points.
5. As a page with 32 axes and the plots of one has it: the extremes of 60 intervals a second of each, of 10
   looks, and of 1000 intervals of the one in sight, of 7. Wanted: at most 5 points.
6. The status of 1000 devices to five pages: the longest piece of the event loop, in CPU time. Wanted: at most
   5 ms.
"""

import asyncio
import statistics
import sys
import time
from collections.abc import Sequence
from contextlib import AsyncExitStack
from typing import NamedTuple

import aiohttp
from _processes import Daemon, daemon, precise_cpu_s
from _report import check_work, is_quick, report

from hil.net.control_client import ask

AXES, RATE_HZ, PAGES = 32, 60.0, 50
SIGHT_HZ, SIGHT_POINTS, PLOTS_POINTS = 1000.0, 3.0, 5.0
LOOKS, SIGHT_LOOKS = 10, 7
"""Looks in an interval of which the page gets the extremes."""
STATUS_HZ = 2.0
"""Rate of the status, as the page watches it."""
FIELDS = ["position_deg", "velocity_rpm", "u", "r", "yw"]
SECONDS = 4 if is_quick() else 15
ROUNDS = 1 if is_quick() else 3
DEVICES, WATCHERS, PIECE_MS = 1000, 5, 5.0
PIECE_SECONDS = 4 if is_quick() else 10
START_S = 8
PIECES = """
import asyncio, sys, time
from hil.cli.entry import main

run = asyncio.Handle._run

def timed(handle):
    began_s = time.thread_time()
    run(handle)
    if (took_s := time.thread_time() - began_s) > 0.001:
        print("piece", time.monotonic(), took_s * 1e3, flush=True)

asyncio.Handle._run = timed
sys.argv = sys.argv[1:]
main()
"""
"""Program that runs ``hil`` and prints when a piece of the loop over 1 ms has ended, and its milliseconds."""


def config_of(devices: int) -> str:
    rows = (
        f"  m{number}: {{profile: mechaduino, flash: {{table: identity}}}}\n" for number in range(devices)
    )
    return "bench: bench\ndevices:\n" + "".join(rows)


CONFIG = config_of(AXES)
DOOR = "bridges: {web: {listen: 0}}\n"


class Page:
    """A page that watches, and counts what it gets."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self.rows = self.bytes = self.messages = 0

    async def watch_status(self) -> None:
        await self._socket.send_json({"id": 999, "do": "watch", "what": "status", "rate_Hz": STATUS_HZ})

    async def watch(self, axes: Sequence[str], rate_Hz: float = RATE_HZ, looks: int = 1) -> None:
        for number, axis in enumerate(axes):
            await self._socket.send_json(
                {
                    **{"id": number, "do": "watch", "what": "samples", "target": axis},
                    **{"fields": FIELDS, "rate_Hz": rate_Hz, "points": looks},
                }
            )

    async def read(self) -> None:
        row_bytes = 8 * (1 + len(FIELDS))
        async for message in self._socket:
            if message.type is aiohttp.WSMsgType.BINARY:
                self.messages += 1
                self.bytes += len(message.data)
                at = 0
                while at < len(message.data):
                    rows = int.from_bytes(message.data[at + 12 : at + 16], "little")
                    self.rows += rows
                    at += 16 + rows * row_bytes


async def page(stack: AsyncExitStack, url: str) -> Page:
    session = await stack.enter_async_context(aiohttp.ClientSession())
    socket = await stack.enter_async_context(
        session.ws_connect(f"{url}ws", protocols=("hil.v1",), max_msg_size=0)
    )
    return Page(socket)


class Case(NamedTuple):
    """Pages that read, axes of each, pages that do not read, and how axes are sampled."""

    pages: int
    axes: int
    deaf: int = 0
    rate_Hz: float = RATE_HZ
    looks: int = 1
    has_sight: bool = False
    """True if one axis is sampled at ``SIGHT_HZ``, too."""

    @property
    def rows_per_s(self) -> float:
        """Samples a second that each page should get."""
        of_axis = self.axes * self.rate_Hz * (1 if self.looks == 1 else 2)
        return of_axis + (2 * SIGHT_HZ if self.has_sight else 0)


async def shares(running: Daemon, case: Case) -> tuple[float, float, float]:
    """Share of a core that the daemon takes, rows a second that each page gets, and wakes of the core that
    were missed in a second."""
    status = ask(next(running.folder.glob("run/*/control.sock")), "status")
    url = status["bridges"]["web"]["root"]
    async with AsyncExitStack() as stack:
        open_pages = [await page(stack, url) for _ in range(case.pages + case.deaf)]
        for number, each in enumerate(open_pages):
            await each.watch_status()
            axes = [f"m{(number + axis) % AXES}" for axis in range(case.axes)]
            await each.watch(axes, case.rate_Hz, case.looks)
            if case.has_sight:
                await each.watch(axes[:1], SIGHT_HZ, SIGHT_LOOKS)
        readers = [asyncio.create_task(each.read()) for each in open_pages[: case.pages]]
        await asyncio.sleep(1)
        before_rows = sum(each.rows for each in open_pages)
        before = wakes(running)
        spent_s, began_s = precise_cpu_s(running.pid), time.monotonic()
        await asyncio.sleep(SECONDS)
        passed_s = time.monotonic() - began_s
        share = (precise_cpu_s(running.pid) - spent_s) / passed_s
        missed_per_s = (wakes(running) - before) / passed_s
        rows_per_s = (sum(each.rows for each in open_pages) - before_rows) / passed_s
        for reader in readers:
            reader.cancel()
    return share, rows_per_s / max(case.pages, 1), missed_per_s


def wakes(running: Daemon) -> int:
    """Wakes of the core that were missed so far."""
    missed: int = ask(next(running.folder.glob("run/*/control.sock")), "status")["missed"]
    return missed


async def watch_status(url: str) -> tuple[float, float]:
    """Watch the status with all pages. Answers begin and end of the time in which all do."""
    async with AsyncExitStack() as stack:
        pages = [await page(stack, url) for _ in range(WATCHERS)]
        for each in pages:
            await each.watch_status()
        readers = [asyncio.create_task(each.read()) for each in pages]
        await asyncio.sleep(2)
        began_s = time.monotonic()
        await asyncio.sleep(PIECE_SECONDS)
        for reader in readers:
            reader.cancel()
        return began_s, time.monotonic()


def longest_pieces_ms() -> list[float]:
    """Longest piece of the loop in each run."""
    found = []
    with daemon(config_of(DEVICES) + DOOR, prefix=(sys.executable, "-c", PIECES)) as running:
        time.sleep(START_S)
        url = ask(next(running.folder.glob("run/*/control.sock")), "status", timeout_s=30)["bridges"]["web"][
            "root"
        ]
        for _ in range(ROUNDS):
            began_s, ended_s = asyncio.run(watch_status(url))
            rows = (line.split() for line in running.output.splitlines() if line.startswith("piece "))
            found.append(max(float(row[2]) for row in rows if began_s < float(row[1]) < ended_s))
    return found


CASES = {
    "nobody": Case(0, 0),
    "page": Case(1, AXES),
    "deaf": Case(1, AXES, deaf=1),
    "many": Case(PAGES, 1),
    "sight": Case(1, 1, rate_Hz=SIGHT_HZ),
    "plots": Case(1, AXES, looks=LOOKS, has_sight=True),
}


def main() -> None:
    found: dict[str, list[tuple[float, float, float]]] = {name: [] for name in CASES}
    with daemon(CONFIG + DOOR) as running:
        time.sleep(6)  # the boards' start
        for _ in range(ROUNDS):
            for name, case in CASES.items():
                found[name].append(asyncio.run(shares(running, case)))
    middle = {
        name: [statistics.median(each) for each in zip(*rows, strict=True)] for name, rows in found.items()
    }
    for name, case in CASES.items():
        if case.pages:
            check_work(f"samples a second of a page, {name}", middle[name][1], case.rows_per_s, 0.05)
    points = {name: 100 * (share - middle["nobody"][0]) for name, (share, _, _) in middle.items()}
    print(f"nobody watches: {100 * middle['nobody'][0]:.1f} % of a core")
    for name, about in (
        ("page", f"{AXES} axes at {RATE_HZ:g} Hz to one page"),
        ("deaf", "the same with a page beside it that does not read"),
        ("many", f"{PAGES} pages with an axis each"),
        ("sight", f"one axis at {SIGHT_HZ:g} Hz to one page"),
        ("plots", f"extremes of {AXES} axes, and at {SIGHT_HZ:g} Hz of one, to one page"),
    ):
        print(f"{about}: {points[name]:.1f} points more, {middle[name][1]:.1f} samples/s each")
    print("wakes missed a second:", ", ".join(f"{name} {each[2]:.1f}" for name, each in middle.items()))
    extra: dict[str, object] = {"reference": "what is wanted at most", "points": points}
    report("web_door", points["page"], "points of a core", 10.0, 1.0, extra)
    report("web_door_sight", points["sight"], "points of a core", SIGHT_POINTS, 1.0, extra)
    report("web_door_plots", points["plots"], "points of a core", PLOTS_POINTS, 1.0, extra)
    pieces_ms = longest_pieces_ms()
    extra = {"reference": "what is wanted at most", "all": pieces_ms}
    report("status_piece_1000", statistics.median(pieces_ms), "ms", PIECE_MS, 1.0, extra)


if __name__ == "__main__":
    main()
