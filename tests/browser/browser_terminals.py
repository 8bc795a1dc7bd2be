"""Terminals in a browser: clients as any other. They show what comes, and carry out nothing of it."""

import os
import re
import tty
from collections.abc import Iterator
from contextlib import suppress

import pytest
from browser_pages import Bench, served, violations
from e2e_support import SAC_READY_NS, until
from playwright.sync_api import Browser, Locator, Page, expect

DEVICES = {"s1": {"profile": "sac", "flash": {}}, "s2": {"profile": "sac", "ports": {"network": "pty"}}}

IS_COLOURED = """(rows, word) => [...rows.querySelectorAll("span")].some((span) =>
    span.textContent.includes(word) && getComputedStyle(span).color !== getComputedStyle(rows).color)"""

PASTE = """(area, text) => {
    const event = new ClipboardEvent("paste", { clipboardData: new DataTransfer(), bubbles: true });
    event.clipboardData.setData("text/plain", text);
    area.dispatchEvent(event);
}"""


@pytest.fixture(scope="module")
def board() -> Iterator[tuple[int, str]]:
    """A real board, which this test plays: its side of the line, and its address."""
    ours, its = os.openpty()
    tty.setraw(its)
    yield ours, os.ttyname(its)
    os.close(ours)
    os.close(its)


@pytest.fixture(scope="module")
def bench(chromium: Browser, board: tuple[int, str]) -> Iterator[Bench]:
    devices = {**DEVICES, "r1": {"profile": "sac", "at": board[1]}}
    web = {"port": 0, "message_kb": 1}
    with served(chromium, {"bench": "t", "devices": devices, "bridges": {"web": web}}) as bench:
        bench.server.ready("s1", boot_ns=SAC_READY_NS)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def terminal(page: Page, port: str) -> Locator:
    """Open the terminal at a port."""
    page.get_by_role("tab", name="Terminal", exact=True).click()
    if (ports := page.get_by_role("group", name="Ports")).count():
        ports.get_by_role("button", name=port, exact=True).click()
    found = page.get_by_role("group", name=f"Terminal at {port}")
    expect(found.get_by_role("status")).to_contain_text(f"{port}: open")
    return found


def typed(screen: Locator, text: str) -> None:
    keys(screen).press_sequentially(text)


def keys(screen: Locator) -> Locator:
    """Place that takes keys for the board."""
    return screen.get_by_role("textbox", name="Terminal input")


def test_what_is_typed_goes_to_the_board_and_its_answer_comes(pages: Bench) -> None:
    page = pages.open("bench/s1")
    screen = terminal(page, "s1")
    typed(screen, "vd\n")
    expect(screen.locator(".xterm-rows")).to_contain_text("SAC>")
    assert pages.server.status("s1")["clients"] == 1
    page.get_by_role("button", name="Close the port").click()
    until(lambda: pages.server.status("s1")["clients"] == 0, "the port to be closed")
    expect(screen.locator(".xterm-rows")).to_contain_text("SAC>")  # what was shown stays
    page.get_by_role("button", name="Open the port").click()
    expect(screen.get_by_role("status")).to_contain_text("s1: open")


def test_each_uart_of_a_board_has_a_terminal(pages: Bench) -> None:
    page = pages.open("bench/s2")
    typed(terminal(page, "s2"), "vd\n")
    expect(page.locator(".xterm-rows")).to_contain_text("SAC>")
    terminal(page, "s2.network")
    expect(page.locator(".xterm-rows")).not_to_contain_text("SAC>")
    terminal(page, "s2")
    expect(page.locator(".xterm-rows")).to_contain_text("SAC>")  # it was open all the time


def test_what_a_board_sends_is_shown_and_not_carried_out(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    expect(page).to_have_title(title := "t · hil")
    rows = terminal(page, "r1").locator(".xterm-rows")
    os.write(board[0], b"\x1b]0;owned\x07\x1b[2J\x1b[31mred\x1b[0m \xff\xfe\xc3( caf\xc3\xa9 \x9b31m\r\n")
    expect(rows).to_contain_text("\\x1b]0;owned\\x07\\x1b[2Jred ")
    assert rows.evaluate(IS_COLOURED, "red")
    expect(rows).to_contain_text("\\xff\\xfe\\xc3( café \\x9b31m")
    os.write(board[0], "\u202eevil <script>document.title='x'</script>\r\n".encode())
    expect(rows).to_contain_text("\\u202eevil <script>document.title='x'</script>")
    # A character whose bytes come apart is one character.
    os.write(board[0], b"gr\xc3")
    expect(rows).to_contain_text("gr")
    os.write(board[0], b"\xbc\xc3\x9f\r\n")
    expect(rows).to_contain_text("grüß")
    # Questions to the terminal are not answered: the board hears nothing that nobody typed.
    os.write(board[0], b"\x1b[c\x1b[6n\x05\r\nend\r\n")
    expect(rows).to_contain_text("end")
    os.set_blocking(board[0], False)
    with pytest.raises(BlockingIOError):
        os.read(board[0], 100)
    assert page.title() == title


def test_a_flood_of_a_board_is_shown_and_the_page_stays(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    rows = terminal(page, "r1").locator(".xterm-rows")
    os.set_blocking(board[0], True)
    for _ in range(200):
        os.write(board[0], bytes(range(256)) * 4)
    os.write(board[0], b"\r\nthe last line\r\n")
    expect(rows).to_contain_text("the last line")


def test_a_text_that_is_pasted_arrives_whole(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    screen = terminal(page, "r1")
    pasted = "".join(f"line {number}\r" for number in range(500))  # longer than a message may be
    keys(screen).evaluate(PASTE, pasted)
    os.set_blocking(board[0], False)
    heard = b""

    def all_came() -> bool:
        nonlocal heard
        with suppress(BlockingIOError):
            heard += os.read(board[0], 65536)
        return len(heard) >= len(pasted)

    try:
        until(all_came, "all of it")
    except AssertionError as error:
        raise AssertionError(f"{len(heard)} of {len(pasted)} bytes, to {heard[-40:]!r}") from error
    assert heard.decode() == pasted
    expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()


def test_two_pages_see_the_same_at_a_port(pages: Bench) -> None:
    one, two = (terminal(pages.open("bench/s1"), "s1") for _ in range(2))
    typed(one, "v")
    expect(two.locator(".xterm-rows")).to_contain_text("v")
    typed(two, "d\n")
    expect(one.locator(".xterm-rows")).to_contain_text("SAC>")
    expect(two.locator(".xterm-rows")).to_contain_text("SAC>")


def test_the_keyboard_comes_out_of_a_terminal(pages: Bench) -> None:
    page = pages.open("bench/s1")
    screen = terminal(page, "s1")
    keys(screen).focus()
    page.keyboard.press("?")  # goes to the board, and is no help
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.keyboard.press("Control+]")
    expect(page.get_by_role("button", name="Close the port")).to_be_focused()


def said(board: tuple[int, str], text: str) -> None:
    os.set_blocking(board[0], True)
    os.write(board[0], text.encode())


def heard(board: tuple[int, str], size: int) -> bytes:
    """Next bytes that the board gets, so many."""
    os.set_blocking(board[0], False)
    data = b""

    def all_came() -> bool:
        nonlocal data
        with suppress(BlockingIOError):
            data += os.read(board[0], 65536)
        return len(data) >= size

    until(all_came, lambda: f"{size} bytes, of which {len(data)} came")
    return data


def test_lines_and_macros_are_sent_and_come_back(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    screen = terminal(page, "r1")
    line = screen.get_by_role("textbox", name="Line to r1")
    for text in ("first", "second"):
        line.fill(text)
        line.press("Enter")
    assert heard(board, 13) == b"first\rsecond\r"
    line.fill("not yet sent")
    line.press("ArrowUp")
    line.press("ArrowUp")
    expect(line).to_have_value("first")
    for _ in range(2):
        line.press("ArrowDown")
    expect(line).to_have_value("not yet sent")
    screen.get_by_label("End of a line").select_option("CR LF")
    line.press("Enter")
    assert heard(board, 14) == b"not yet sent\r\n"
    screen.get_by_role("button", name="Add a macro").click()
    screen.get_by_label("Name of macro 1").fill("Break")
    screen.get_by_label("Text of macro 1").fill(r"\x03\xff")
    screen.get_by_label("End of macro 1").select_option("none")
    screen.get_by_role("button", name="Add", exact=True).click()
    screen.get_by_label("Text of macro 2").fill("q")
    screen.get_by_role("button", name="Move macro 2 up").click()
    page.reload()
    screen.get_by_role("group", name="Macros").get_by_role("button", name="Break").click()
    assert heard(board, 2) == b"\x03\xff"
    macros = screen.get_by_role("group", name="Macros", exact=True).get_by_role("button")
    expect(macros).to_have_text(["q", "Break", "Edit macros"])
    assert violations(page) == []


def test_views_of_what_a_port_said(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    screen = terminal(page, "r1")
    rows = screen.locator(".xterm-rows")
    said(board, "in:1,out:2\r\nnothing\r\n" + "in:3,out:4\r\n" * 3)
    expect(rows).to_contain_text("nothing")
    view = screen.locator(".terminal-head select")
    view.select_option("times")
    expect(rows).to_contain_text(re.compile(r"\d+\.\d{3} nothing"))
    search = screen.get_by_role("searchbox")
    search.fill("nothing")
    search.press("Enter")
    expect(search).to_have_attribute("aria-invalid", "false")
    search.fill("never said")
    search.press("Enter")
    expect(screen.get_by_role("alert")).to_have_text("not found")
    view.select_option("hex")
    expect(rows).to_contain_text("69 6e 3a 31")
    with page.expect_download() as saving:
        screen.get_by_role("button", name="Save").click()
    assert saving.value.suggested_filename == "r1.hex.txt"
    view.select_option("plot")
    expect(screen.get_by_text(re.compile(r"^4 lines of numbers, and \d+ of other text"))).to_be_visible()
    expect(screen.get_by_role("img", name="Numbers that r1 prints: in, out")).to_be_visible()
    with page.expect_download() as saving:
        screen.get_by_role("button", name="Save").click()
    first, *numbers = saving.value.path().read_text().splitlines()
    assert first == "at_s,in,out"
    assert [row.split(",")[1:] for row in numbers] == [["1", "2"], *[["3", "4"]] * 3]


def test_a_long_paste_waits_for_the_board_and_can_be_stopped(pages: Bench, board: tuple[int, str]) -> None:
    page = pages.open("bench/r1")
    screen = terminal(page, "r1")
    keys(screen).evaluate(PASTE, "x" * 200_000)
    expect(screen.get_by_text("of 200000 bytes typed")).to_be_visible()
    screen.get_by_role("button", name="Stop typing").click()
    os.set_blocking(board[0], False)
    taken, told = 0, re.compile(r"r1: open · stopped: (\d+) of 200000 bytes were typed")

    def is_told() -> bool:
        nonlocal taken
        with suppress(BlockingIOError):
            taken += len(os.read(board[0], 65536))
        return told.search(screen.get_by_role("status").inner_text()) is not None

    until(is_told, "the end of typing")
    found = told.search(screen.get_by_role("status").inner_text())
    assert found
    heard(board, int(found[1]) - taken)  # hil has a part of it still
    keys(screen).evaluate(PASTE, "y" * 200_000)
    assert heard(board, 200_000) == b"y" * 200_000
    expect(screen.get_by_role("status")).to_contain_text("200000 bytes were typed")


def test_a_table_of_seventy_columns_is_not_wrapped(pages: Bench) -> None:
    page = pages.open("bench/s1", viewport={"width": 1440, "height": 900})
    screen = terminal(page, "s1")
    line = screen.get_by_role("textbox", name="Line to s1")
    line.press("Enter")  # ends what another test began
    expect(screen.locator(".xterm-rows")).to_contain_text("SAC>")
    line.fill("q")
    screen.get_by_role("button", name="Send").click()
    expect(screen.locator(".xterm-rows")).to_contain_text(re.compile("=" * 70))
    widths = screen.locator(".xterm-rows > div").evaluate_all(
        "rows => rows.map((row) => row.textContent.length)"
    )
    assert max(widths) >= 70
    screen.get_by_role("button", name="Split").click()
    expect(page.get_by_role("group", name="Terminal at s1")).to_have_count(2)
    screen.first.get_by_role("button", name="Wide").click()
    expect(page.get_by_role("region", name="Plots of s1")).to_have_count(0)
