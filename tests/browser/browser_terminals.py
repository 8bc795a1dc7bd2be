"""Terminals in a browser: clients as any other. They show what comes, and carry out nothing of it."""

import os
import tty
from collections.abc import Iterator
from contextlib import suppress

import pytest
from browser_pages import Bench, served
from e2e_support import SAC_READY_NS, until
from playwright.sync_api import Browser, Locator, Page, expect

DEVICES = {"s1": {"profile": "sac", "flash": {}}, "s2": {"profile": "sac", "ports": {"network": "pty"}}}


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
    screen.get_by_role("textbox").press_sequentially(text)


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
    expect(rows).to_contain_text("␛]0;owned")
    expect(rows).to_contain_text("␛[2J␛[31mred␛[0m")
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
    screen.get_by_role("textbox").evaluate(
        """(area, text) => {
            const event = new ClipboardEvent("paste", { clipboardData: new DataTransfer(), bubbles: true });
            event.clipboardData.setData("text/plain", text);
            area.dispatchEvent(event);
        }""",
        pasted,
    )
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
    screen.get_by_role("textbox").focus()
    page.keyboard.press("?")  # goes to the board, and is no help
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.keyboard.press("Control+]")
    expect(page.get_by_role("button", name="Close the port")).to_be_focused()
