"""The wire view in a browser: packets as they pass, a collision, filter, pause, sending, a capture."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_pages import Bench, companion_bench
from playwright.sync_api import Browser, Page, expect

SEGMENTS = {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}}
PACKETS = {"role": "grid", "name": "Packets"}


@pytest.fixture
def bench(chromium: Browser) -> Iterator[Bench]:
    yield from companion_bench(chromium, 1, segments=SEGMENTS)


@pytest.fixture
def page(bench: Bench) -> Page:
    page = bench.open("wire/bus0")
    expect(page.get_by_text("0 shown of 0")).to_be_visible()
    bench.server.ready("s1").ready("s2")
    return page


def send(page: Page, text: str, to: str = "85") -> None:
    page.get_by_label("to", exact=True).fill(to)
    page.get_by_label("Command", exact=True).fill(text)
    page.get_by_role("button", name="Send", exact=True).click()


def test_packets_are_shown_filtered_paused_and_exported(page: Page, bench: Bench) -> None:
    rows = page.locator(".packet-rows .packet")
    send(page, "m300", to="0")
    expect(rows).to_have_count(1)
    expect(rows.first).to_contain_text("1 -> all m300")
    # Both boards have the address 85 from the factory: their answers collide.
    send(page, "m400")
    bad = page.locator(".packet-rows .packet.is-bad")
    expect(bad.first).to_contain_text("collision of s1.network and s2.network")
    expect(page.get_by_role("table", name="What was wrong")).to_contain_text("collision")
    page.get_by_label("Filter the packets").fill("m400 -error")
    expect(rows).to_have_count(1)
    page.get_by_label("Filter the packets").fill("")
    page.get_by_role("button", name="Pause").click()
    send(page, "m500", to="0")
    expect(page.get_by_text("1 since the pause")).to_be_visible()
    expect(page.get_by_text("m500", exact=False).and_(rows)).to_have_count(0)
    page.get_by_role("button", name="Go on").click()
    expect(rows.last).to_contain_text("m500")
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Export pcapng").click()
    told = bench.place.hil("decode", str(Path(waiting.value.path())))
    assert "1 -> all m300" in told
    assert "m500" in told


def test_the_time_line_and_the_load_follow(page: Page) -> None:
    for number in range(5):
        send(page, f"m{number + 1}00", to="0")
    expect(page.get_by_role("img", name="Time line of the last second")).to_be_visible()
    expect(page.get_by_role("meter", name="Load of the last second")).to_be_visible()
    expect(page.locator(".figures").get_by_text("5", exact=True)).to_be_visible()


def test_bytes_that_cannot_be_sent_are_told(page: Page) -> None:
    page.get_by_role("combobox", name="Send").select_option("bytes as they are")
    page.get_by_label("Bytes, hexadecimal").fill("02 5")
    expect(page.get_by_text("a byte has two digits; one is missing")).to_be_visible()
    page.get_by_label("Bytes, hexadecimal").fill("02 56 01")
    page.get_by_role("button", name="Send", exact=True).click()
    # It is no packet yet, and is shown as soon as the line is silent.
    bad = page.locator(".packet-rows .packet.is-bad")
    expect(bad).to_contain_text("unfinished")
    expect(bad).to_contain_text("bus0.master")
    page.get_by_label("Bytes, hexadecimal").fill("6d 39 03 00")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(bad).to_have_count(0)
    expect(page.locator(".packet-rows .packet")).to_have_count(1)
    expect(page.locator(".packet-rows .packet")).to_contain_text("1 -> 86 m9")


def test_a_phone(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") == 390
