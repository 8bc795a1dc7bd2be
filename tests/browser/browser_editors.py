"""Editors of runs, programs and machines: completion, checks as one types, undo, files, long texts."""

import re
from collections.abc import Iterator
from typing import Any

import pytest
from browser_pages import DESK, PHONE, Bench, editor, fits, served, shows, violations, write
from e2e_support import READY_NS
from playwright.sync_api import Browser, Page, expect

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
RUN = "Run, as YAML or JSON"
LONG_LINES = 45_000
DROP = """(area, text) => {
  const data = new DataTransfer();
  data.items.add(new File([text], "dropped.yaml"));
  area.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));
}"""


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    devices = {"m1": SERVO, "m2": SERVO, "s1": {"profile": "sac", "flash": {}}}
    with served(chromium, {"bench": "t", "speed": 4, "devices": devices}) as bench:
        for name in ("m1", "m2"):
            bench.server.ready(name, boot_ns=READY_NS)
            bench.server.ask("do", device=name, name="enable", parameters={})
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def offered(page: Page, name: str) -> Any:
    return page.get_by_role("option", name=re.compile(rf"^{name}"))


def test_a_new_bench_begins_with_a_run_that_is_drawn_and_started(pages: Bench) -> None:
    page = pages.open("runs")
    expect(page.get_by_text("run example, 3 steps, no problems")).to_be_visible()
    steps = page.get_by_role("list", name="Steps over time").get_by_role("listitem")
    expect(steps).to_have_count(3)
    expect(page.get_by_role("img", name="Planned set-points over time").locator("path")).to_have_count(2)
    steps.nth(2).get_by_role("button").click()
    expect(page.locator(".cm-activeLine").last).to_contain_text("move_by: {m1: -90, m2: 90}")
    start = page.get_by_role("button", name="Start", exact=True)
    expect(start).to_have_class("primary")
    start.click()
    card = page.get_by_role("article", name="Run example", exact=True)
    expect(card.locator(".pill")).to_have_text("done")
    card.get_by_text("Following error", exact=True).click()
    errors = card.get_by_role("img", name="Following error of example")
    expect(errors.locator("path")).to_have_count(2)
    expect(card.get_by_text(re.compile(r"at most \d+\.\d+ deg")).first).to_be_visible()
    assert violations(page) == []


def test_what_may_stand_at_a_place_is_offered_and_explained(pages: Bench) -> None:
    page = pages.open("runs")
    text = editor(page, RUN)
    write(page, RUN, "run: r\naxes:\n  s1: {}\nsteps:\n- ")
    text.press("ControlOrMeta+End")
    text.press("Control+Space")
    expect(offered(page, "wait_until")).to_be_visible()
    page.keyboard.type("mov")
    expect(offered(page, "move_by")).to_be_visible()
    text.press("Escape")
    page.keyboard.type("e: ")
    text.press("Control+Space")
    expect(offered(page, "s1")).to_be_visible()
    text.press("Escape")
    for _ in range(3):
        text.press("ArrowLeft")
    # The word at the cursor is explained below the text.
    expect(page.get_by_text("move: Axes to angles; they begin and end together.")).to_be_visible()
    expect(page.get_by_role("list", name="Problems of the run").get_by_role("listitem").first).to_be_visible()
    assert violations(page) == []


def test_undo_outlives_the_view_and_tab_leaves_by_escape(pages: Bench) -> None:
    page = pages.open("runs")
    expect(page.get_by_text("no problems")).to_be_visible()
    write(page, RUN, "run: mine\n")
    page.goto(f"{pages.url}#/faults")
    expect(page.get_by_role("heading", name="Active faults")).to_be_visible()
    page.goto(f"{pages.url}#/runs")
    text = editor(page, RUN)
    shows(page, RUN, "run: mine\n")
    for _ in range(3):
        text.press("ControlOrMeta+z")
    expect(text).to_contain_text("move_by: {m1: 90, m2: -90}")
    text.press("Tab")
    expect(text).to_be_focused()
    text.press("Escape")
    text.press("Tab")
    expect(text).not_to_be_focused()
    text.evaluate(DROP, "run: dropped\n")
    expect(page.get_by_text("dropped.yaml")).to_be_visible()
    shows(page, RUN, "run: dropped\n")


def test_words_of_a_program_are_explained_and_it_is_checked_as_it_is_typed(pages: Bench) -> None:
    page = pages.open("path")
    expect(page.get_by_text(re.compile(r"mm at a feed, [\d.]+ s, no problems"))).to_be_visible()
    write(page, "Program", "G21 G90 F300\nG81 X1\nM2\n")
    problems = page.get_by_role("list", name="Problems of the program")
    expect(problems.get_by_role("listitem").first).to_contain_text("2:1")
    program = editor(page, "Program")
    program.press("F8")
    expect(page.locator(".code-editor-place").first).to_contain_text(
        "G81: canned cycle: drilling (motion); refused here"
    )
    expect(page.get_by_role("button", name="Start", exact=True)).not_to_have_class("primary")
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
    assert violations(page) == []
    page.set_viewport_size(DESK)


def test_a_program_of_45000_lines_is_opened_planned_and_drawn(pages: Bench) -> None:
    page = pages.open("path")
    expect(editor(page, "Program")).to_be_visible()
    lines = (f"G1X{number % 97 / 10:.1f}Y{number % 89 / 10:.1f}" for number in range(LONG_LINES))
    text = "\n".join(["G21 G90 G64 P0.01 F3000", *lines, "M2\n"])
    file = {"name": "long.ngc", "mimeType": "text/plain", "buffer": text.encode()}
    page.get_by_label("Open a file: Program").set_input_files([file])
    expect(page.get_by_text(re.compile(r"^[\d,]+ of 1,047,576 bytes that the bench takes"))).to_be_visible()
    page.get_by_role("button", name="Check", exact=True).click()
    figures = page.get_by_role("region", name="Figures of the drawing")
    expect(figures).to_contain_text(f"{LONG_LINES + 2} lines")


def test_completion_and_checks_follow_a_bench_that_is_reloaded(pages: Bench) -> None:
    page = pages.open("runs")
    write(page, RUN, "run: r\naxes:\n  m3: {}\nsteps:\n- move: {m3: 9}\n")
    problems = page.get_by_role("list", name="Problems of the run")
    expect(problems).to_contain_text("there is no device 'm3'")
    file = pages.place.folder / "t.yaml"
    before = file.read_text()
    file.write_text(before.replace('"m2"', '"m3"'))
    try:
        pages.server.ask("reload")
        expect(problems).not_to_contain_text("there is no device 'm3'")
        shows(page, RUN, "run: r\naxes:\n  m3: {}\nsteps:\n- move: {m3: 9}\n")
    finally:
        file.write_text(before)
        pages.server.ask("reload")
