"""The bench view in a browser: plots, terminals, verbs, gains and pins of boards of all kinds."""

import csv
import io
import re
import struct
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from browser_pages import DESK, PHONE, Bench, fits, served
from e2e_support import READY_NS, until
from playwright.sync_api import Browser, Page, expect

SPEED = 4
DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "s1": {"profile": "sac", "flash": {}},
    "u1": {"profile": "uno"},
    "d1": {"profile": "easydriver"},
    "w1": {"profile": "walter"},
}
PAGE_BYTES = 400_000
"""Maximum size of the page as it is sent."""


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, {"bench": "t", "speed": SPEED, "devices": DEVICES}) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def verb(page: Page, name: str, **given: str) -> None:
    """Carry out a verb by its form, and wait for the bench's answer."""
    tab(page, "Verbs")
    page.get_by_role("group", name="Verbs").get_by_role("button", name=name, exact=True).click()
    form = page.locator("form.parameters")
    for parameter, value in given.items():
        form.get_by_label(parameter, exact=True).fill(value)
    form.get_by_role("button", name=name, exact=True).click()
    expect(page.get_by_role("status").get_by_text(re.compile(f"^m1 {name}: ")).first).to_be_visible()


def plotted(page: Page, field: str) -> float:
    """Value that stands beside a field's name in the plots."""
    value = page.locator(".trace", has_text=field).locator(".trace-value")
    expect(value).to_have_text(re.compile(r"\d"))
    return float(value.inner_text().replace("−", "-"))


def picture(page: Page) -> bytes:
    """What the first plot shows."""
    return page.locator(".pane-plot").first.screenshot()


def test_all_boards_are_shown_with_state_and_position(pages: Bench) -> None:
    asked: list[str] = []
    page = pages.open("bench")
    page.on("request", lambda request: asked.append(request.url))
    cards = page.get_by_role("list", name="Cards of the bench").locator(".device")
    expect(cards).to_have_count(5 + 6)  # Walter has seven axes
    for name in DEVICES:
        card = page.get_by_role("article", name=name, exact=True)
        expect(card).to_contain_text("ok")
    # Several axes are watched at once, and all of them are heard.
    for name in ("m1", "s1", "d1", "w1.gripper"):
        expect(page.get_by_role("article", name=name, exact=True).locator(".reading").first).to_have_text(
            re.compile(r"\d")
        )
    page.reload()
    expect(cards).to_have_count(11)
    assert asked
    assert all(url.startswith(pages.url) for url in asked)
    sizes = page.evaluate("performance.getEntriesByType('resource').map((each) => each.encodedBodySize)")
    assert 0 < sum(sizes) < PAGE_BYTES


def test_all_tabs_of_all_kinds_of_boards(pages: Bench) -> None:
    page = pages.open("bench")
    for name in ("m1", "s1", "u1", "d1", "w1", "w1.gripper"):
        page.goto(f"{pages.url}#/bench/{name}")
        expect(page.get_by_role("heading", name=name, exact=True)).to_be_visible()
        for each in page.get_by_role("tab").all():
            each.click()
            expect(page.get_by_role("tabpanel")).not_to_be_empty()
        expect(page.locator(".problem")).to_have_count(0)


def test_a_plot_moves_with_the_shaft(pages: Bench) -> None:
    page = pages.open("bench/m1")
    verb(page, "enable")
    before = picture(page)
    verb(page, "move_abs", position_deg="90", velocity_rpm="120")
    value = page.locator(".trace", has_text="position_deg").locator(".trace-value")
    expect(value).to_have_text(re.compile(r"^(89\.9|90\.0)\d?$"))
    assert picture(page) != before
    verb(page, "move_abs", position_deg="-45", velocity_rpm="120")
    expect(value).to_have_text(re.compile(r"^−(44\.9|45\.0)\d?$"))


def test_a_plot_is_paused_zoomed_and_measured(pages: Bench) -> None:
    page = pages.open("bench/m1")
    plotted(page, "position_deg")
    button(page, "Pause")
    expect(page.get_by_role("button", name="Paused")).to_be_visible()
    still = picture(page)
    page.wait_for_timeout(300)
    assert picture(page) == still
    button(page, "Zoom in")
    assert picture(page) != still
    over = page.locator(".u-over").first
    box = over.bounding_box()
    assert box
    over.click(position={"x": box["width"] * 0.25, "y": 20})
    over.click(position={"x": box["width"] * 0.75, "y": 20}, modifiers=["Shift"])
    cursors = page.get_by_role("region", name="Values at the cursors")
    row = cursors.get_by_role("row", name="time").get_by_role("cell")
    a, b, between = (float(row.nth(column).inner_text()) for column in range(3))
    assert between == pytest.approx(b - a, abs=2e-4)
    assert between == pytest.approx(2.5, rel=0.05)  # half of 10 s, zoomed in once
    expect(cursors.get_by_role("row", name="position_deg").get_by_role("cell").first).to_have_text(
        re.compile(r"\d")
    )
    # A drag shows its part; a double click is back at the present.
    over.hover(position={"x": box["width"] * 0.25, "y": 20})
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.5, box["y"] + 20, steps=4)
    page.mouse.up()
    zoomed = picture(page)
    assert zoomed != still
    over.dblclick(position={"x": box["width"] * 0.5, "y": 20})
    expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
    # The same by the keyboard.
    page.get_by_role("group", name=re.compile("^Plots")).focus()
    page.keyboard.press(" ")
    expect(page.get_by_role("button", name="Paused")).to_be_visible()
    before = row.nth(0).inner_text()
    page.keyboard.press("ArrowRight")
    expect(row.nth(0)).not_to_have_text(before)
    page.keyboard.press("Home")
    expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()


def test_plots_are_saved(pages: Bench) -> None:
    page = pages.open("bench/m1")
    plotted(page, "position_deg")
    button(page, "Pause")
    with page.expect_download() as waiting:
        button(page, "CSV")
    assert waiting.value.suggested_filename == "m1.csv"
    rows = list(csv.reader(io.StringIO(Path(waiting.value.path()).read_text())))
    assert rows[0][0] == "at_s"
    assert {"position_deg", "velocity_rpm", "torque_Nm", "current_a_A"} <= set(rows[0])
    times_s = [float(row[0]) for row in rows[1:]]
    assert len(times_s) > 10
    assert all(0 < later - earlier < 1 for earlier, later in pairwise(times_s))
    with page.expect_download() as waiting:
        button(page, "PNG")
    png = Path(waiting.value.path()).read_bytes()
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", png[16:24])
    assert width > 500
    assert height > 400


def test_a_fast_current_is_not_drawn_as_a_slow_one(pages: Bench) -> None:
    def told(name: str) -> float:
        value: float = pages.server.ask("state", device="m1")[name]
        return value

    page = pages.open("bench/m1")
    plotted(page, "position_deg")
    page.get_by_label("Shown time").select_option("1 s")
    verb(page, "enable")
    verb(page, "velocity", velocity_rpm="60")
    try:
        until(lambda: abs(told("velocity_rpm") - 60) < 8, "its speed")
        begin_ns = told("at_ns")
        until(lambda: told("at_ns") > begin_ns + 2e9, "two seconds")
        expect(page.locator(".pane-range").first).to_contain_text("min/max of 1 ms")
        expect(page.locator(".pane-legend", has_text="Velocity")).to_contain_text(re.compile(r"r 60\.0"))
        button(page, "Pause")
        with page.expect_download() as waiting:
            button(page, "CSV")
    finally:
        pages.server.ask("do", device="m1", name="mode", parameters={"mode": "position"})
    rows = list(csv.DictReader(io.StringIO(Path(waiting.value.path()).read_text())))
    assert {row["sampling"] for row in rows} == {"min/max of 1 ms"}
    assert 1900 <= len(rows) <= 2010
    current_A = [(float(row["at_s"]), float(row["current_a_A"])) for row in rows]
    ups = [later[0] for row, later in pairwise(current_A) if row[1] < 0 <= later[1]]
    assert (len(ups) - 1) / (ups[-1] - ups[0]) == pytest.approx(50, rel=0.05)


def test_a_range_of_values_stays(pages: Bench) -> None:
    page = pages.open("bench/m1")
    plotted(page, "position_deg")
    fixed = page.get_by_role("button", name=re.compile("fixed range of velocity"))
    fixed.click()
    expect(fixed).to_have_attribute("aria-pressed", "true")
    lower = page.get_by_label("Lower end of the velocity shown")
    lower.fill("100")
    page.get_by_label("Upper end of the velocity shown").focus()
    expect(lower).to_have_attribute("aria-invalid", "true")
    lower.fill("-20")
    page.get_by_label("Upper end of the velocity shown").focus()
    expect(lower).to_have_attribute("aria-invalid", "false")
    fixed.click()
    expect(lower).to_have_count(0)


def test_fields_of_a_plot_are_chosen(pages: Bench) -> None:
    page = pages.open("bench/m1")
    plotted(page, "position_deg")
    button(page, "Fields (8)")
    page.get_by_label(re.compile("^yw")).check()
    expect(page.locator(".trace", has_text=re.compile("^yw"))).to_be_visible()
    page.get_by_label(re.compile("^torque_Nm")).uncheck()
    expect(page.locator(".trace", has_text=re.compile("^torque_Nm"))).to_have_count(0)


def test_forms_have_the_tables_units_and_limits(pages: Bench) -> None:
    page = pages.open("bench/m1")
    page.get_by_role("group", name="Verbs").get_by_role("button", name="move_abs", exact=True).click()
    form = page.locator("form.parameters")
    velocity = form.get_by_label("velocity_rpm", exact=True)
    expect(form).to_contain_text("rpm")
    velocity.fill("1e9")
    expect(velocity).to_have_attribute("aria-invalid", "true")
    form.get_by_role("button", name="move_abs").click()
    expect(form.get_by_role("alert").first).to_be_visible()
    expect(form.get_by_label("position_deg", exact=True)).to_be_focused()  # the first that is wrong
    # What the board refuses is told in the bench's words.
    form.get_by_label("position_deg", exact=True).fill("10")
    velocity.fill("60")
    verb(page, "disable")
    page.get_by_role("group", name="Verbs").get_by_role("button", name="position", exact=True).click()
    form.get_by_label("position_deg", exact=True).fill("10")
    form.get_by_role("button", name="position", exact=True).click()
    expect(page.locator(".notice.is-error")).to_contain_text("control loop is off")


def test_a_step_response_is_drawn_before_and_after_new_gains(pages: Bench) -> None:
    page = pages.open("bench/m1")
    tab(page, "Gains")
    gain = page.get_by_label(re.compile(r"^pKp, now 15"))
    expect(gain).to_be_visible()
    gain.fill("40")
    button(page, "Step, set gains, step again")
    table = page.locator(".gains table")
    expect(table.get_by_role("row", name=re.compile("^after (?!−)"))).to_be_visible()
    rows = [table.get_by_role("row", name=re.compile(f"^{row} (?!−)")) for row in ("before", "after")]
    before, after = (row.get_by_role("cell").nth(1).inner_text() for row in rows)
    assert before != after
    expect(page.get_by_role("img", name=re.compile("^Step responses"))).to_be_visible()
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
    page.set_viewport_size(DESK)
    expect(page.get_by_label(re.compile(r"^pKp, now 40"))).to_be_visible()
    page.get_by_label(re.compile("^pKp")).fill("15")
    button(page, "Set gains")
    expect(page.get_by_label(re.compile(r"^pKp, now 15"))).to_be_visible()


def test_pins_are_seen_and_driven(pages: Bench) -> None:
    page = pages.open("bench/u1")
    tab(page, "Pins")
    level = page.get_by_role("listitem").filter(has_text=re.compile("^D2")).locator(".pin-level")
    expect(level).to_have_text("0")
    button(page, "D2 to 1")
    expect(level).to_have_text("1")
    button(page, "D2 to 0")
    expect(level).to_have_text("0")
