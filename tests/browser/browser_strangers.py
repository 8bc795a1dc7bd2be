"""Pages of other sites in the same browser: none of them reaches a bench, by whatever name it comes."""

import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from browser_pages import Bench, served
from playwright.sync_api import Browser, Page, expect

TRY_SOCKET = """url => new Promise((resolve) => {
    const socket = new WebSocket(url, "hil.v1");
    socket.onmessage = () => resolve("told");
    socket.onclose = socket.onerror = () => resolve("refused");
    setTimeout(() => resolve("refused"), 2000);  // what a policy forbids may be silent
})"""
TRY_FETCH = """([url, options]) => fetch(url, options).then(
    (answer) => answer.type === "opaque" ? "blind" : `read ${answer.status}`, () => "refused")"""


class _Site(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>a site</title><p>a page of another site")

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """Another site, by a name of its own."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), _Site)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://evil.test:{server.server_port}/"
    server.shutdown()
    server.server_close()
    thread.join()


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        yield bench


@pytest.fixture
def stranger(bench: Bench, site: str) -> Iterator[Page]:
    page = bench.open("bench")
    expect(page.get_by_role("article", name="m1", exact=True)).to_be_visible()  # the bench is open beside it
    other = page.context.new_page()
    other.goto(site)
    yield other
    bench.errors.clear()
    bench.close_pages()


def test_a_page_of_another_site_reads_and_does_nothing(bench: Bench, stranger: Page) -> None:
    pages = bench.server.ask("status")["bridges"]["web"]["links"]
    assert stranger.evaluate(TRY_SOCKET, bench.url.replace("http", "ws") + "ws") == "refused"
    for path, options in (("api/hello", {}), ("", {}), ("api/logout", {"method": "POST"})):
        assert stranger.evaluate(TRY_FETCH, [bench.url + path, options]) == "refused", path
    # Without asking whether it may, a browser sends simple requests: what they do is nothing.
    before = bench.server.ask("status")["bridges"]["web"]["rejected"]
    blind = {"method": "POST", "mode": "no-cors", "body": "{}"}
    assert stranger.evaluate(TRY_FETCH, [bench.url + "api/login", blind]) in ("blind", "refused")
    assert bench.server.ask("status")["bridges"]["web"]["rejected"] > before
    assert bench.server.ask("status")["bridges"]["web"]["links"] == pages


def test_a_page_of_another_site_frames_nothing_and_runs_no_script_of_it(bench: Bench, stranger: Page) -> None:
    stranger.evaluate(
        """url => Promise.all([["iframe", url], ["script", `${url}page.js`]].map(([name, src]) =>
            new Promise((resolve) => {
                const element = document.createElement(name);
                element.onload = element.onerror = resolve;
                element.src = src;
                document.body.append(element);
            })))""",
        bench.url,
    )
    assert [frame.locator("#page").count() for frame in stranger.frames] == [0, 0]
    assert stranger.evaluate("document.getElementById('page')") is None


def test_a_name_that_leads_here_is_no_name_of_the_bench(bench: Bench, stranger: Page) -> None:
    """DNS rebinding: the site's name leads to this computer now; to the browser the door is the site."""
    rebound = bench.url.replace("127.0.0.1", "evil.test")
    answer = stranger.goto(rebound)
    assert answer
    assert answer.status == 421
    assert stranger.evaluate(TRY_SOCKET, rebound.replace("http", "ws") + "ws") == "refused"
    for path in ("api/hello", "page.js"):
        assert stranger.evaluate(TRY_FETCH, [rebound + path, {}]) == "read 421"


def test_a_page_of_another_bench_of_this_computer_is_another_site(bench: Bench, chromium: Browser) -> None:
    with served(chromium, {"bench": "u", "devices": {"m2": {"profile": "mechaduino"}}}) as other:
        page = other.open("bench")
        expect(page.get_by_role("article", name="m2", exact=True)).to_be_visible()
        assert page.evaluate(TRY_SOCKET, bench.url.replace("http", "ws") + "ws") == "refused"
        other.errors.clear()  # its policy forbids it already


def test_the_page_itself_runs_nothing_but_its_files(bench: Bench) -> None:
    page = bench.open("bench")
    expect(page.get_by_role("article", name="m1", exact=True)).to_be_visible()
    assert bench.errors == []
    page.evaluate(
        """() => {
            const markup = "<img src=x onerror='window.owned=1'><style>p{}</style>";
            document.body.insertAdjacentHTML("beforeend", markup);
            const script = document.createElement("script");
            script.textContent = "window.owned=2";
            document.body.append(script);
        }"""
    )
    page.wait_for_timeout(200)
    assert page.evaluate("window.owned") is None
    assert any("Content Security Policy" in error for error in bench.errors)
    bench.errors.clear()
    bench.close_pages()
