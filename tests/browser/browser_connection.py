"""The connection of a page: it goes, it comes back, and nothing of what stood on the screen is lost."""

import json
import re
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from browser_pages import PATIENCE_MS, Bench, Between, served
from e2e_support import READY_NS, free_port, until
from playwright.sync_api import Browser, Page, Route, expect

DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "s1": {"profile": "sac", "flash": {}},
}
TIMES = 4


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    config = {"bench": "t", "devices": DEVICES, "bridges": {"web": {"listen": free_port()}}}
    with served(chromium, config) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    # Chromium writes what it cannot reach to the console.
    bench.errors = [error for error in bench.errors if "ERR_CONNECTION" not in error]
    bench.close_pages()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def connected(page: Page) -> None:
    expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()


def prepared(page: Page) -> None:
    """Put on the screen what must not be lost: a plot, a terminal's text, and what was typed into a form."""
    connected(page)
    page.get_by_role("tab", name="Terminal", exact=True).click()
    expect(page.locator(".terminal").get_by_role("status")).to_contain_text("s1: open")
    # Once was too little now and then on a busy machine; browser_terminals.py is about what is typed.
    for _ in range(TIMES):
        page.locator(".xterm-helper-textarea").press_sequentially("vd\n")
        with suppress(AssertionError):
            expect(page.locator(".xterm-rows")).to_contain_text("SAC>", timeout=PATIENCE_MS / TIMES)
            break
    expect(page.locator(".xterm-rows")).to_contain_text("SAC>")
    page.get_by_role("tab", name="Verbs", exact=True).click()
    page.get_by_role("group", name="Verbs").get_by_role("button", name="move_abs", exact=True).click()
    page.get_by_label("position_deg", exact=True).fill("123.25")
    expect(page.locator(".trace-value").first).to_have_text(re.compile(r"\d"))


def kept(page: Page) -> None:
    """Check that it is still there, and that all of it goes on."""
    connected(page)
    expect(page.get_by_role("alert")).to_have_count(0)
    expect(page.get_by_label("position_deg", exact=True)).to_have_value("123.25")
    goes_on(page)


def goes_on(page: Page) -> None:
    """Check that the terminal shows what it showed, and that the board answers."""
    page.get_by_role("tab", name="Terminal", exact=True).click()
    expect(page.locator(".xterm-rows")).to_contain_text("SAC>")
    expect(page.locator(".terminal").get_by_role("status")).to_contain_text("s1: open")
    page.locator(".xterm-helper-textarea").press_sequentially("cf\n")
    expect(page.locator(".xterm-rows")).to_contain_text("debug")


def test_a_bench_that_ends_and_begins_anew(pages: Bench) -> None:
    page = pages.open("bench/s1")
    prepared(page)
    pages.server.process.kill()
    banner = page.get_by_role("alert")
    expect(banner).to_contain_text("No connection to the bench since")
    expect(page.get_by_label("position_deg", exact=True)).to_have_value("123.25")
    # What is asked meanwhile is told to be impossible, and not lost without a word.
    page.locator("form.parameters").get_by_role("button", name="move_abs", exact=True).click()
    expect(page.locator(".notice.is-error")).to_contain_text("no connection")
    pages.serve_again()
    pages.server.ready("s1")
    kept(page)
    # Samples of the run before had another clock: they stand in no table beside the new.
    page.get_by_label("Shown time").select_option("300 s")

    def times_s() -> list[float]:
        with page.expect_download() as download:
            button(page, "CSV")
        rows = download.value.path().read_text().splitlines()[1:]
        return [float(row.partition(",")[0]) for row in rows]

    found_s = until(times_s, "samples of the new clock")
    assert found_s[0] >= 0
    assert found_s == sorted(found_s)


def test_a_connection_that_is_cut(pages: Bench) -> None:
    between: list[Between] = []
    page = pages.open("bench/s1", prepare=lambda page: between.append(Between(page)))
    prepared(page)
    before = page.get_by_role("article").count()
    between[0].cut()
    between[0].until_connections(page, 2)
    kept(page)
    assert page.get_by_role("article").count() == before


def test_a_connection_that_says_nothing_any_more(pages: Bench) -> None:
    """No packet comes, and nobody hangs up: the page notices, and connects again."""
    between: list[Between] = []
    page = pages.open("bench/s1", prepare=lambda page: between.append(Between(page)))
    prepared(page)
    between[0].change = lambda said: None if len(between[0].sockets) == 1 else said
    between[0].until_connections(page, 2)
    kept(page)


def test_a_page_of_another_version_loads_itself_again(pages: Bench) -> None:
    """Before an update the page was another: the browser still has it, and the door is new."""
    loads: list[str] = []
    versions = 0

    def old(route: Route) -> None:
        nonlocal versions
        answer = route.fetch()
        text, count = re.subn(r"\b[0-9a-f]{64}\b", "0" * 64, answer.text())
        versions += count
        route.fulfill(response=answer, body=text if len(loads) == 1 else answer.text())

    def prepare(page: Page) -> None:
        page.on("request", lambda each: loads.append(each.url) if each.is_navigation_request() else None)
        page.route("**/*.js", old)

    page = pages.open("bench/m1", prepare=prepare)
    connected(page)
    expect(page.get_by_role("heading", name="m1", exact=True)).to_be_visible()  # at the same place
    assert len(loads) == versions == 2
    expect(page.get_by_role("alert")).to_have_count(0)


def test_a_page_that_stays_another_says_so_and_does_not_load_for_ever(pages: Bench) -> None:
    loads: list[str] = []

    def always_old(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, body=re.sub(r"\b[0-9a-f]{64}\b", "0" * 64, answer.text()))

    def prepare(page: Page) -> None:
        page.on("request", lambda each: loads.append(each.url) if each.is_navigation_request() else None)
        page.route("**/*.js", always_old)

    page = pages.open("bench", prepare=prepare)
    expect(page.get_by_role("alert")).to_contain_text("of another version")
    connected(page)  # it works as far as it can
    assert len(loads) == 2


NAMES = [
    "<script>window.owned=1</script>",
    "<img src=x onerror=window.owned=1>",
    "\u202egnol\u202c",
    "a b\tc\nd",
    "../..#/faults?x=%2F&y=%zz",
    "__proto__",
    "quote\"'`\\",
    "😀 ünï",
    "\x85\u2028\ufeff\ud800",
    "x" * 300,
    "constructor",
    "",
]


def test_names_of_all_characters_are_shown_as_they_are(pages: Bench) -> None:
    def renamed(said: str | bytes) -> str | bytes:
        if isinstance(said, bytes) or not said.startswith('{"hello"'):
            return said
        told = json.loads(said)
        (m1,) = (device for device in told["hello"]["devices"] if device["name"] == "m1")
        told["hello"]["devices"] = [{**m1, "name": name, "profile": name} for name in NAMES]
        told["hello"]["bench"], told["hello"]["ports"] = NAMES[0], NAMES
        for kind in told["hello"]["fault_kinds"]:
            kind["summary"] = NAMES[1]
        return json.dumps(told)

    page = pages.open("bench", prepare=lambda page: Between(page, renamed))
    cards = page.get_by_role("list", name="Cards of the bench").locator(".device")
    expect(cards).to_have_count(len(NAMES))
    for number, name in enumerate(NAMES):
        page.goto(f"{pages.url}#/bench")
        link = cards.nth(number).locator("a.device-name")
        assert link.evaluate("(link) => link.textContent") == name
        if name.isprintable() and name:
            link.click()
            expect(page.get_by_role("tablist")).to_be_visible()
            page.get_by_role("tab", name="Terminal", exact=True).click()
            expect(page.locator(".terminal").get_by_role("status")).to_contain_text(": closed: ")
    for place in ("runs", "faults", "wire", "companion"):
        page.goto(f"{pages.url}#/{place}")
        expect(page.get_by_role("main")).not_to_be_empty()
    assert page.evaluate("[window.owned, document.title]") == [None, f"{NAMES[0]} · hil"]


GARBAGE: list[Any] = [
    *(
        "",
        "null",
        "{",
        "[]",
        '{"changed":null}',
        '{"hello":3}',
        '{"id":1,"answer":null}',
        '{"id":9,"error":{}}',
    ),
    *('{"watch":1}', '{"watch":1,"value":3}', '{"watch":1,"items":[null,3,{}]}', '{"closed":{}}'),
    *('{"watch":1,"value":{"health":{}}}', '{"watch":1,"value":{"devices":3,"health":{"state":3}}}'),
    *('{"watch":2,"value":[null,3,{"number":1}]}', '{"watch":3,"items":[{"run":3},{"run":"r","axes":[3]}]}'),
    *('{"closed":{"watch":1}}', '{"closed":{"terminal":"x"}}'),
    *(b"", b"\x01", b"\x02\x00\x00\x00", bytes(range(200)), b"\x01\x02\x00\x00" + b"\xff" * 12),
    b"\x01" * 1000,
]
HUGE: list[Any] = ["x" * 10_000_000, b"\x01\x00" + bytes(10_000_000)]


def test_garbage_is_no_blank_page(pages: Bench) -> None:
    between: list[Between] = []
    page = pages.open("bench/s1", prepare=lambda page: between.append(Between(page)))
    prepared(page)
    for place in ("bench", "runs", "faults", "wire", "companion", "bench/s1"):
        page.goto(f"{pages.url}#/{place}")
        for said in GARBAGE:
            between[0].say(said)
        expect(page.get_by_role("main").locator("> *").first).to_be_visible()
        expect(page.get_by_text("fault of the page's own")).to_have_count(0)
    for said in HUGE:
        between[0].say(said)
    connected(page)
    goes_on(page)


def test_a_greeting_of_which_everything_is_wrong(pages: Bench) -> None:
    def spoilt(said: str | bytes) -> str | bytes:
        if isinstance(said, str) and said.startswith('{"hello"'):
            return '{"hello":{"devices":[3,null,{},{"name":"m1","verbs":[],"fields":[null,{}]}],"ports":[1]}}'
        return said

    page = pages.open("bench", prepare=lambda page: Between(page, spoilt))
    connected(page)
    for place in ("bench", "bench/m1", "runs", "faults"):
        page.goto(f"{pages.url}#/{place}")
        expect(page.get_by_role("main").locator("> *").first).to_be_visible()
        expect(page.get_by_text("fault of the page's own")).to_have_count(0)
