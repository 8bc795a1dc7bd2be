"""The companion in a browser: the chapter of the SAC's manual, step by step, against a twin."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_pages import Bench, companion_bench
from playwright.sync_api import Browser, Page, expect

SPEED = 20
# Rows in the form in which the companion program saves them: slow ones to loop over, then others.
LINES = [
    " 1 , 800 , 0 , 1 , 150 , 2000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
    " 2 , 600 , 1 , 1 , 50 , 6000 , 0 , 1 , 1 , 0 , 0 , 3000 ",
    " 3 , 3000 , 0 , 1 , 20 , 15000 , 0 , 1 , 1 , 0 , 0 , 0 ",
    " 4 , 3000 , 1 , 1 , 20 , 15000 , 0 , 1 , 1 , 0 , 0 , 0 ",
    " 5 , 3000 , 0 , 1 , 20 , 15000 , 1 , 10.47 , .5 , 0 , 0 , 0 ",
    *(f" {place} , {place}00 , 0 , 1 , 69 , 4321 , 0 , .5 , 999 , 3 , 0 , 0 " for place in range(6, 31)),
]
QUEUE = "".join(f"{line}\r\n" for line in LINES).encode()
SHOTS = b"xm4000v20a999d999\r\n\r\nv159\r\n" + b"\r\n" * 97


@pytest.fixture
def bench(chromium: Browser) -> Iterator[Bench]:
    yield from companion_bench(chromium, SPEED)


@pytest.fixture
def page(bench: Bench) -> Page:
    page = bench.open("companion/s1")
    expect(page.get_by_text("as in the board")).to_be_visible()
    return page


def cell(page: Page, row: int, column: str) -> str:
    return page.get_by_label(f"Row {row} {column}", exact=True).input_value()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def type_line(page: Page, line: str) -> None:
    page.get_by_label("Command", exact=True).fill(line)
    page.get_by_label("Command", exact=True).press("Enter")


def choose(page: Page, label: str, name: str, content: bytes) -> None:
    file = {"name": name, "mimeType": "text/plain", "buffer": content}
    page.locator(f"input[type=file][aria-label='{label}']").set_input_files(file)  # type: ignore[arg-type]


def saved(page: Page, name: str) -> bytes:
    with page.expect_download() as waiting:
        button(page, name)
    return Path(waiting.value.path()).read_bytes()


def sent(page: Page, line: str) -> None:
    expect(
        page.get_by_label("Commands that were sent, the last first").get_by_text(line, exact=True)
    ).to_be_visible()


def running(page: Page, row: int) -> None:
    expect(page.locator("tr[aria-current=step] .row-head")).to_have_text(re.compile(rf"^▶{row}\D?$"))


def load(page: Page) -> None:
    choose(page, "Load queue file", "queue.txt", QUEUE)
    expect(page.get_by_label("Row 3 Steps", exact=True)).to_have_value("3000")
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_files_go_to_the_board_and_come_back_byte_for_byte(page: Page, bench: Bench) -> None:
    load(page)
    choose(page, "Load one-shots", "oneShot.txt", SHOTS)
    assert saved(page, "Save queue file") == QUEUE
    assert saved(page, "Save one-shots") == SHOTS
    button(page, "Store")
    expect(page.get_by_text("The board's queue is in its EEPROM")).to_be_visible()
    page.goto("about:blank")  # the port is free for others
    assert bench.saved_queue() == QUEUE


def test_a_bad_file_is_told_with_its_place_and_changes_nothing(page: Page) -> None:
    before = cell(page, 3, "Steps")
    choose(page, "Load queue file", "queue.txt", QUEUE.replace(b" 3000 ", b" x ", 2)[:-40])
    expect(page.get_by_text('queue.txt:1:53: deltaT is "x"; write a whole number')).to_be_visible()
    choose(page, "Load one-shots", "shots.txt", b"v159\r\nxm12")
    expect(page.get_by_text("shots.txt:2:5: the file ends in the middle of one-shot 2")).to_be_visible()
    assert cell(page, 3, "Steps") == before
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_the_queue_is_edited(page: Page) -> None:
    load(page)
    # The line that the manual's companion sends for a row, typed at the command line.
    type_line(page, "q9m-2000vc1500a1d1l0pu0s0t0")
    expect(page.get_by_label("Row 9 direction: CCW")).to_be_visible()
    expect(page.get_by_label("Row 9 unit: + pulse")).to_be_visible()
    assert cell(page, 9, "Steps") == "-2000"
    # A cell: RPM and cycle follow each other.
    rpm = page.get_by_label("Row 6 RPM in rpm", exact=True)
    rpm.fill("70")
    rpm.press("Enter")
    expect(page.get_by_label("Row 6 Cycle in us", exact=True)).to_have_value("4285")
    sent(page, "q6m600v70a.5d999l0fu3s0t0")
    rpm.fill("0")
    rpm.press("Tab")
    expect(page.get_by_text("Row 6: RPM is 0; 1 is the least")).to_be_visible()
    expect(rpm).to_have_value("70")
    # Rows: inserted, deleted, moved, copied, and all taken back.
    page.get_by_label(re.compile("^Row 7(,|$)")).click()
    page.get_by_label("Insert a row above row 7").click()
    expect(page.get_by_label("Row 7 Steps", exact=True)).to_have_value("200")
    expect(page.get_by_label("Row 8 Steps", exact=True)).to_have_value("700")
    page.get_by_label("Delete row 7").click()
    expect(page.get_by_label("Row 7 Steps", exact=True)).to_have_value("700")
    page.get_by_label("Copy row 7").click()
    page.get_by_label(re.compile("^Row 10(,|$)")).click()
    page.get_by_label("Paste over row 10").click()
    expect(page.get_by_label("Row 10 Steps", exact=True)).to_have_value("700")
    page.get_by_label(re.compile("^Row 10(,|$)")).press("Alt+ArrowUp")
    expect(page.get_by_label("Row 9 Steps", exact=True)).to_have_value("700")
    expect(page.get_by_label("Row 10 Steps", exact=True)).to_have_value("-2000")
    page.get_by_label("Undo the last change").click()
    page.get_by_label("Undo the last change").click()
    expect(page.get_by_label("Row 10 Steps", exact=True)).to_have_value("1000")
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_offline_edits_wait_for_update(page: Page) -> None:
    page.get_by_label("Offline").check()
    steps = page.get_by_label("Row 2 Steps", exact=True)
    steps.fill("-777")
    steps.press("Enter")
    expect(page.get_by_text("1 not sent")).to_be_visible()
    button(page, "Update queue")
    sent(page, "q2m-777v100a1d1l0fu0s0t0")
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_a_loop_runs_with_its_row_marked_and_its_times(page: Page) -> None:
    load(page)
    button(page, "Ops off")
    expect(page.get_by_role("button", name="Ops on")).to_be_visible()
    # Both ends are registered by a double click in their boxes; the second begins the loop.
    for label, value in (("Start", "3"), ("Finish", "4")):
        page.get_by_label(label, exact=True).fill(value)
        page.get_by_label(label, exact=True).dblclick()
    sent(page, "ls3")
    sent(page, "lf4")
    running(page, 3)
    running(page, 4)
    # An end is moved while it runs.
    page.get_by_label("Finish", exact=True).fill("5")
    page.get_by_label("Finish", exact=True).press("Enter")
    running(page, 5)
    running(page, 3)
    took = page.get_by_role("region", name="Times of commands").locator("tbody tr").nth(1).locator("td")
    expect(took.nth(1)).to_have_text("row 5")
    expect(took.nth(3)).to_have_text(re.compile(r"^\d+\.\d{3} s$"))
    button(page, "Finish loop")
    sent(page, "l")
    expect(page.locator("tr[aria-current=step]")).to_have_count(0)


def test_stops_and_next(page: Page) -> None:
    load(page)
    button(page, "Ops off")
    expect(page.get_by_role("button", name="Ops on")).to_be_visible()
    page.get_by_label("Start", exact=True).fill("3")
    page.get_by_label("Finish", exact=True).fill("5")
    button(page, "Start loop")
    running(page, 3)
    button(page, "NEXT")
    running(page, 4)
    button(page, "next")
    running(page, 5)
    button(page, "STOP")
    expect(page.locator("tr[aria-current=step]")).to_have_count(0)
    for line in ("N", "n", "S"):
        sent(page, line)


def test_one_shots_and_continuous_motion(page: Page) -> None:
    choose(page, "Load one-shots", "oneShot.txt", SHOTS)
    button(page, "Ops off")
    expect(page.get_by_role("button", name="Ops on")).to_be_visible()
    page.get_by_label("Send one-shot 1", exact=True).click()
    sent(page, "xm4000v20a999d999")
    expect(page.get_by_text("one-shot runs", exact=True)).to_be_visible()
    expect(page.get_by_text("one-shot runs", exact=True)).to_have_count(0)
    button(page, "CW")
    expect(page.get_by_text("continuous runs", exact=True)).to_be_visible()
    page.get_by_label("Velocity in RPM").fill("150")
    sent(page, "v150")
    type_line(page, "vd")
    expect(page.get_by_label("Incoming", exact=True)).to_contain_text("150\t2000")
    button(page, "stop")
    expect(page.get_by_text("continuous runs", exact=True)).to_have_count(0)


def test_a_calibration_takes_a_minute_of_the_board(page: Page) -> None:
    page.get_by_label("Calibrate at 160 RPM", exact=True).click()
    expect(page.get_by_label("Calibration at 160 RPM")).to_be_visible()
    caption = page.get_by_label(re.compile("^Calibrate at 160 RPM: factor"))
    expect(caption).to_be_visible()
    # The bench runs faster than the clock of the browser: by so much the board's is fast.
    assert float(caption.inner_text()) == pytest.approx(1 / SPEED, rel=0.5)
    expect(page.get_by_role("button", name="Ops off")).to_be_visible()


def test_two_pages_see_the_same(page: Page, bench: Bench) -> None:
    other = bench.open("companion/s1")
    expect(other.get_by_text("as in the board")).to_be_visible()
    steps = page.get_by_label("Row 4 Steps", exact=True)
    steps.fill("1234")
    steps.press("Enter")
    expect(other.get_by_label("Row 4 Steps", exact=True)).to_have_value("1234")


def test_a_phone_and_the_keyboard(page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    steps = page.get_by_label("Row 1 Steps", exact=True)
    steps.focus()
    steps.press("ArrowDown")
    expect(page.get_by_label("Row 2 Steps", exact=True)).to_be_focused()
