"""Cost of a page for the daemon: CPU time with pages open above nobody watching, and the core's wakes.

1. 32 axes at 60 Hz, five fields of each, and the status, to one page. Wanted: at most 10 points above nobody.
2. The same with a page beside it that does not read: no more than a page that reads.
3. 50 pages, each with one axis at 60 Hz: all get their samples.
"""

import asyncio
import statistics
import sys
import time
from collections.abc import Sequence
from contextlib import AsyncExitStack
from typing import Any

import aiohttp
from _processes import Daemon, daemon, precise_cpu_s
from _report import is_quick, report

from hil.net.control_client import ask

AXES, RATE_HZ, PAGES = 32, 60.0, 50
FIELDS = ["position_deg", "velocity_rpm", "u", "r", "yw"]
SECONDS = 4 if is_quick() else 15
ROUNDS = 1 if is_quick() else 3
CONFIG = "bench: bench\ndevices:\n" + "".join(
    f"  m{number}: {{profile: mechaduino, flash: {{table: identity}}}}\n" for number in range(AXES)
)
DOOR = "bridges: {web: {port: 0}}\n"


class Page:
    """A page that watches, and counts what it gets."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self.rows = self.bytes = self.messages = 0

    async def watch(self, axes: Sequence[str]) -> None:
        await self._socket.send_json({"id": 999, "do": "watch", "what": "status", "rate_Hz": 4})
        for number, axis in enumerate(axes):
            await self._socket.send_json(
                {
                    **{"id": number, "do": "watch", "what": "samples", "target": axis},
                    **{"fields": FIELDS, "rate_Hz": RATE_HZ},
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


async def shares(running: Daemon, pages: int, axes: int, *, deaf: int = 0) -> tuple[float, float]:
    """Share of a core that the daemon takes, and rows a second that each page gets."""
    status = ask(next(running.folder.glob("run/*/control.sock")), "status")
    url = status["bridges"]["web"]["root"]
    async with AsyncExitStack() as stack:
        open_pages = [await page(stack, url) for _ in range(pages + deaf)]
        for number, each in enumerate(open_pages):
            await each.watch([f"m{(number + axis) % AXES}" for axis in range(axes)])
        readers = [asyncio.create_task(each.read()) for each in open_pages[:pages]]
        await asyncio.sleep(1)
        before_rows = sum(each.rows for each in open_pages)
        spent_s, began_s = precise_cpu_s(running.pid), time.monotonic()
        await asyncio.sleep(SECONDS)
        passed_s = time.monotonic() - began_s
        share = (precise_cpu_s(running.pid) - spent_s) / passed_s
        rows_per_s = (sum(each.rows for each in open_pages) - before_rows) / passed_s
        for reader in readers:
            reader.cancel()
    return share, rows_per_s / max(pages, 1)


def wakes(running: Daemon) -> dict[str, Any]:
    status = ask(next(running.folder.glob("run/*/control.sock")), "status")
    return {name: status[name] for name in ("ticks", "missed", "overruns")}


def main() -> None:
    with daemon(CONFIG + DOOR) as running:
        time.sleep(6)  # the boards' start
        found: dict[str, list[float]] = {"nobody": [], "page": [], "deaf": [], "many": []}
        rows = 0.0
        before = wakes(running)
        for _ in range(ROUNDS):
            found["nobody"].append(asyncio.run(shares(running, 0, 0))[0])
            share, rows = asyncio.run(shares(running, 1, AXES))
            found["page"].append(share)
            found["deaf"].append(asyncio.run(shares(running, 1, AXES, deaf=1))[0])
            share, of_many = asyncio.run(shares(running, PAGES, 1))
            found["many"].append(share)
        after = wakes(running)
    middle = {name: statistics.median(each) for name, each in found.items()}
    points = {name: 100 * (share - middle["nobody"]) for name, share in middle.items()}
    print(f"nobody watches: {100 * middle['nobody']:.1f} % of a core")
    print(f"{AXES} axes at {RATE_HZ:g} Hz to one page: {points['page']:.1f} points more (wanted at most 10),"
          f" {rows:.0f} samples/s")  # fmt: skip
    print(f"with a page beside it that does not read: {points['deaf']:.1f} points")
    print(f"{PAGES} pages with an axis each: {points['many']:.1f} points, {of_many:.1f} samples/s each")
    print(
        f"wakes of the core: {after['ticks'] - before['ticks']}, missed {after['missed'] - before['missed']}"
    )
    report("web_door", points["page"], "points of a core", 10.0, 1.0,
           {"reference": "what is wanted at most", "points": points, "samples_per_s": rows})  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
