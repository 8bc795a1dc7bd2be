"""Each view in Firefox: it shows what it is for, and no error."""

import shutil
from collections.abc import Iterator

import pytest
from browser_pages import Bench, in_layout, served
from e2e_support import READY_NS
from firefox_pages import FirefoxPage, firefox_page
from playwright.sync_api import Browser

BENCH = {
    "bench": "fox",
    "speed": 4,
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "flash": {}},
    },
    "segments": {"bus0": {"stations": ["s1"]}},
}
SHOWN = {
    "bench": "m1",
    "bench/m1": "position_deg",
    "layout/ready/bench": "Events",
    "runs": "Start",
    "faults": "m1",
    "path": "Start",
    "wire/bus0": "packets/s",
    "companion/s1": "RPM",
}
"""Places of the page, and a word that stands there."""


@pytest.fixture(scope="module")
def page(chromium: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Bench, FirefoxPage]]:
    if (executable := shutil.which("firefox-esr") or shutil.which("firefox")) is None:
        pytest.skip("Firefox is missing: sudo apt install firefox-esr")
    with served(chromium, BENCH) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        with firefox_page(executable, tmp_path_factory.mktemp("fox")) as page:
            yield bench, page


PANELS = {
    "plot": ({"given": {"signals": ["m1.position_deg"]}}, ".uplot canvas"),
    "number": ({"of": "m1.position_deg"}, ".big-value"),
    "picture": ({"given": {"form": "shafts"}}, "canvas, svg"),
    "events": ({}, "input"),
    "wire": ({"of": "bus0"}, ".packets"),
    "terminal": ({"of": "s1"}, ".xterm"),
    "verbs": ({"of": "m1"}, "button"),
    "gains": ({"of": "m1"}, "input"),
    "pins": ({"of": "s1"}, "canvas"),
    "fields": ({"of": "m1"}, "table"),
    "faults": ({}, "a"),
    "path": ({}, "a, canvas"),
    "runs": ({}, ".card"),
}
"""Kinds of panels: what each shows, and what stands in it."""


@pytest.mark.thorough
def test_each_kind_of_panel_is_shown_without_an_error(page: tuple[Bench, FirefoxPage]) -> None:
    bench, fox = page
    fox.errors.clear()
    fox.resize(1400, 1000)
    for kind, (row, selector) in PANELS.items():
        layout = {"version": 1, "name": kind, "root": {"tabs": [{"kind": kind, **row}]}}
        fox.go(f"{bench.url}#/{in_layout(layout)}")
        fox.until(f"Boolean(document.querySelector('.panel.is-{kind}')?.querySelector({selector!r}))")
    assert fox.errors == []


@pytest.mark.parametrize("where", SHOWN)
def test_a_view_is_shown_without_an_error(page: tuple[Bench, FirefoxPage], where: str) -> None:
    bench, fox = page
    fox.errors.clear()
    fox.go(f"{bench.url}#/{where}")
    fox.until(f"document.querySelector('main')?.innerText.includes({SHOWN[where]!r})")
    for width, height in ((390, 844), (1400, 1000)):
        fox.resize(width, height)
        assert fox.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert fox.errors == []
