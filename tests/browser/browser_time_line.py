"""The time line in a browser: marks, going back by mouse and keys, what the page shows then, the way back."""

import json
import re
import time
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
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    """Bench at which something happened: m1 turned, had a fault, and s1 was typed at."""
    with served(chromium, CONTENT) as bench:
        server = bench.server.ready("m1", boot_ns=READY_NS).ready("s1")
        server.ask("do", device="m1", name="enable", parameters={})
        server.ask("do", device="m1", name="position", parameters={"position_deg": 90})
        number = server.ask("inject", target="m1", fault="shaft_load", parameters={"torque_Nm": 0.01})[
            "number"
        ]
        server.ask("type", device="s1", text="?\r")
        server.ask("play", tap="bus0.master", bursts=[[0, "0256010203"]])
        time.sleep(1)
        server.ask("clear", number=number, on="")
        server.ask("do", device="m1", name="position", parameters={"position_deg": 0})
        time.sleep(3)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def line(page: Page) -> Locator:
    return page.get_by_role("slider", name="Time of the run that is shown")


def events_back(page: Page, text: str) -> None:
    """Go back from event to event, to the one with a text."""
    said = page.locator(".time-line-controls [role=status]")
    for _ in range(20):
        before = said.inner_text()
        page.get_by_role("button", name="Event before").click()
        expect(said).not_to_have_text(before)
        if text in said.inner_text():
            return
    raise AssertionError(f"there is no event {text!r}")


def test_events_lead_back_and_the_page_shows_what_was_then(pages: Bench) -> None:
    page = pages.open("bench/m1")
    expect(line(page)).to_have_attribute("aria-valuetext", "live")
    events_back(page, "position position_deg=0")
    expect(page.get_by_text("ago:")).to_be_visible()
    expect(page.locator(".trace-value").first).to_have_text(
        re.compile(r"^(89|90)\.")
    )  # before it takes effect
    expect(page.get_by_text("What you see is past")).to_be_visible()
    page.get_by_role("tab", name="Fields", exact=True).click()
    row = page.get_by_role("row", name=re.compile("^r "))
    expect(row).to_contain_text(re.compile(r"0\.0000|90\.0000"))
    page.get_by_role("button", name="Back to live").click()
    expect(line(page)).to_have_attribute("aria-valuetext", "live")
    expect(page.get_by_text("What you see is past")).to_have_count(0)


def test_a_drag_and_keys_move_the_shown_time(pages: Bench) -> None:
    page = pages.open("bench/m1")
    box = line(page).bounding_box()
    assert box
    page.mouse.move(box["x"] + box["width"] * 0.8, box["y"] + 5)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + 5, steps=20)
    page.mouse.up()
    value = float(line(page).get_attribute("aria-valuenow") or 0)
    length = float(line(page).get_attribute("aria-valuemax") or 0)
    assert 0.2 * length < value < 0.4 * length
    line(page).focus()
    page.keyboard.press("ArrowRight")
    assert float(line(page).get_attribute("aria-valuenow") or 0) > value
    page.keyboard.press("Home")
    expect(line(page)).to_have_attribute("aria-valuenow", "0")
    page.keyboard.press("End")
    expect(line(page)).to_have_attribute("aria-valuetext", "live")


def test_a_condition_is_found_and_time_is_played(pages: Bench) -> None:
    page = pages.open("bench/m1")
    page.get_by_label("Condition to look for").fill("m1.yw > 45")
    page.get_by_role("button", name="Last", exact=True).click()
    said = page.locator(".time-line-controls [role=status]")
    expect(said).to_contain_text("m1.yw > 45")
    expect(page.locator(".trace-value").nth(1)).to_have_text(re.compile(r"^\d"))
    page.get_by_label("Condition to look for").fill("m1.yq > 45")
    page.get_by_role("button", name="Next", exact=True).click()
    expect(said).to_contain_text("yq")
    at = float(line(page).get_attribute("aria-valuenow") or 0)
    page.get_by_role("button", name="Play").click()
    page.wait_for_function(
        "at => Number(document.querySelector('[role=slider]').ariaValueNow) > at + 0.5", arg=at
    )
    page.get_by_role("button", name="Stop", exact=True).click()
    page.get_by_role("button", name="Open here as a bench").click()
    expect(page.locator(".open-here code")).to_have_text(
        re.compile(r"^hil replay t/last --until [\d.]+s --serve$")
    )


def test_terminals_and_wires_show_the_past(pages: Bench) -> None:
    page = pages.open("bench/s1")
    page.get_by_role("tab", name="Terminal", exact=True).click()
    line(page).focus()
    page.keyboard.press("PageUp")
    words = page.get_by_role("region", name="Words at s1 until then")
    expect(words).to_contain_text("SAC")
    expect(words.locator(".typed")).to_contain_text("?")
    page.goto(re.sub("#.*", "#/wire/bus0", page.url))
    expect(page.get_by_text("ago:")).to_be_visible()
    expect(page.locator(".packet-rows .packet").first).to_be_visible()
    page.get_by_role("button", name="Back to live").click()
    expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_time_line_is_usable_by_all(pages: Bench, theme: str) -> None:
    page = pages.open("bench/m1")
    page.emulate_media(color_scheme=theme)
    line(page).focus()
    page.keyboard.press("PageUp")
    expect(page.get_by_text("ago:")).to_be_visible()
    assert violations(page) == []
    page.set_viewport_size({"width": PHONE["width"], "height": PHONE["height"]})
    fits(page, PHONE["width"])
    assert violations(page) == []
    # There it is one row of the screen, which has the rest of it below.
    expect(line(page)).to_be_hidden()
    more = page.get_by_role("button", name=re.compile("Time line,"))
    small = page.get_by_role("region", name="Time line of the run").bounding_box()
    assert small
    assert small["height"] < PHONE["height"] / 15
    more.press("Enter")
    expect(line(page)).to_be_visible()
    assert violations(page) == []
    more.press("Enter")
    expect(line(page)).to_be_hidden()


def test_a_run_without_a_recording_says_so(chromium: Browser) -> None:
    content = json.loads(json.dumps(CONTENT)) | {"recordings": {"keep_runs": 0}}
    with served(chromium, content) as bench:
        page = bench.open("bench")
        expect(page.get_by_text("No time line: this run is not recorded")).to_be_visible()
