"""Events in a browser: who asked for what, what was refused, and a click that goes there."""

import re
from collections.abc import Iterator

import pytest
from browser_pages import PHONE, Bench, fits, served, violations
from e2e_support import READY_NS
from playwright.sync_api import Browser, Locator, Page, expect

CONTENT = {
    "bench": "t",
    "speed": 4,
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "flash": {}},
    },
}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, CONTENT) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.server.ask("clear", number="all", on="")
    bench.close_pages()


def rows(page: Page, text: str) -> Locator:
    return (
        page.get_by_role("list", name="Events, the newest first")
        .get_by_role("listitem")
        .filter(has_text=text)
    )


def test_all_pages_see_who_asked_for_what_and_what_was_refused(pages: Bench) -> None:
    pages.server.ask("do", device="m1", name="enable", parameters={})
    page, other = pages.open("events"), pages.open("events")
    for each in (page, other):
        expect(rows(each, "enable").filter(has_text="control socket").first).to_be_visible()
    page.goto(f"{pages.url}#/bench/m1")
    page.get_by_role("tab", name="Verbs", exact=True).click()
    page.get_by_role("group", name="Verbs").get_by_role("button", name="calibrate", exact=True).click()
    page.locator("form.parameters").get_by_role("button", name="calibrate", exact=True).click()
    page.get_by_role("group", name="Verbs").get_by_role("button", name="calibrate", exact=True).click()
    page.locator("form.parameters").get_by_role("button", name="calibrate", exact=True).click()
    refused = rows(other, "calibrate: ").filter(has_text="refusals")
    expect(refused.first).to_be_visible()
    pages.server.ask("inject", target="s1", fault="shaft_jam", parameters={})
    expect(rows(other, "shaft_jam").first).to_be_visible()
    page.goto(f"{pages.url}#/events")
    expect(rows(page, "calibrate: ").filter(has_text="refusals")).to_have_count(refused.count())
    expect(rows(page, "shaft_jam").first).to_be_visible()


def test_what_the_page_said_stays_as_a_row_and_rows_are_found(pages: Bench) -> None:
    page = pages.open("bench")
    page.get_by_role("button", name="Stop all").click()
    notice = page.get_by_text("Stop all: ").first
    expect(notice).to_be_visible()
    page.get_by_role("button", name="Close this message").first.click()
    page.get_by_role("link", name="Events", exact=True).click()
    expect(rows(page, "Stop all: ").first).to_be_visible()
    pages.server.ask("type", device="s1", text="P")
    expect(rows(page, "type text P")).to_be_visible()
    page.get_by_role("group", name="Kinds of events").get_by_role("button", name=re.compile("^typed")).click()
    expect(rows(page, "type text P")).to_be_hidden()
    page.get_by_role("group", name="Kinds of events").get_by_role("button", name=re.compile("^typed")).click()
    page.get_by_role("searchbox", name="Filter the events").fill("s1 typed")
    expect(rows(page, "type text P")).to_be_visible()
    expect(rows(page, "Stop all: ")).to_have_count(0)


def test_a_click_goes_to_the_time_of_an_event(pages: Bench) -> None:
    pages.server.ask("do", device="m1", name="disable", parameters={})
    page = pages.open("events")
    row = rows(page, "disable").first
    row.get_by_role("button").click()
    expect(page).to_have_url(re.compile("#/bench/m1"))
    expect(page.get_by_role("button", name="Back to live")).to_be_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_list_is_for_everybody(pages: Bench, scheme: str) -> None:
    page = pages.open("events", color_scheme=scheme)
    expect(page.get_by_role("list", name="Events, the newest first")).to_be_visible()
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
