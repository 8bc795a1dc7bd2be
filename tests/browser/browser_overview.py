"""The first screen in a browser: cards of all that there is, things to try, and Stop all."""

import re
from collections.abc import Iterator

import pytest
from browser_pages import PHONE, Bench, Between, fits, served, violations
from e2e_support import READY_NS, until
from playwright.sync_api import Browser, expect

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
SAC = {"profile": "sac", "flash": {}}
ZOO = {
    "bench": "zoo",
    "devices": {"m1": SERVO, "m2": SERVO, "s1": SAC, "s2": SAC},
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}},
    "can": {"can0": {"bit_rate": 500000, "nodes": {"m1": 5, "m2": 6}}},
}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, ZOO) as bench:
        for device in ("m1", "m2"):
            bench.server.ready(device, boot_ns=READY_NS)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.server.ask("halt")
    bench.server.ask("clear", number="all", on="")
    bench.close_pages()


def turning(bench: Bench, device: str) -> bool:
    return abs(bench.server.ask("state", device=device)["velocity_rpm"]) > 20


def test_the_header_and_the_card_say_what_failed(pages: Bench) -> None:
    page = pages.open("bench")
    pill = page.get_by_role("button", name=re.compile("bus0: two stations"))
    expect(pill).to_contain_text("two stations have one address 85")
    bus = page.get_by_role("article", name="bus0", exact=True)
    expect(bus).to_contain_text("two stations have one address 85")
    first = page.get_by_role("list", name="Cards of the bench").get_by_role("article").first
    expect(first).to_have_attribute("aria-label", "bus0")
    problems = page.get_by_role("dialog", name="Problems of the bench")
    pill.click()
    expect(problems).to_be_visible()
    page.keyboard.press("Escape")
    expect(problems).to_be_hidden()
    pill.click()
    expect(problems).to_be_visible()
    page.mouse.click(300, 700)
    expect(problems).to_be_hidden()


def test_all_that_there_is_has_a_card_and_a_card_is_a_link(pages: Bench) -> None:
    page = pages.open("bench")
    for name in ("m1", "s1", "bus0", "can0", "Door web"):
        expect(page.get_by_role("article", name=name, exact=True)).to_be_visible()
    expect(page.get_by_role("article", name="can0", exact=True)).to_contain_text("TEC 0 REC 0")
    page.get_by_role("searchbox", name="Filter the cards").fill("can")
    expect(page.get_by_role("article", name="m1", exact=True)).to_be_hidden()
    page.get_by_role("article", name="can0", exact=True).locator(".reading").first.click(force=True)
    expect(page).to_have_url(re.compile("#/wire/can0"))
    page.goto(f"{pages.url}#/bench")
    page.get_by_role("searchbox", name="Filter the cards").fill("")
    page.get_by_role("article", name="m1", exact=True).locator("canvas").click(force=True)
    expect(page).to_have_url(re.compile("#/bench/m1"))
    page.goto(f"{pages.url}#/bench")
    page.get_by_role("article", name="s1", exact=True).hover()
    page.get_by_role("link", name="Break s1…").click()
    expect(page).to_have_url(re.compile("#/faults/s1"))


def test_a_newcomer_turns_a_shaft_types_and_breaks_something(pages: Bench) -> None:
    page = pages.open("bench")
    steps = page.get_by_role("region", name="Things to try", exact=True)
    expect(steps).to_contain_text("hil axis m1 move-rel 90")
    expect(steps).to_contain_text("hil type s1 '' --enter")
    expect(steps).to_contain_text("hil fault inject shaft_jam m1 for_s=3")
    before_deg = pages.server.ask("state", device="m1")["position_deg"]
    steps.get_by_role("button", name="Enable m1 and turn it").click()
    until(lambda: abs(pages.server.ask("state", device="m1")["position_deg"] - before_deg - 90) < 1, "turn")
    m1 = page.get_by_role("article", name="m1", exact=True)
    expect(m1.locator(".mode")).to_have_text("x")
    steps.get_by_role("button", name="Break something").click()
    expect(m1).to_contain_text("shaft jam")
    expect(page.get_by_role("link", name="1 fault")).to_be_visible()
    steps.get_by_role("button", name="Type at s1").click()
    expect(page).to_have_url(re.compile("#/bench/s1"))
    expect(page.get_by_role("tab", name="Terminal")).to_have_attribute("aria-selected", "true")
    page.goto(f"{pages.url}#/bench")
    steps.get_by_role("button", name="Dismiss").click()
    expect(steps).to_be_hidden()
    page.wait_for_timeout(600)  # what is kept is written a little later
    page.reload()
    expect(m1).to_be_visible()
    expect(steps).to_be_hidden()


def test_stop_all_stops_all_also_while_somebody_types(pages: Bench) -> None:
    page = pages.open("bench")
    for device in ("m1", "m2"):
        pages.server.ask("do", device=device, name="enable", parameters={})
        pages.server.ask("do", device=device, name="velocity", parameters={"velocity_rpm": 60})
    until(lambda: turning(pages, "m1") and turning(pages, "m2"), "both turn")
    expect(page.locator(".counts")).to_contain_text("2 moving")
    page.get_by_role("button", name="Stop all").click()
    expect(page.get_by_text("Stop all: m1, m2")).to_be_visible()
    until(lambda: not turning(pages, "m1") and not turning(pages, "m2"), "both stand")
    expect(page.locator(".counts")).to_contain_text("0 moving")
    pages.server.ask("do", device="m1", name="velocity", parameters={"velocity_rpm": 60})
    until(lambda: turning(pages, "m1"), "m1 turns")
    page.get_by_role("searchbox", name="Filter the cards").fill("m1")
    page.keyboard.press("Shift+Escape")
    until(lambda: not turning(pages, "m1"), "m1 stands")
    expect(page.get_by_role("searchbox", name="Filter the cards")).to_have_value("m1")


def test_stop_all_says_that_it_could_not_be_sent(pages: Bench) -> None:
    between: list[Between] = []
    page = pages.open("bench", prepare=lambda page: between.append(Between(page)))
    expect(page.get_by_role("button", name="Stop all")).to_be_visible()
    page.route("**/api/hello", lambda route: route.abort())
    pages.errors.clear()
    between[0].cut()
    button = page.get_by_role("button", name="Cannot stop: no connection")
    button.click()
    expect(page.get_by_text("Stop all was NOT sent").first).to_be_visible()
    pages.errors.clear()  # what the browser says of the requests that were cut off


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_first_screen_is_for_everybody(pages: Bench, scheme: str) -> None:
    page = pages.open("bench", color_scheme=scheme)
    expect(page.get_by_role("article", name="m1", exact=True).locator(".reading").first).to_have_text(
        re.compile(r"\d")
    )
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
