"""Plots in a browser: signals of several devices, triggers, x-y plots, what is before the page."""

import csv
import io
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from browser_pages import Bench, served, violations
from e2e_support import READY_NS, until
from playwright.sync_api import Browser, Page, expect

from device_profiles.sac.packet import encode

SPEED = 4
SEGMENTS = {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}}
SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    devices = {"m1": SERVO, "m2": SERVO, "s1": {"profile": "sac", "flash": {}}}
    with served(chromium, {"bench": "t", "speed": SPEED, "devices": devices, "segments": SEGMENTS}) as bench:
        for name in ("m1", "m2"):
            bench.server.ready(name, boot_ns=READY_NS)
            bench.server.ask("do", device=name, name="enable", parameters={})
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def opened(pages: Bench, name: str = "m1") -> Page:
    """Open the plots of an axis, and wait until they have samples."""
    page = pages.open(f"bench/{name}")
    expect(page.locator(".trace-value").first).to_have_text(re.compile(r"\d"))
    return page


def move(pages: Bench, name: str, position_deg: float) -> None:
    parameters = {"position_deg": position_deg, "velocity_rpm": 120}
    pages.server.ask("do", device=name, name="move_abs", parameters=parameters)


def add_of(page: Page, other: str, field: str) -> None:
    """Draw a field of another device, too."""
    page.get_by_role("button", name=re.compile(r"^Fields \(")).click()
    page.get_by_label("and of").select_option(other)
    page.get_by_label(re.compile(rf"^{other}\.{field}\b")).check()
    page.keyboard.press("Escape")
    expect(page.get_by_role("group", name="Fields to draw")).to_be_hidden()


def test_fields_of_several_devices_have_axes_and_figures(pages: Bench) -> None:
    page = opened(pages)
    add_of(page, "m2", "velocity_rpm")
    page.get_by_role("button", name=re.compile(r"^Fields \(")).click()
    for name in ("velocity_rpm", "m2.velocity_rpm"):
        page.get_by_label(f"Axis of {name}", exact=True).select_option("deg")
    page.keyboard.press("Escape")
    legend = page.locator(".pane-legend", has_text="Board's angle")
    expect(legend).to_contain_text("m2.velocity_rpm right (rpm)")
    since_ns = pages.server.ask("status")["sim_ns"]
    move(pages, "m2", 90)
    until(
        lambda: pages.server.ask("status")["sim_ns"] > since_ns + 6e9,
        "samples of m2 in the half of the window between the cursors",
    )
    button(page, "Pause")
    over = page.locator(".u-over").first
    box = over.bounding_box()
    assert box
    over.click(position={"x": box["width"] * 0.5, "y": 20})
    over.click(position={"x": box["width"] * 0.9, "y": 20}, modifiers=["Shift"])
    cursors = page.get_by_role("region", name="Values at the cursors")
    heads = [each.inner_text() for each in cursors.get_by_role("columnheader").all()]
    assert heads == ["field", "A", "B", "B − A", "slope /s", "mean", "min", "max", "rms", "unit"]
    row = cursors.get_by_role("row", name="m2.velocity_rpm").get_by_role("cell")
    for column in (5, 6, 7):
        expect(row.nth(column)).to_have_text(re.compile(r"\d"))
    with page.expect_download() as waiting:
        button(page, "CSV, all steps")
    rows = list(csv.DictReader(io.StringIO(Path(waiting.value.path()).read_text())))
    times_s = [float(each["at_s"]) for each in rows]
    assert all(earlier < later for earlier, later in pairwise(times_s))
    assert any(
        each["m2.velocity_rpm [rpm]" if "m2.velocity_rpm [rpm]" in each else "m2.velocity_rpm"]
        for each in rows
    )
    assert violations(page) == []
    # What was chosen is there after a reload.
    page.reload()
    expect(legend).to_contain_text("m2.velocity_rpm right (rpm)")


def test_a_trigger_holds_the_picture_about_an_edge(pages: Bench) -> None:
    move(pages, "m1", 0)
    page = opened(pages)
    page.get_by_label("Shown time").select_option("0.5 s")
    button(page, "Trigger")
    bar = page.get_by_role("group", name="Trigger", exact=True)
    bar.get_by_label("Field of the trigger").select_option("m1.yw")
    bar.get_by_label("Level", exact=True).fill("nothing")
    bar.get_by_label("Hysteresis").fill("2")
    expect(bar.get_by_label("Level", exact=True)).to_have_attribute("aria-invalid", "true")
    bar.get_by_label("Level", exact=True).fill("45")
    bar.get_by_label("Before").fill("40")
    button(page, "Arm")
    state = bar.get_by_role("status")
    expect(state).to_have_text("waiting")
    move(pages, "m1", 90)
    expect(state).to_have_text(re.compile(r"^triggered at [\d.]+ s, ±0\.5 ms$"))
    expect(page.get_by_role("button", name="Paused")).to_be_visible()
    # The recording has each control step of it.
    expect(page.locator(".pane-range").first).to_contain_text("/s")
    at_s = float(re.findall(r"at ([\d.]+) s", state.inner_text())[0])
    with page.expect_download() as waiting:
        button(page, "CSV")
    rows = list(csv.DictReader(io.StringIO(Path(waiting.value.path()).read_text())))
    angles = [(float(row["at_s"]), float(row["yw [deg]"])) for row in rows]
    assert angles[0][0] == pytest.approx(at_s - 0.2, abs=0.01)
    assert angles[-1][0] == pytest.approx(at_s + 0.3, abs=0.01)
    [crossed_s] = [later[0] for row, later in pairwise(angles) if row[1] < 45 <= later[1]]
    assert crossed_s == pytest.approx(at_s, abs=0.002)
    move(pages, "m1", 0)
    # A fault is one, too.
    bar.get_by_label("Trigger on").select_option("fault")
    expect(state).to_have_text("waiting")
    pages.server.ask("inject", target="m1", fault="byte_drop", parameters={"rate": 0.1})
    expect(state).to_have_text(re.compile(r"^triggered at [\d.]+ s$"))
    pages.server.ask("clear", number="all")
    # So is a packet with some words, and no other.
    bar.get_by_label("Trigger on").select_option("packet")
    bar.get_by_label("Words of the packet").fill("m99")
    bar.get_by_label("Before").fill("0")
    expect(state).to_have_text("waiting")
    pages.server.ask("play", tap="bus0.master", bursts=[[0, encode(85, 1, b"m99").hex()]])
    expect(state).to_have_text(re.compile(r"^triggered at [\d.]+ s$"))
    button(page, "Trigger off")
    expect(state).to_be_empty()


def test_a_field_is_drawn_over_another(pages: Bench) -> None:
    page = opened(pages)
    add_of(page, "m2", "yw")
    button(page, "X-Y")
    page.get_by_label("Field to the right").select_option("m1.yw")
    page.get_by_label("Field upwards").select_option("m2.yw")
    page.get_by_label("equal scales").check()
    plot = page.get_by_role("img", name="m2.yw over m1.yw")
    before = plot.screenshot()
    move(pages, "m1", 60)
    move(pages, "m2", -60)
    expect(page.locator(".trace", has_text="m1.yw").locator(".trace-value")).to_have_text(
        re.compile("^60|^59")
    )
    assert plot.screenshot() != before
    plot.click(position={"x": 200, "y": 150})
    cursors = page.get_by_role("region", name="Values at the cursors")
    expect(cursors.get_by_role("row", name="time").get_by_role("cell").first).to_have_text(re.compile(r"\d"))
    assert violations(page) == []
    page.reload()
    expect(plot).to_be_visible()


def test_a_plot_goes_back_beyond_what_the_page_has(pages: Bench) -> None:
    page = opened(pages)
    page.get_by_label("Shown time").select_option("5 s")
    banner = page.get_by_role("button", name="Back to live")
    expect(page.get_by_role("region", name="Time line of the run")).to_be_visible()
    panes = page.get_by_role("group", name=re.compile("^Plots"))
    panes.focus()
    page.keyboard.press("PageUp")  # the page was opened a moment ago: all before it is recorded
    panes.hover()
    page.mouse.wheel(-2000, 0)  # further back than the page was open
    expect(banner).to_be_visible()
    expect(page.locator(".pane-range").first).to_contain_text(re.compile(r"/s|min/max"))
    at = page.locator(".past-banner .mono")
    before = at.inner_text()
    axis = page.locator(".has-times .u-axis").first
    box = axis.bounding_box()
    assert box
    axis.hover()
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.5 + 150, box["y"] + 5, steps=3)
    page.mouse.up()
    expect(at).not_to_have_text(before)
    panes.focus()
    page.keyboard.press("Home")
    expect(banner).to_be_hidden()
