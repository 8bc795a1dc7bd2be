"""Benches with pages in a headless Chromium, for the companion and the wire."""

import json
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # --import-mode=importlib leaves it out

from e2e_support import Place, Server, config
from playwright.sync_api import Browser, Page, expect, sync_playwright

PATIENCE_MS = 20_000


class Bench:
    """A served bench, and a browser that opens its pages. Errors of a page fail the test."""

    def __init__(self, place: Place, server: Server, browser: Browser) -> None:
        self.place, self.server, self._browser = place, server, browser
        self.errors: list[str] = []
        found = re.search(r"^web: (http://\S+)", server.output, re.M)
        assert found, server.output
        self.url = found[1]

    def open(self, where: str, **options: Any) -> Page:
        """Open a page in a browser context of its own."""
        context = self._browser.new_context(viewport={"width": 1400, "height": 1000}, **options)
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        page.goto(f"{self.url}#/{where}")
        return page

    def saved_queue(self) -> bytes:
        """Queue of s1, as ``hil sac save`` writes it."""
        back = self.place.folder / "back.txt"
        where = ("--runtime-dir", str(self.place.runtime))
        self.place.hil("sac", "save", str(back), "--device", "s1", *where)
        return back.read_bytes()


def companion_bench(speed: float, **top: Any) -> Iterator[Bench]:
    """Serve two SACs on a segment with the web's door."""
    text = config(
        speed=speed, devices={name: {"profile": "sac", "flash": {}} for name in ("s1", "s2")}, **top
    )
    chromium = shutil.which("chromium")
    assert chromium, "chromium is missing"
    bench = json.loads(text) | {"bridges": {"web": {"port": 0}}}
    expect.set_options(timeout=PATIENCE_MS)
    arguments = ["--no-sandbox"] if os.getuid() == 0 else []
    with Place() as place, sync_playwright() as playwright:
        server = place.serve(json.dumps(bench))
        browser = playwright.chromium.launch(executable_path=chromium, args=arguments)
        made = Bench(place, server, browser)
        yield made
        browser.close()
        assert made.errors == []
