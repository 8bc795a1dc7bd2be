"""Users and roles in a browser; the page with a keyboard alone, for screen readers, and on a phone."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_pages import DESK, PHONE, Bench, fits, served, violations, write
from e2e_support import READY_NS, Place
from playwright.sync_api import Browser, Page, expect

from bridges.web.password_hash import hash_of

PASSWORD = "long and green"
DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "s1": {"profile": "sac", "flash": {}},
}
PLACES = ("bench", "bench/m1", "runs", "faults")
TABS = ("Verbs", "Terminal", "Gains", "Pins", "Fields")


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with Place() as place:
        made = hash_of(PASSWORD, bytes(16))
        users = place.write(
            "".join(f"{role}:{role}:{made}\n" for role in ("viewer", "operator", "admin")), "users"
        )
        users.chmod(0o600)
        web = {"port": 0, "users": str(users)}
        with served(chromium, {"bench": "t", "devices": DEVICES, "bridges": {"web": web}}) as bench:
            bench.server.ready("m1", boot_ns=READY_NS)
            yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    # Chromium writes each answer of 400 and more to the console: a page that has not logged in asks first.
    bench.errors = [error for error in bench.errors if "status of 401" not in error and "/ws'" not in error]
    bench.close_pages()


def logged_in(pages: Bench, user: str, where: str = "bench/m1", **options: object) -> Page:
    page = pages.open(where, **options)
    page.get_by_label("User").fill(user)
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Log in", exact=True).click()
    expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()
    return page


def button(page: Page, name: str | re.Pattern[str]) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def test_nobody_sees_anything_before_logging_in(pages: Bench) -> None:
    page = pages.open("bench/m1")
    expect(page.get_by_role("heading", name="Log in")).to_be_visible()
    expect(page.get_by_text("m1")).to_have_count(0)
    page.get_by_label("User").fill("admin")
    page.get_by_label("Password").fill("wrong and green")
    button(page, "Log in")
    expect(page.get_by_role("alert")).to_have_text("That is not known here.")
    page.get_by_label("Password").fill(PASSWORD)
    button(page, "Log in")
    expect(page.get_by_role("heading", name="m1", exact=True)).to_be_visible()
    cookies = page.context.cookies()
    assert [(cookie["httpOnly"], cookie["sameSite"]) for cookie in cookies] == [(True, "Strict")]
    assert page.evaluate("document.cookie") == ""
    other = page.context.new_page()  # of the same browser: it is known there
    other.goto(f"{pages.url}#/bench")
    expect(other.get_by_role("article", name="m1", exact=True)).to_be_visible()
    button(page, "admin (admin)")
    for each in (page, other):
        expect(each.get_by_role("heading", name="Log in")).to_be_visible()


def test_a_viewer_looks_on(pages: Bench) -> None:
    page = logged_in(pages, "viewer")
    expect(page.locator(".trace-value").first).to_have_text(re.compile(r"\d"))
    expect(page.locator("form.parameters").get_by_role("button")).to_be_disabled()
    for tab in TABS:
        page.get_by_role("tab", name=tab, exact=True).click()
        panel = page.get_by_role("tabpanel")
        if tab == "Terminal":
            expect(panel).to_contain_text("needs the role operator")
        for each in panel.get_by_role("button").all() if tab != "Verbs" else ():
            expect(each).to_be_disabled()
    page.goto(f"{pages.url}#/runs")
    for name in ("Check", "Start"):
        expect(page.get_by_role("button", name=name, exact=True)).to_be_disabled()
    page.goto(f"{pages.url}#/faults")
    expect(page.get_by_role("button", name=re.compile("^Inject"))).to_be_disabled()
    expect(page.get_by_role("region", name="Inject a fault")).to_contain_text("needs the role admin")


def test_an_operator_moves_axes_and_injects_nothing(pages: Bench) -> None:
    page = logged_in(pages, "operator")
    page.get_by_role("group", name="Verbs").get_by_role("button", name="enable", exact=True).click()
    page.locator("form.parameters").get_by_role("button", name="enable", exact=True).click()
    expect(page.get_by_text(re.compile("^m1 enable: ")).first).to_be_visible()
    page.get_by_role("tab", name="Terminal").click()
    expect(page.locator(".terminal").get_by_role("status")).to_contain_text("m1: open")
    page.goto(f"{pages.url}#/faults")
    expect(page.get_by_role("button", name=re.compile("^Inject"))).to_be_disabled()


def test_an_admin_injects_and_others_see_it(pages: Bench) -> None:
    viewer, admin = logged_in(pages, "viewer", "faults"), logged_in(pages, "admin", "faults")
    admin.get_by_role("button", name="Shaft jammed").click()
    button(admin, "Inject shaft_jam")
    row = viewer.get_by_role("region", name="Active faults").locator("tbody tr")
    expect(row).to_contain_text("shaft_jam")
    expect(row.get_by_role("button")).to_be_disabled()
    button(admin, "Clear all")
    expect(row).to_have_count(0)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_everybody_can_use_it(pages: Bench, theme: str, size: dict[str, int]) -> None:
    """Names, roles and contrasts in all views, by axe-core; and nothing is wider than the screen."""
    page = pages.open("bench", color_scheme=theme, viewport=size)
    expect(page.get_by_role("heading", name="Log in")).to_be_visible()
    found = violations(page)
    page.close()
    page = logged_in(pages, "admin", "bench", color_scheme=theme, viewport=size)
    assert page.evaluate("document.documentElement.dataset.theme") == theme
    for place in PLACES:
        page.goto(f"{pages.url}#/{place}")
        for tab in TABS if place == "bench/m1" else ("",):
            if tab:
                page.get_by_role("tab", name=tab, exact=True).click()
            expect(page.get_by_role("main").locator("> *").first).to_be_visible()
            found += [f"{place} {tab}: {each}" for each in violations(page)]
            fits(page, size["width"])
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    found += violations(page)
    assert found == []


def test_the_theme_is_chosen_and_kept(pages: Bench) -> None:
    page = logged_in(pages, "viewer", "bench", color_scheme="light")
    colour = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(colour)
    button(page, "Change to dark")
    assert page.evaluate(colour) != light
    page.reload()
    expect(page.get_by_role("button", name="Change to light")).to_be_visible()
    assert page.evaluate(colour) != light


def test_the_keyboard_alone(pages: Bench) -> None:
    page = logged_in(pages, "admin", "bench")
    page.reload()
    expect(page.get_by_role("link", name="m1", exact=True)).to_be_visible()
    page.keyboard.press("Tab")
    expect(page.get_by_text("Skip to the content")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("main")).to_be_focused()
    link = page.get_by_role("link", name="m1", exact=True)
    for _ in range(30):  # past what may be tried first
        page.keyboard.press("Tab")
        if link.evaluate("link => link === document.activeElement"):
            break
    expect(link).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="m1", exact=True)).to_be_visible()
    # A verb, from its name to its answer.
    page.get_by_role("tab", name="Verbs").focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_role("tab", name="Terminal")).to_be_focused()
    page.keyboard.press("ArrowLeft")
    page.get_by_role("group", name="Verbs").get_by_role("button", name="enable", exact=True).focus()
    page.keyboard.press("Enter")
    for _ in range(30):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.type") == "submit":
            break
    page.keyboard.press("Enter")
    expect(page.get_by_text(re.compile("^m1 enable: ")).first).to_be_visible()
    # Views by their numbers, and the help.
    views = page.get_by_role("navigation", name="Views").get_by_role("link").all_inner_texts()
    page.keyboard.press(str(1 + views.index("Faults")))
    expect(page.get_by_role("heading", name="Active faults")).to_be_visible()
    page.keyboard.press(str(1 + views.index("Runs")))
    expect(page.get_by_label("Run, as YAML or JSON")).to_be_visible()
    page.get_by_label("Run, as YAML or JSON").press("End")
    page.keyboard.type("?1")
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.get_by_role("main").focus()
    page.keyboard.press("?")
    dialog = page.get_by_role("dialog", name="What the words mean")
    expect(dialog).to_contain_text("set-point")
    expect(dialog).to_contain_text("In a plot".lower())
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)


def test_a_token_of_the_log_opens(chromium: Browser) -> None:
    web = {"port": 0, "token": "viewer"}
    with served(chromium, {"bench": "t", "devices": DEVICES, "bridges": {"web": web}}) as bench:
        found = re.search(r"token of this run is (\S+)", bench.server.output)
        assert found
        page = bench.open("faults")
        page.get_by_label(re.compile("^Token")).fill("x" * 32)
        button(page, "Log in")
        expect(page.get_by_role("alert")).to_have_text("That is not known here.")
        page.get_by_label(re.compile("^Token")).fill(found[1])
        button(page, "Log in")
        expect(page.get_by_role("region", name="Inject a fault")).to_contain_text("needs the role admin")
        bench.errors.clear()


@pytest.mark.skipif(not shutil.which("openssl"), reason="openssl makes the certificate")
def test_the_page_by_tls(chromium: Browser, tmp_path: Path) -> None:
    key, certificate = tmp_path / "door.key", tmp_path / "door.pem"
    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    files = ("-keyout", str(key), "-out", str(certificate))
    command = ["openssl", "req", "-x509", *curve, *files, "-days", "1", "-subj", "/CN=localhost"]
    subprocess.run(command, check=True, capture_output=True)
    users = tmp_path / "users"
    users.write_text(f"ann:operator:{hash_of(PASSWORD, bytes(16))}\n")
    users.chmod(0o600)
    tls = {"certificate": str(certificate), "key": str(key)}
    web = {"port": 0, "users": str(users), "tls": tls}
    with served(chromium, {"bench": "t", "devices": DEVICES, "bridges": {"web": web}}) as bench:
        assert bench.url.startswith("https://")
        page = logged_in(bench, "ann", ignore_https_errors=True)
        expect(page.locator(".trace-value").first).to_have_text(re.compile(r"\d"))
        (cookie,) = page.context.cookies()
        assert cookie["secure"]
        bench.errors.clear()


def test_a_viewer_looks_at_a_drawing_and_starts_none(pages: Bench) -> None:
    machine = (
        "machine: m\naxes:\n  x: {axis: m1, deg_per_mm: 9, min_mm: -9, max_mm: 9, velocity_mm_per_min: 600,"
    )
    machine += " acceleration_mm_per_s2: 99}\n"
    page = logged_in(pages, "viewer", "path")
    write(page, "Program", "G21 G90 F300\nG1 X5\nG1 X0\nM2\n")
    write(page, "Machine", machine)
    button(page, "Check")
    expect(page.get_by_role("region", name="Figures of the drawing")).to_contain_text("mm at a feed")
    for name in ("Start", "Pause", "Stop", "Stop at once"):
        expect(page.get_by_role("button", name=name, exact=True)).to_be_disabled()
    operator = logged_in(pages, "operator", "path")
    write(operator, "Machine", machine)
    expect(operator.get_by_role("button", name="Start", exact=True)).to_be_enabled()
