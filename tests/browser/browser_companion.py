"""The companion in a browser: the chapter of the SAC's manual, step by step, against a twin."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_pages import PHONE, Bench, Between, companion_bench, fits, served, violations
from e2e_support import Place, config, free_port
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
FIRST_SHOT = "xm4000v20a999d999"
SHOTS = FIRST_SHOT.encode() + b"\r\n\r\nv159\r\n" + b"\r\n" * 97


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


def load_shots(page: Page) -> None:
    """Load the one-shots. The bench reads the file."""
    choose(page, "Load one-shots", "oneShot.txt", SHOTS)
    expect(page.get_by_label("One-shot 1", exact=True)).to_have_value(FIRST_SHOT)


def test_files_go_to_the_board_and_come_back_byte_for_byte(page: Page, bench: Bench) -> None:
    load(page)
    load_shots(page)
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
    expect(rpm).to_have_value("0")
    rpm.press("Escape")
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
    button(page, "Next now")
    running(page, 4)
    button(page, "Slow next")
    running(page, 5)
    button(page, "Stop now")
    expect(page.locator("tr[aria-current=step]")).to_have_count(0)
    for line in ("N", "n", "S"):
        sent(page, line)


def test_one_shots_and_continuous_motion(page: Page) -> None:
    load_shots(page)
    button(page, "Ops off")
    expect(page.get_by_role("button", name="Ops on")).to_be_visible()
    page.get_by_label("Send one-shot 1", exact=True).click()
    sent(page, FIRST_SHOT)
    expect(page.get_by_text("one-shot runs", exact=True)).to_be_visible()
    expect(page.get_by_text("one-shot runs", exact=True)).to_have_count(0)
    button(page, "CW")
    expect(page.get_by_text("continuous runs", exact=True)).to_be_visible()
    page.get_by_label("Velocity in RPM").fill("150")
    sent(page, "v150")
    type_line(page, "vd")
    expect(page.get_by_label("Incoming", exact=True)).to_contain_text("150\t2000")
    button(page, "Slow stop")
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
    fits(page, 390)
    steps = page.get_by_label("Row 1 Steps", exact=True)
    steps.focus()
    steps.press("ArrowDown")
    expect(page.get_by_label("Row 2 Steps", exact=True)).to_be_focused()


def test_rows_are_edited_by_keys_alone(page: Page) -> None:
    load(page)
    page.get_by_label(re.compile("^Row 6(,|$)")).focus()
    head = page.get_by_role("button", name=re.compile(r"^Row \d+(,|$)")).and_(page.locator(":focus"))
    page.keyboard.press("ArrowDown")
    expect(head).to_have_accessible_name(re.compile("^Row 7"))
    page.keyboard.press("Shift+ArrowDown")  # rows 7 and 8
    page.keyboard.press("Alt+ArrowUp")
    for row, steps in ((6, "700"), (7, "800"), (8, "600")):
        expect(page.get_by_label(f"Row {row} Steps", exact=True)).to_have_value(steps)
    page.keyboard.press("Delete")
    expect(page.get_by_label("Row 6 Steps", exact=True)).to_have_value("600")
    expect(page.get_by_label("Row 7 Steps", exact=True)).to_have_value("900")
    page.keyboard.press("Insert")
    expect(page.get_by_label("Row 6 Steps", exact=True)).to_have_value("200")
    for _ in range(3):
        page.keyboard.press("Control+z")
    expect(page.get_by_label("Row 7 Steps", exact=True)).to_have_value("700")
    steps = page.get_by_label("Row 6 Steps", exact=True)
    steps.focus()
    page.keyboard.type("5")
    page.keyboard.press("Escape")
    expect(steps).to_have_value("600")
    unit = page.get_by_label(re.compile("^Row 6 unit"))
    unit.focus()
    page.keyboard.press("Enter")
    sent(page, "q6m600vc4321a.5d999l0pu3s0t0")
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_what_could_not_be_read_is_read_when_the_line_is_good_again(page: Page, bench: Bench) -> None:
    expect(page.get_by_role("button", name="GAP on")).to_be_visible()
    where = ("--runtime-dir", str(bench.place.runtime))
    lost = (
        "byte_drop",
        "s1",
        "rate=1",
        "towards=client",
        f"for_s={10 * SPEED}",
    )  # longer than two questions wait
    bench.place.hil("fault", "inject", *lost, *where)
    type_line(page, "g")
    expect(page.get_by_text('no answer to "g" within 5 s')).to_be_visible()
    expect(page.get_by_role("button", name="GAP off")).to_be_visible()


def test_what_came_is_enlarged_by_a_click(page: Page) -> None:
    type_line(page, "q")
    incoming = page.get_by_role("log", name="Incoming")
    expect(incoming).to_contain_text("Q is at 1")
    incoming.click()
    large = page.get_by_role("dialog", name="Incoming of s1")
    expect(large).to_contain_text("Q is at 1")
    large.get_by_role("region").dblclick()
    expect(large).to_have_count(0)
    button(page, "Enlarge")
    expect(large).to_be_visible()
    page.keyboard.press("Escape")
    expect(large).to_have_count(0)


def test_rows_of_a_spreadsheet_and_of_a_file_are_pasted(bench: Bench) -> None:
    page = bench.open("companion/s1", permissions=["clipboard-read", "clipboard-write"])
    expect(page.get_by_text("as in the board")).to_be_visible()
    sheet = "1\t4800\t1\t1\t60\t5000\t0\t0.5\t2\t0\t1\t10\n2\t40\t0\t0\t150\t2000\t1\t5\t5\t7\t0\t0\n"
    page.evaluate("(text) => navigator.clipboard.writeText(text)", sheet)
    page.get_by_label("Row 4 Steps", exact=True).focus()
    page.keyboard.press("Control+v")
    sent(page, "q4m-4800v60a.5d2l0fu0s1t10")
    sent(page, "q5m40v150a5d5l1pu7s0t0")
    page.evaluate("(text) => navigator.clipboard.writeText(text)", LINES[0] + "\r\n")
    page.get_by_label(re.compile("^Row 30(,|$)")).click()
    button(page, "Paste over row 30")
    expect(page.get_by_label("Row 30 Steps", exact=True)).to_have_value("800")
    page.evaluate("navigator.clipboard.writeText('12')")  # a number is for its cell
    rpm = page.get_by_label("Row 4 RPM in rpm", exact=True)
    rpm.select_text()
    page.keyboard.press("Control+v")
    rpm.press("Enter")
    expect(page.get_by_label("Row 4 Cycle in us", exact=True)).to_have_value("25000")
    page.evaluate("navigator.clipboard.writeText('1,2,<b>x</b>')")
    page.get_by_label(re.compile("^Row 1(,|$)")).click()
    page.keyboard.press("Control+v")
    expect(page.get_by_text("line 1, column 1: 3 numbers; a row has 12")).to_be_visible()
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_without_signals_the_running_row_is_marked_too(page: Page) -> None:
    load(page)
    expect(page.get_by_role("button", name="Ops off")).to_be_visible()
    page.get_by_label("Start", exact=True).fill("3")
    page.get_by_label("Finish", exact=True).fill("4")
    button(page, "Start loop")
    running(page, 4)
    running(page, 3)
    button(page, "Stop now")
    expect(page.locator("tr[aria-current=step]")).to_have_count(0)


def test_a_list_of_rows_runs(page: Page) -> None:
    load(page)
    button(page, "Ops off")
    expect(page.get_by_role("button", name="Ops on")).to_be_visible()
    page.get_by_placeholder("1 3 7 5").fill("3 5, 4")
    button(page, "Run list")
    for line in ("xp", "0,3", "1,5", "2,4", "3,0", "x", "xl1"):
        sent(page, line)
    running(page, 3)
    button(page, "Stop now")
    page.get_by_label("Row", exact=True).fill("5")
    button(page, "Run row")
    running(page, 5)
    button(page, "Stop now")


def test_two_hundred_stops_without_an_answer_are_one_message(bench: Bench) -> None:
    between: list[Between] = []
    page = bench.open("companion/s2", prepare=lambda page: between.append(Between(page)))
    expect(page.get_by_text("as in the board")).to_be_visible()
    between[0].change = lambda said: None if isinstance(said, bytes) else said
    stop = page.get_by_role("button", name="Stop now", exact=True)
    stop.evaluate("stop => { for (let click = 0; click < 200; click++) stop.click(); }")
    expect(page.locator(".notice")).to_have_text([re.compile('no answer to "S"')])
    expect(page.get_by_label("Commands that were sent, the last first").get_by_text("S")).to_have_count(2)


def test_a_real_board_is_no_different(chromium: Browser) -> None:
    with Place() as far:
        board = {"profile": "sac", "flash": {}}
        far.serve(config(speed=SPEED, devices={"far": board}))
        devices = {"r1": {"profile": "sac", "at": str(far.runtime / "t" / "far")}}
        with served(chromium, {"bench": "t", "devices": devices}) as bench:
            page = bench.open("companion/r1")
            expect(page.get_by_text("as in the board")).to_be_visible()
            load(page)
            assert saved(page, "Save queue file") == QUEUE
            button(page, "Ops off")
            expect(page.get_by_role("button", name="Ops on")).to_be_visible()
            page.get_by_label("Start", exact=True).fill("3")
            page.get_by_label("Finish", exact=True).fill("4")
            button(page, "Start loop")
            running(page, 3)
            running(page, 4)
            button(page, "Stop now")
            expect(page.locator("tr[aria-current=step]")).to_have_count(0)
            took = page.get_by_role("region", name="Times of commands").locator("tbody tr").first
            expect(took.locator("td").nth(3)).to_have_text(re.compile(r"^\d+\.\d{3} s$"))


def test_lost_and_back_with_what_was_on_the_screen(chromium: Browser) -> None:
    board, door = {"profile": "sac", "flash": {}}, {"web": {"listen": free_port()}}
    text = config(speed=SPEED, devices={"s1": board}, bridges=door)
    with served(chromium, json.loads(text)) as bench:
        page = bench.open("companion/s1")
        expect(page.get_by_text("as in the board")).to_be_visible()
        type_line(page, "vd")
        page.get_by_label("Offline").check()
        page.get_by_label("Row 2 Steps", exact=True).fill("-777")
        page.get_by_label("Row 2 Steps", exact=True).press("Enter")
        load_shots(page)
        bench.server.stop()
        expect(page.get_by_role("status", name=re.compile("^Connection: (?!connected)"))).to_be_visible()
        bench.place.serve(text)
        expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()
        expect(page.get_by_text("1 not sent")).to_be_visible()
        expect(page.get_by_role("log", name="Incoming")).to_contain_text("vd")
        assert page.get_by_label("One-shot 1", exact=True).input_value() == FIRST_SHOT
        expect(page.get_by_text("at its prompt")).to_be_visible()
        button(page, "Update queue")
        expect(page.get_by_text("as in the board")).to_be_visible()
        bench.errors.clear()  # Chromium's own, of connections that were refused


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_in_the_way_of_anybody(bench: Bench, scheme: str) -> None:
    page = bench.open("companion/s1", color_scheme=scheme)
    load(page)
    button(page, "Ops off")
    page.get_by_label("Send one-shot 1", exact=True).scroll_into_view_if_needed()
    type_line(page, "m4000v20a999d999")
    running(page, 1)
    assert violations(page) == []
    button(page, "Enlarge")
    assert violations(page) == []
    page.keyboard.press("Escape")
    page.set_viewport_size(PHONE)
    assert violations(page) == []


def test_a_long_file_is_streamed_with_a_pause(page: Page, bench: Bench) -> None:
    rows = (f" {n + 1} , 50 , 0 , 1 , 300 , 1000 , 0 , 999 , 999 , 0 , 0 , 0 \r\n" for n in range(200))
    choose(page, "Load long file", "long.txt", "".join(rows).encode())
    tools = page.get_by_role("toolbar", name="Long file")
    expect(tools).to_contain_text("long.txt: 0 of 200 rows")
    button(page, "Run rows")
    expect(tools).to_contain_text(re.compile(r": [1-9]\d* of 200 rows"))
    button(page, "Pause")
    button(page, "Go on")
    expect(tools).to_contain_text("long.txt: 200 of 200 rows", timeout=60_000)
    assert bench.server.status("s1")["snapshot"]["commanded_deg"] == pytest.approx(200 * 50 * 1.8)
