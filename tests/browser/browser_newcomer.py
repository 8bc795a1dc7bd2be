"""Somebody who has only the page: a motor moves, a jump of a plot is explained, a wire is broken."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from browser_pages import Bench, served
from e2e_support import until
from playwright.sync_api import Browser, expect

from hil.net.control_client import ControlError

DEMO = Path(__file__).parents[2] / "examples/demo.yaml"


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    """The demo, in a hurry, with a servo that was never calibrated."""
    demo = yaml.safe_load(DEMO.read_text())
    del demo["devices"]["m1"]["flash"]
    with served(chromium, {**demo, "speed": 10, "bridges": {"web": {"listen": 0}}}) as bench:
        bench.server.ready("m1")
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def angle_deg(bench: Bench) -> float:
    return float(bench.server.ask("state", device="m1")["position_deg"])


def is_at_its_menu(bench: Bench) -> bool:
    try:
        bench.server.ask("do", device="m1", name="mode", parameters={"mode": "position"})
    except ControlError:
        return False
    return True


def test_a_new_servo_is_calibrated_and_turned_by_buttons_of_the_first_screen(pages: Bench) -> None:
    page = pages.open()
    steps = page.get_by_role("region", name="Things to try")
    turn = steps.get_by_role("button", name="Enable m1 and turn it by 90 degrees")
    turn.click()
    expect(steps.get_by_role("alert")).to_have_text("the look-up table is empty; calibrate it first")
    steps.get_by_role("button", name="Calibrate m1, 26 s").click()
    expect(steps.get_by_role("alert")).to_have_count(0)

    until(lambda: is_at_its_menu(pages), "the end of the calibration")
    before_deg = angle_deg(pages)
    turn.click()
    expect(page.get_by_text("Enable m1 and turn it by 90 degrees: done")).to_be_visible()
    until(lambda: abs(angle_deg(pages) - before_deg - 90) < 5, "a quarter turn")


def test_a_jump_of_a_plot_is_found_by_its_event(pages: Bench) -> None:
    pages.server.ask("inject", target="m1", fault="shaft_load", parameters={"torque_Nm": 0.1, "for_s": 0.5})
    page = pages.open("bench/m1")
    page.get_by_role("link", name="Events", exact=True).click()
    row = page.get_by_role("listitem").filter(has_text="shaft_load torque_Nm 0.1")
    row.get_by_title("Look at this time").click()
    expect(page.get_by_text("what you see is from then")).to_be_visible()
    expect(page.get_by_role("heading", name="m1", exact=True)).to_be_visible()
    page.get_by_role("button", name="Back to live").click()
    expect(page.get_by_text("what you see is from then")).to_have_count(0)


def test_a_wire_is_broken_and_mended_from_its_thing(pages: Bench) -> None:
    page = pages.open("bench/s1")
    page.get_by_role("link", name="Break…").click()
    page.get_by_role("button", name=re.compile("The cable is out")).first.click()
    page.get_by_role("button", name=re.compile("^Inject")).click()
    active = page.get_by_role("region", name="Active faults", exact=True)
    expect(active).to_contain_text("host_close")
    active.get_by_role("button", name=re.compile("^Clear fault")).click()
    expect(active).not_to_contain_text("host_close")
