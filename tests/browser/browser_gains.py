"""Gains in a browser: steps, their figures, and the shaft where it was."""

from collections.abc import Iterator

import pytest
from browser_pages import Bench, served, violations
from e2e_support import until
from playwright.sync_api import Browser, Locator, Page, expect

DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "m2": {"profile": "mechaduino", "flash": {}},
}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, {"bench": "g", "devices": DEVICES}) as bench:
        bench.server.ready()
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def gains(page: Page) -> Locator:
    page.get_by_role("tab", name="Gains", exact=True).click()
    return page.get_by_role("tabpanel", name="Gains")


def angle_deg(bench: Bench, device: str = "m1") -> float:
    return float(bench.server.ask("state", device=device)["position_deg"])


def test_steps_before_and_after_a_change_and_the_shaft_is_back(pages: Bench) -> None:
    page = pages.open("bench/m1")
    tab = gains(page)
    was_deg = angle_deg(pages)
    tab.get_by_role("textbox", name="how far").fill("0")
    expect(tab.get_by_text("0 deg is no step")).to_be_visible()
    expect(tab.get_by_role("button", name="Step response")).to_be_disabled()
    tab.get_by_role("textbox", name="how far").fill("12")
    tab.get_by_role("textbox", name="pKp").fill("x")
    expect(tab.get_by_text("write a number")).to_be_visible()
    tab.get_by_role("button", name="Step response").click()  # gains that are wrong do not matter to it
    figures = tab.get_by_role("region", name="Figures of the step responses").get_by_role("row")
    expect(figures.nth(1)).to_contain_text("after")
    until(lambda: abs(angle_deg(pages) - was_deg) < 0.2, "the shaft to be back")
    tab.get_by_role("textbox", name="pKp").fill("9")
    tab.get_by_role("button", name="Step, set gains, step again").click()
    expect(figures).to_have_count(5)
    for row, words in enumerate(("before", "after", "after − before", "→ 9"), 1):
        expect(figures.nth(row)).to_contain_text(words)
    until(lambda: abs(angle_deg(pages) - was_deg) < 0.2, "the shaft to be back")
    with page.expect_download() as saving:
        tab.get_by_role("button", name="CSV", exact=True).click()
    head, *rows = saving.value.path().read_text().splitlines()
    assert head == "response,at_s,set_point_deg,position_deg"
    assert len(rows) > 3000, "a sample each 0.25 ms"
    tab.get_by_role("button", name="Keep “before”").click()
    assert violations(page) == []


def test_a_step_that_is_stopped_goes_back(pages: Bench) -> None:
    page = pages.open("bench/m1")
    tab = gains(page)
    was_deg = angle_deg(pages)
    tab.get_by_role("textbox", name="recorded time").fill("10")
    tab.get_by_role("button", name="Step response").click()
    until(lambda: abs(angle_deg(pages) - was_deg) > 5, "the shaft to step")
    tab.get_by_role("button", name="Stop the step").click()
    until(lambda: abs(angle_deg(pages) - was_deg) < 0.2, "the shaft to be back")
    expect(page.get_by_text("m1: the step was stopped").first).to_be_visible()


def test_a_board_without_calibration_says_so(pages: Bench) -> None:
    page = pages.open("bench/m2")
    gains(page).get_by_role("button", name="Step response").click()
    expect(page.get_by_text("the look-up table is empty; calibrate it first").first).to_be_visible()
