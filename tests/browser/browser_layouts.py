"""Panels in a browser: ready layouts, adding and arranging by keys, addresses, what a bench lacks."""

import base64
import json
import re
import zlib
from collections.abc import Iterator

import pytest
from browser_pages import PHONE, Bench, fits, in_layout, served, violations
from e2e_support import READY_NS, until
from playwright.sync_api import Browser, Locator, Page, expect

CONTENT = {
    "bench": "panels",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "flash": {}},
        "w1": {"profile": "walter"},
    },
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
}
READY = ("bench", "tuning", "bus", "cell", "wall")


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, CONTENT) as bench:
        bench.server.ready("m1", boot_ns=READY_NS).ready("s1")
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def tabs(page: Page) -> list[str]:
    return page.locator(".panel-tab").all_inner_texts()


def tab(page: Page, name: str) -> Locator:
    return page.get_by_role("tab", name=name, exact=True)


def add(page: Page, kind: str) -> None:
    page.get_by_role("button", name="+ Panel").click()
    page.get_by_role("group", name="+ Panel").get_by_role("button", name=kind, exact=True).click()


def address(page: Page) -> str:
    """Place in the page, as `Bench.open` takes it."""
    return str(page.evaluate("location.hash.slice(2)"))


def in_address(page: Page, kind: str) -> str:
    """Address of the page once it has a layout with a panel of a kind."""
    until(lambda: f'"{kind}"' in layout_of(address(page)), f"a panel {kind} in the address")
    return address(page)


def layout_of(where: str) -> str:
    """JSON of the layout of an address; empty: it has none."""
    found = re.fullmatch(r"layout/1[.]([\w-]+)", where)
    if not found:
        return ""
    packed = base64.urlsafe_b64decode(found[1] + "=" * (-len(found[1]) % 4))
    return zlib.decompress(packed, -zlib.MAX_WBITS).decode()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_ready_layouts_are_there_and_accessible(pages: Bench, theme: str) -> None:
    page = pages.open("layout", color_scheme=theme)
    for ready in READY:
        page.goto(f"{pages.url}#/layout/ready/{ready}")
        expect(page.get_by_label("Name of the layout")).to_have_value(ready.capitalize())
        expect(page.locator(".panel").first).to_be_visible()
        assert address(page) == f"layout/ready/{ready}"
        # What is behind another tab is not there, with all that it would watch.
        expect(page.locator(".panel")).to_have_count(page.locator(".dv-groupview").count())
        assert violations(page) == []
    assert page.get_by_role("button", name=re.compile("Clear|Close the port|enable")).count() == 0


def test_a_panel_is_added_moved_and_closed_by_keys_and_its_address_has_all(pages: Bench) -> None:
    page = pages.open("layout/ready/tuning")
    expect(tab(page, "Gains m1")).to_be_visible()
    add(page, "Number")
    expect(page.locator(".dv-tab:focus")).to_have_text("m1.position")
    page.keyboard.press("Delete")
    add(page, "Wire")
    wire = tab(page, "Wire bus0")
    expect(wire).to_be_focused()
    before = wire.bounding_box()
    page.keyboard.press("Alt+ArrowRight")
    expect(wire).to_be_focused()
    after = wire.bounding_box()
    assert before
    assert after
    assert (after["x"], after["y"]) != (before["x"], before["y"])
    page.keyboard.press("Alt+ArrowUp")
    page.keyboard.press("Alt+ArrowUp")
    expect(wire).to_be_focused()
    page.keyboard.press("F6")
    expect(wire).not_to_be_focused()
    where = in_address(page, "wire")
    other = pages.open(where)
    expect(tab(other, "Wire bus0")).to_be_visible()
    assert sorted(tabs(other)) == sorted(tabs(page))
    page.reload()
    expect(tab(page, "Wire bus0")).to_be_visible()


def test_tabs_change_their_order_by_keys_and_by_the_menu(pages: Bench) -> None:
    names = ("runs", "events", "faults")
    three = {"version": 1, "name": "three", "root": {"tabs": [{"kind": name} for name in names]}}
    page = pages.open(in_layout(three))
    titles = page.locator(".panel-tab")
    expect(titles).to_have_text(["Runs", "Events", "Faults"])
    tab(page, "Runs").click()
    page.keyboard.press("Alt+PageDown")
    expect(titles).to_have_text(["Events", "Runs", "Faults"])
    expect(tab(page, "Runs")).to_be_focused()
    page.keyboard.press("Alt+PageDown")
    page.keyboard.press("Alt+PageDown")
    expect(titles).to_have_text(["Events", "Faults", "Runs"])
    page.get_by_role("button", name="Arrange Runs").click()
    page.get_by_role("button", name="Before the tab before it").click()
    expect(titles).to_have_text(["Events", "Runs", "Faults"])
    until(lambda: [row["kind"] for row in shown_tabs(page)] == ["events", "runs", "faults"], "the order")


def shown_tabs(page: Page) -> list[dict[str, str]]:
    """Panels of a layout with one place, in the address."""
    tabs: list[dict[str, str]] = json.loads(layout_of(address(page)))["root"]["tabs"]
    return tabs


def test_a_layout_is_saved_and_what_was_changed_comes_back(pages: Bench) -> None:
    page = pages.open("layout/ready/bus")
    page.get_by_label("Name of the layout").fill("night watch")
    add(page, "Picture")
    expect(tab(page, "Shafts")).to_be_visible()
    page.get_by_role("group", name="Layout", exact=True).get_by_role("button", name="Save").click()
    add(page, "Runs")
    expect(tab(page, "Runs")).to_be_visible()
    page.get_by_role("button", name="Layouts").click()
    page.get_by_role("link", name="Wall").click()
    expect(page.get_by_label("Name of the layout")).to_have_value("Wall")
    expect(tab(page, "Runs")).to_have_count(0)
    page.get_by_role("button", name="Layouts").click()
    page.get_by_role("group", name="Layouts").get_by_role("button", name="night watch", exact=True).click()
    expect(tab(page, "Runs")).to_be_visible()
    page.goto(f"{pages.url}#/layout/saved/night%20watch")
    expect(tab(page, "Shafts")).to_be_visible()
    expect(tab(page, "Runs")).to_have_count(0)


def test_the_address_has_what_is_chosen_of_a_plot(pages: Bench) -> None:
    page = pages.open("layout/ready/tuning")
    plot = page.get_by_role("region", name="Plots of").first
    plot.get_by_label("Shown time").select_option("2 s")
    plot.get_by_role("button", name=re.compile("^y free")).first.click()
    upper = plot.get_by_label(re.compile("^Upper end")).first
    upper.fill("4321")
    upper.press("Enter")
    plot.get_by_role("button", name="Trigger", exact=True).click()
    level = plot.get_by_label("Level", exact=True)
    level.fill("12.5")
    level.press("Enter")
    until(lambda: "12.5" in layout_of(address(page)), "the trigger's level in the address")
    where = address(page)
    other = pages.open(where)  # a browser that knows nothing but the address
    same = other.get_by_role("region", name="Plots of").first
    expect(same.get_by_label("Shown time")).to_have_value(plot.get_by_label("Shown time").input_value())
    expect(same.get_by_label(re.compile("^Upper end")).first).to_have_value("4321")
    same.get_by_role("button", name="Trigger", exact=True).click()
    expect(same.get_by_label("Level", exact=True)).to_have_value("12.5")
    # Another layout has its own settings again.
    other.goto(f"{pages.url}#/layout/ready/tuning")
    expect(same.get_by_label("Shown time")).not_to_have_value(plot.get_by_label("Shown time").input_value())
    expect(same.get_by_label(re.compile("^Upper end"))).to_have_count(0)


BAD = {
    "layout/1.AAAA": "no layout that can be read",
    "layout/9.abc": "version 9",
    "layout/ready/nosuch": "There are: bench, tuning, bus, cell, wall",
    "layout/saved/nosuch": "has no layout “nosuch”",
}


def test_an_address_that_names_no_layout_says_so_and_what_was_there_stays(pages: Bench) -> None:
    page = pages.open("layout/ready/bus")
    expect(tab(page, "Wire bus0")).to_be_visible()
    for where, said in BAD.items():
        page.goto(f"{pages.url}#/{where}")
        expect(page.get_by_role("alert").filter(has_text=said)).to_be_visible()
        expect(tab(page, "Wire bus0")).to_be_visible()
    page.goto(f"{pages.url}#/bench")
    expect(tab(page, "Wire bus0")).to_have_count(0)
    page.reload()
    page.goto(f"{pages.url}#/layout")
    expect(tab(page, "Wire bus0")).to_be_visible()


def test_what_a_bench_lacks_and_what_is_too_much_is_said(pages: Bench) -> None:
    missing = {"tabs": [{"kind": "verbs", "of": "m7"}]}
    many = {"tabs": [{"kind": "number", "of": f"x{number}.yw"} for number in range(1000)]}
    made = {"version": 1, "name": "far", "bench": "other", "root": {"parts": [missing, many]}}
    page = pages.open(in_layout(made))
    expect(page.get_by_text("It was made for the bench other")).to_be_visible()
    expect(page.get_by_text("953 more panels wait")).to_be_visible()
    lacking = page.get_by_role("group", name="Verbs m7", exact=True)
    expect(lacking).to_contain_text("m7 is not on this bench")
    lacking.get_by_label("Shows").select_option("m1")
    expect(page.get_by_role("button", name="enable", exact=True)).to_be_visible()
    expect(tab(page, "Verbs m1")).to_be_visible()
    add(page, "Events")
    expect(page.get_by_text("at most 48 panels")).to_be_visible()


def test_panels_stand_below_each_other_on_a_phone(pages: Bench) -> None:
    page = pages.open("layout/ready/tuning", viewport=PHONE)
    expect(page.get_by_role("heading", name="Plot m1")).to_be_visible()
    fits(page, 390)
    assert violations(page) == []
    page.get_by_role("button", name="Close Plot m1").click()
    expect(page.get_by_role("heading", name="Plot m1")).to_have_count(0)
    page.get_by_role("button", name="Move m1.e down").click()
    headings = page.locator(".stacked h3")
    expect(headings.nth(2)).to_have_text("m1.e")
