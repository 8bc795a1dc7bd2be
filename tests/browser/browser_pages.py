"""Benches that serve pages, and the pages in Chromium.

A test asks for ``chromium`` (``conftest.py``), serves a bench with ``served``, and opens its pages with
``Bench.open``. A bench is served once for a file where its tests leave nothing behind.
"""

import base64
import json
import re
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from e2e_support import Place, Server, config, until
from playwright.sync_api import Browser, BrowserContext, Locator, Page, WebSocketRoute, expect

ROOT = Path(__file__).parents[2]
AXE = ROOT / "web/node_modules/axe-core/axe.min.js"
PATIENCE_MS = 40_000
"""A bound for what takes well under a second on an idle machine."""
PHONE = {"width": 390, "height": 844}
DESK = {"width": 1400, "height": 1000}


class Bench:
    """A served bench, and a browser that opens its pages. Errors of a page fail the test that closes it."""

    def __init__(self, place: Place, text: str, browser: Browser) -> None:
        self.place, self._text, self._browser = place, text, browser
        self.server = self._served()
        self.errors: list[str] = []
        """Exceptions in pages, and what they wrote as errors to their consoles."""
        self._contexts: list[BrowserContext] = []
        self.url = address_of(self.server)

    def serve_again(self) -> None:
        """Serve it again after its daemon has ended; its door has to have a port of its own."""
        self.server = self._served()

    def _served(self) -> Server:
        return self.place.serve(self._text, bench=json.loads(self._text)["bench"])

    def open(
        self, where: str = "", *, prepare: Callable[[Page], object] = lambda page: None, **options: Any
    ) -> Page:
        """Open a page in a profile of its own. ``where``: the place in it, as in ``bench/m1``; ``prepare``:
        called with the page before it is loaded; ``options``: of the profile."""
        context = self._browser.new_context(**{"viewport": DESK, **options})
        context.set_default_timeout(PATIENCE_MS)
        self._contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        prepare(page)
        page.goto(f"{self.url}#/{where}")
        return page

    def close_pages(self) -> None:
        """Close the pages. Raises AssertionError: there were errors in them."""
        for context in self._contexts:
            context.close()
        self._contexts.clear()
        errors, self.errors = self.errors, []
        assert errors == [], errors

    def saved_queue(self) -> bytes:
        """Queue of s1, as ``hil sac save`` writes it."""
        back = self.place.folder / "back.txt"
        where = ("--runtime-dir", str(self.place.runtime))
        self.place.hil("sac", "save", str(back), "--device", "s1", *where)
        return back.read_bytes()


def address_of(server: Server) -> str:
    """Address of a bench's page, as `hil serve` prints it."""
    found = until(lambda: re.search(r"^web: (https?://\S+)", server.output, re.M), "the page's address")
    return found[1]


@contextmanager
def served(chromium: Browser, bench: Mapping[str, Any]) -> Iterator[Bench]:
    """Serve a bench, with a web door if it has none."""
    content = {"bridges": {"web": {"listen": 0}}, **bench}
    with Place() as place:
        made = Bench(place, json.dumps(content), chromium)
        yield made
        made.close_pages()


def companion_bench(chromium: Browser, speed: float, **top: Any) -> Iterator[Bench]:
    """Serve two SACs."""
    devices = {name: {"profile": "sac", "flash": {}} for name in ("s1", "s2")}
    with served(chromium, json.loads(config(speed=speed, devices=devices, **top))) as bench:
        yield bench


Change = Callable[[str | bytes], str | bytes | None]


class Between:
    """What stands between a page and its door: it passes messages on, and does what a test wants with them.

    ``change``: makes of a message of the door what the page gets, None: nothing.
    ``sockets``: of all connections so far.
    """

    def __init__(
        self, page: Page, change: Callable[[str | bytes], str | bytes | None] = lambda said: said
    ) -> None:
        self.sockets: list[WebSocketRoute] = []
        self.change = change
        page.route_web_socket(re.compile("/ws$"), self._opened)

    def _opened(self, socket: WebSocketRoute) -> None:
        self.sockets.append(socket)
        door = socket.connect_to_server()

        def pass_on(said: str | bytes) -> None:
            if (changed := self.change(said)) is not None:
                socket.send(changed)

        door.on_message(pass_on)

    def say(self, said: str | bytes) -> None:
        """Say something to the page as if the door did."""
        self.sockets[-1].send(said)

    def until_connections(self, page: Page, count: int) -> None:
        """Wait until the page has connected so often."""
        deadline_s = time.monotonic() + PATIENCE_MS / 1000
        while len(self.sockets) < count:
            assert time.monotonic() < deadline_s, f"{len(self.sockets)} connections"
            page.wait_for_timeout(50)

    def cut(self) -> None:
        """Cut the connection."""
        self.sockets[-1].close()


_PASTE = """(area, text) => {
  const data = new DataTransfer();
  data.setData("text/plain", text);
  area.dispatchEvent(new ClipboardEvent("paste", {clipboardData: data, bubbles: true, cancelable: true}));
}"""


def editor(page: Page, label: str) -> Locator:
    """The editor of a text."""
    return page.get_by_role("textbox", name=label, exact=True)


def write(page: Page, label: str, text: str) -> None:
    """Put a text in the place of an editor's."""
    area = editor(page, label)
    area.press("ControlOrMeta+a")
    area.press("Delete")
    if text:
        area.evaluate(_PASTE, text)


def shows(page: Page, label: str, text: str) -> None:
    """Wait until an editor has a short text."""
    lines = editor(page, label).locator(".cm-line")
    expect(lines).to_have_text(text.split("\n"))


def in_layout(layout: Mapping[str, object]) -> str:
    """Place in the page that shows a layout, as `Bench.open` takes it."""
    packing = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    packed = packing.compress(json.dumps(layout).encode()) + packing.flush()
    return f"layout/1.{base64.urlsafe_b64encode(packed).decode().rstrip('=')}"


def fits(page: Page, width_px: int) -> None:
    """Wait until nothing is wider than the page: what is drawn follows a new size a moment later.

    Raises TimeoutError of Playwright: something stays wider.
    """
    page.wait_for_function("width => document.documentElement.scrollWidth <= width", arg=width_px)


def violations(page: Page) -> list[str]:
    """What axe-core finds wrong with a page for those who do not see or use a mouse: rules and elements."""
    if not AXE.is_file():
        pytest.skip("axe-core is missing: `npm ci` in web/, or `make test-web` with npm")
    page.evaluate(AXE.read_text())  # not as a script of the page, which its policy forbids
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    return [
        f"{rule['id']}: {node['target']}: {node['failureSummary']}"
        for rule in found["violations"]
        for node in rule["nodes"]
    ]
