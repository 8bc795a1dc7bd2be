"""All views, kinds of panels and ready layouts, in both themes, wide and narrow: for everybody, and whole."""

import re
from collections.abc import Iterator

import pytest
from browser_pages import Bench, Between, fits, in_layout, served, violations
from e2e_support import READY_NS, until
from playwright.sync_api import Browser, Page, expect

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
SAC = {"profile": "sac", "flash": {}}
CONTENT = {
    "bench": "sweep",
    "devices": {"m1": SERVO, "m2": SERVO, "s1": SAC, "w1": {"profile": "walter"}, "u1": {"profile": "uno"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
    "can": {"can0": {"bit_rate": 500000, "nodes": {"m1": 5, "m2": 6}}},
}
PANELS = (
    {"kind": "plot", "given": {"signals": ["m1.position_deg", "m2.current_A", "s1.velocity_rpm"]}},
    {"kind": "number", "of": "m1.position_deg", "given": {"low": -10, "high": 10}},
    {"kind": "picture", "given": {"form": "shafts"}},
    {"kind": "picture", "given": {"form": "plate", "x": "m1", "y": "m2"}},
    {"kind": "picture", "of": "w1", "given": {"form": "arm"}},
    {"kind": "events"},
    {"kind": "wire", "of": "bus0"},
    {"kind": "wire", "of": "can0"},
    {"kind": "terminal", "of": "s1"},
    {"kind": "verbs", "of": "m1"},
    {"kind": "gains", "of": "m1"},
    {"kind": "pins", "of": "s1"},
    {"kind": "fields", "of": "m1"},
    {"kind": "faults"},
    {"kind": "path"},
    {"kind": "runs"},
)
COLUMNS = 4
ALL = "all panels"
VIEWS = (
    *("bench", "bench/m1", "bench/s1", "bench/w1", "runs", "faults", "faults/m1", "events", "path"),
    *("wire/bus0", "wire/can0", "companion/s1"),
)
READY = tuple(f"layout/ready/{name}" for name in ("bench", "tuning", "bus", "cell", "wall"))
SIZES = {390: 9000, 1440: 2600}
"""Widths, each with the height that a window begins with. It grows with what is shown."""
SAMPLE = {(ALL, "dark", 390), (ALL, "light", 1440)}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, CONTENT) as bench:
        bench.server.ready("m1", boot_ns=READY_NS).ready("s1")
        bench.server.ask("inject", target="m1", fault="byte_drop", parameters={"rate": 0.1})
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def all_panels() -> dict[str, object]:
    """A layout that has each kind of panel in sight."""
    columns = [{"parts": [{"tabs": [row]} for row in PANELS[at::COLUMNS]]} for at in range(COLUMNS)]
    return {"version": 1, "name": "all", "bench": "sweep", "root": {"parts": columns}}


def until_shown(page: Page) -> None:
    """Wait until a place shows what it has, with what is loaded when it is used."""
    expect(page.locator("main")).to_be_visible()
    expect(page.get_by_text("Loading")).to_have_count(0)
    expect(page.get_by_text(re.compile("^(is being loaded|Connecting)"))).to_have_count(0)


def has_in_sight(page: Page, count: int) -> bool:
    """Make the window as high as the page, and return whether it has ``count`` panels.

    Panels out of sight are not drawn, and the page's height follows fonts and the fields of boards.
    """
    height = page.evaluate("document.documentElement.scrollHeight")
    page.set_viewport_size({"width": page.evaluate("innerWidth"), "height": height})
    return page.locator(".panel").count() == count


@pytest.mark.parametrize(
    ("where", "theme", "width"),
    [
        pytest.param(*case, marks=() if case in SAMPLE else pytest.mark.thorough)
        for where in (ALL, *VIEWS, *READY)
        for theme in ("light", "dark")
        for width in SIZES
        if (case := (where, theme, width))
    ],
)
def test_a_place_is_for_everybody_and_whole(pages: Bench, where: str, theme: str, width: int) -> None:
    size = {"width": width, "height": SIZES[width]}
    place = in_layout(all_panels()) if where == ALL else where
    page = pages.open(place, viewport=size, color_scheme=theme)
    until_shown(page)
    if where == ALL:
        until(lambda: has_in_sight(page, len(PANELS)), "each kind of panel")
    fits(page, width)
    assert violations(page) == []


BELOW = """lower => {
  const line = document.querySelector("section.time-line")?.getBoundingClientRect();
  const above = document.querySelector(lower)?.getBoundingClientRect();
  return line && above && above.height > 0 && above.bottom <= line.top;
}"""


def test_the_time_line_covers_neither_the_axis_of_time_nor_the_line_to_send(pages: Bench) -> None:
    page = pages.open("bench/m1", viewport={"width": 1440, "height": 900})
    page.wait_for_function(BELOW, arg=".pane.has-times")
    page.get_by_role("button", name="Event before").click()
    expect(page.get_by_text("what you see is from then")).to_be_visible()
    page.wait_for_function(BELOW, arg=".pane.has-times")
    page.get_by_role("button", name="Back to live").click()
    page.set_viewport_size({"width": 1600, "height": 1000})
    page.get_by_role("tab", name="Terminal", exact=True).click()
    page.wait_for_function(BELOW, arg=".terminal-line")


def test_a_reason_in_the_head_moves_nothing(pages: Bench) -> None:
    made: list[Between] = []
    size = {"width": 1440, "height": 900}
    page = pages.open("bench/m1", viewport=size, prepare=lambda page: made.append(Between(page)))
    top = "document.querySelector('main').getBoundingClientRect().top"
    expect(page.locator(".pill.is-open")).to_be_visible()
    before_px = page.evaluate(top)
    problem = '{"kind":"device","about":"m1","what":"stopped: it hung, and did not say why","remedy":""}'
    made[0].change = lambda said: (
        re.sub(r'("problems":)\[.*?\](?=\})', rf"\1[{problem}]", said) if isinstance(said, str) else said
    )
    expect(page.locator(".health-reason")).to_contain_text("it hung")
    assert page.evaluate(top) == before_px
    fits(page, 1440)


STRANGE = ("%E0%A4%A", "__proto__", "x" * 5000)
"""Names that are nowhere: broken, of the language itself, endless."""


def test_an_address_of_anything_is_answered_in_a_page_that_fits(pages: Bench) -> None:
    page = pages.open("bench")
    for view in ("bench", "wire", "faults", "companion", "layout", "layout/ready", "nosuch"):
        for name in STRANGE:
            page.goto(f"{pages.url}#/{view}/{name}")
            expect(page.locator("main")).not_to_be_empty()
            fits(page, 1400)
