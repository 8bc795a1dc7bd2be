"""Drafts of a page, which stay over other versions, other pages, and full and damaged stores."""

import json
import re
import signal
from collections.abc import Iterator
from contextlib import suppress

import pytest
from browser_pages import Bench, Between, editor, fits, served, shows, violations, write
from e2e_support import READY_NS
from playwright.sync_api import Browser, Error, Page, Route, expect

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
LINEAR = "min_mm: -60, max_mm: 60, velocity_mm_per_min: 6000, acceleration_mm_per_s2: 1000"
MACHINE = f"machine: plotter\naxes:\n  x: {{axis: m1, deg_per_mm: 9, {LINEAR}}}\n"
FAR = "G21 G90\nG0 X0\nF300\nG1 X{far}\nG1 X0\nM2\n"
RUN = "run: mine\naxes:\n  m1: {velocity_rpm: 60}\n"
DAMAGED = """text => {
  for (const store of [localStorage, sessionStorage])
    for (const key of Object.keys(store)) if (key.startsWith("hil.kept")) store.setItem(key, text);
}"""
FULL = """() => {
  for (let size = 1 << 22; size; size >>= 1)
    for (let number = 0; ; number++)
      try { localStorage.setItem(`filler ${size} ${number}`, "x".repeat(size)); } catch { break; }
}"""
WRITTEN_MS = 600
"""Time after which what was typed is in the browser's store."""


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    devices = {"m1": SERVO, "s1": {"profile": "sac", "flash": {}}}
    segments = {"bus0": {"stations": ["s1"]}}
    with served(chromium, {"bench": "t", "devices": devices, "segments": segments}) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        bench.server.ask("do", device="m1", name="enable", parameters={})
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


LABEL = "Run, as YAML or JSON"


def type_run(page: Page, text: str = RUN) -> None:
    write(page, LABEL, text)
    page.wait_for_timeout(WRITTEN_MS)


def type_drawing(page: Page, program: str, machine: str = MACHINE) -> None:
    write(page, "Program", program)
    write(page, "Machine", machine)


# ---- another version ----


def with_versions(page: Page, versions: list[str]) -> tuple[Between, list[str]]:
    """Let the door tell the last of some versions, where there is one. Answers what stands between, and the
    page's loads."""
    loads: list[str] = []

    def told(route: Route) -> None:
        with suppress(Error):  # the page has gone meanwhile
            answer = route.fetch()
            body = answer.json() | ({"version": versions[-1]} if versions else {})
            route.fulfill(response=answer, body=json.dumps(body))

    page.on("request", lambda each: loads.append(each.url) if each.is_navigation_request() else None)
    page.route("**/api/hello", told)
    return Between(page), loads


def test_a_new_version_asks_where_something_is_not_saved(pages: Bench) -> None:
    versions: list[str] = []
    made: list[tuple[Between, list[str]]] = []
    page = pages.open("runs", prepare=lambda page: made.append(with_versions(page, versions)))
    [(between, loads)] = made
    type_run(page)
    versions.append("f" * 64)
    between.cut()
    banner = page.get_by_role("status").filter(has_text="new version")
    expect(banner).to_contain_text("Not saved: the run")
    shows(page, LABEL, RUN)
    assert len(loads) == 1
    assert violations(page) == []
    versions.clear()
    banner.get_by_role("button", name="Load it").click()
    page.wait_for_function("performance.getEntriesByType('navigation')[0].type === 'reload'")
    shows(page, LABEL, RUN)
    assert len(loads) == 2


def test_a_new_version_is_loaded_at_once_where_nothing_is_typed(pages: Bench) -> None:
    versions: list[str] = []
    made: list[tuple[Between, list[str]]] = []
    page = pages.open("runs", prepare=lambda page: made.append(with_versions(page, versions)))
    [(between, loads)] = made
    expect(editor(page, LABEL)).to_be_visible()
    versions.append("f" * 64)
    between.cut()
    between.until_connections(page, 2)
    page.wait_for_function("performance.getEntriesByType('navigation')[0].type === 'reload'")
    assert len(loads) == 2


# ---- the browser's stores ----


def test_what_is_typed_and_chosen_comes_back(pages: Bench) -> None:
    page = pages.open("runs")
    type_run(page)
    page.goto(f"{pages.url}#/bench/m1")
    page.get_by_label("Shown time").select_option("60 s")
    page.get_by_role("button", name=re.compile(r"^Fields \(")).click()
    page.get_by_label(re.compile("^torque_Nm")).uncheck()
    page.get_by_role("tab", name="Gains", exact=True).click()
    page.goto(f"{pages.url}#/wire/bus0")
    page.get_by_label("Filter the packets").fill("from:1")
    page.wait_for_timeout(WRITTEN_MS)
    page.reload()
    expect(page.get_by_label("Filter the packets")).to_have_value("from:1")
    page.goto(f"{pages.url}#/bench/m1")
    expect(page.get_by_label("Shown time")).to_have_value("60")
    expect(page.locator(".trace", has_text=re.compile("^torque_Nm"))).to_have_count(0)
    expect(page.get_by_role("tab", name="Gains", exact=True)).to_have_attribute("aria-selected", "true")
    page.goto(f"{pages.url}#/runs")
    shows(page, LABEL, RUN)


@pytest.mark.parametrize("text", ["{", "null", "[]", '{"text":7,"rows":[]}'])
def test_damaged_stores_are_as_none(pages: Bench, text: str) -> None:
    page = pages.open("runs")
    type_run(page)
    page.goto(f"{pages.url}#/companion/s1")
    expect(page.get_by_text("as in the board")).to_be_visible()
    page.get_by_role("textbox", name="One-shot 1", exact=True).fill("v100")
    page.wait_for_timeout(WRITTEN_MS)
    page.goto("about:blank")
    page.goto(f"{pages.url}#/faults")
    page.evaluate(DAMAGED, text)
    page.reload()
    for view in ("bench/m1", "path", "companion/s1", "wire", "runs"):
        page.goto(f"{pages.url}#/{view}")
        expect(page.locator("main .card").first).to_be_visible()
    expect(editor(page, LABEL)).to_contain_text("run: example")


def test_a_full_store_loses_nothing(pages: Bench) -> None:
    page = pages.open("runs")
    expect(editor(page, LABEL)).to_be_visible()
    page.evaluate(FULL)
    long = RUN + ("#" * 200 + "\n") * 25
    type_run(page, long)
    expect(page.get_by_role("alert")).to_contain_text("no room to keep what you type")
    page.reload()
    shows(page, LABEL, long)


def test_twenty_pages_keep_their_own_texts(pages: Bench) -> None:
    first = pages.open("runs")
    others = [first.context.new_page() for _ in range(19)]
    every = [first, *others]
    for page in others:
        page.goto(f"{pages.url}#/runs")
    for number, page in enumerate(every):
        write(page, LABEL, f"run: r{number}\n")
    first.wait_for_timeout(WRITTEN_MS)
    for number, page in list(enumerate(every))[::6]:
        page.reload()
        shows(page, LABEL, f"run: r{number}\n")


# ---- drawings ----


def test_another_drawing_leaves_the_text_until_it_is_taken(pages: Bench) -> None:
    """And all pages show the drawing that runs, on its own plate."""
    here, there = pages.open("path"), pages.open("path")
    type_drawing(here, FAR.format(far=40))
    button(here, "Check")
    figures = here.get_by_role("region", name="Figures of the drawing")
    expect(figures).to_contain_text("80.0 mm at a feed")
    type_drawing(there, FAR.format(far=10))
    button(there, "Start")
    expect(figures).to_contain_text("20.0 mm at a feed")
    offer = here.get_by_role("status", name="Drawing of the bench")
    expect(offer).to_contain_text("The bench draws program.ngc")
    shows(here, "Program", FAR.format(far=40))
    expect(here.get_by_text(re.compile(r"line \d+, .* s left"))).to_be_visible()
    here.reload()
    expect(offer).to_be_visible()
    shows(here, "Program", FAR.format(far=40))
    assert violations(here) == []
    for page in (here, there):
        expect(page.get_by_text("done", exact=True)).to_be_visible()
    button(here, "Take its texts")
    shows(here, "Program", FAR.format(far=10))
    expect(offer).to_have_count(0)


def test_a_page_that_waits_sees_the_drawing_that_is_planned(pages: Bench) -> None:
    waits, other = pages.open("path"), pages.open("path")
    expect(editor(waits, "Program")).to_be_visible()
    type_drawing(other, FAR.format(far=7))
    button(other, "Check")
    expect(waits.get_by_role("region", name="Figures of the drawing")).to_contain_text("14.0 mm at a feed")


def test_another_run_of_the_same_axes_is_named_and_not_drawn(pages: Bench) -> None:
    page = pages.open("path")
    type_drawing(page, FAR.format(far=12))
    button(page, "Check")
    expect(page.get_by_text("Not started.")).to_be_visible()
    text = "run: plotter\naxes:\n  m1: {velocity_rpm: 20}\nsteps:\n- move: {m1: 360}\n- move: {m1: 0}\n"
    name = pages.server.ask("run", text=text, fresh=True)["run"]
    expect(page.get_by_text(f"Another run moves these axes: {name}")).to_be_visible()
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_disabled()
    expect(page.get_by_text("Not started.")).to_be_visible()
    pages.server.ask("cancel_run", name=name, how="grace")
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled()


# ---- news ----


def test_a_bench_that_hangs_is_seen_at_once_and_does_nothing_late(pages: Bench) -> None:
    page = pages.open("bench/m1")
    expect(page.locator(".trace-value").first).to_have_text(re.compile(r"\d"))
    pages.server.ask("do", device="m1", name="disable", parameters={})
    page.get_by_role("group", name="Verbs").get_by_role("button", name="enable", exact=True).click()
    enable = page.locator("form.parameters").get_by_role("button", name="enable", exact=True)
    expect(page.get_by_text(re.compile(r"^news 0\.\d s old$"))).to_be_visible()
    pages.server.process.send_signal(signal.SIGSTOP)
    try:
        enable.click()
        expect(page.get_by_role("alert")).to_contain_text("what you see is old")
        expect(page.get_by_text(re.compile(r"^no news for [4-7]\.\d s$"))).to_be_visible()
    finally:
        pages.server.process.send_signal(signal.SIGCONT)
    expect(page.locator(".notice.is-error")).to_contain_text(re.compile(r"after its deadline, so it was not"))
    assert pages.server.ask("state", device="m1")["loop_on"] == 0
    enable.click()
    expect(page.locator(".notice").last).to_contain_text(re.compile(r"m1 enable: set-point −?[\d.]+"))
    assert pages.server.ask("state", device="m1")["loop_on"] == 1


# ---- words beside what is wrong ----


def test_a_cell_that_is_no_number_keeps_its_text_and_says_why(pages: Bench) -> None:
    page = pages.open("companion/s1")
    expect(page.get_by_text("as in the board")).to_be_visible()
    rpm = page.get_by_label("Row 3 RPM in rpm", exact=True)
    rpm.fill("fast")
    rpm.press("Enter")
    why = page.get_by_role("alert").filter(has_text="Row 3")
    expect(why).to_contain_text('RPM is "fast"; write a whole number. It is not taken')
    expect(rpm).to_have_value("fast")
    expect(rpm).to_have_attribute("aria-invalid", "true")
    expect(rpm).to_have_accessible_description(re.compile("write a whole number"))
    assert violations(page) == []
    page.wait_for_timeout(WRITTEN_MS)
    page.reload()
    expect(rpm).to_have_value("fast")
    expect(why).to_be_visible()
    expect(rpm).to_be_enabled()
    rpm.press("Escape")
    expect(rpm).to_have_value("100")
    expect(why).to_have_count(0)


def test_rows_that_were_not_sent_come_back(pages: Bench) -> None:
    page = pages.open("companion/s1")
    expect(page.get_by_text("as in the board")).to_be_visible()
    page.get_by_role("checkbox", name="Offline").check()
    steps = page.get_by_label("Row 5 Steps", exact=True)
    steps.fill("4321")
    steps.press("Enter")
    page.get_by_role("textbox", name="One-shot 2", exact=True).fill("v159")
    page.wait_for_timeout(WRITTEN_MS)
    page.reload()
    expect(page.get_by_text("1 not sent")).to_be_visible()
    expect(page.get_by_label("Row 5 Steps", exact=True)).to_have_value("4321")
    expect(page.get_by_role("textbox", name="One-shot 2", exact=True)).to_have_value("v159")
    button(page, "Update queue")
    expect(page.get_by_text("as in the board")).to_be_visible()
    page.reload()
    expect(page.get_by_text("as in the board")).to_be_visible()


def test_a_gain_that_is_wrong_says_why_and_a_step_goes_on(pages: Bench) -> None:
    page = pages.open("bench/m1")
    page.get_by_role("tab", name="Gains", exact=True).click()
    gain = page.get_by_label(re.compile("^pKp, now"))
    gain.fill("much")
    expect(gain).to_have_accessible_description("write a number")
    step = page.get_by_role("button", name="Step response", exact=True)
    expect(step).to_be_enabled()
    expect(page.get_by_role("button", name="Set gains", exact=True)).to_be_disabled()
    page.get_by_label("how far").fill("0")
    expect(page.get_by_text("0 deg is no step")).to_be_visible()
    expect(step).to_be_disabled()
    assert violations(page) == []


def test_an_address_of_five_thousand_characters(pages: Bench) -> None:
    page = pages.open("bench/" + "x" * 5000)
    expect(page.get_by_text("There is no device")).to_be_visible()
    fits(page, 1400)
    for view, said in (("companion", "There is no SAC at"), ("wire", "There is no wire")):
        page.goto(f"{pages.url}#/{view}/{'x' * 5000}")
        expect(page.get_by_text(said)).to_be_visible()
        fits(page, 1400)


def test_the_tab_tells_of_trouble(pages: Bench) -> None:
    made: list[Between] = []
    page = pages.open(prepare=lambda page: made.append(Between(page)))
    expect(page).to_have_title("t · hil")
    fine = page.locator("#icon").get_attribute("href")
    problem = '{"kind":"device","about":"m1","what":"stopped: it hung","remedy":""}'
    failed = rf'\1"failed"\2[{problem}]'
    made[0].change = lambda said: (
        re.sub(r'("health":\{"state":)"\w+"(,"late_ms":[\d.]+,"problems":)\[.*?\](?=\})', failed, said)
        if isinstance(said, str)
        else said
    )
    expect(page).to_have_title("✗ m1: stopped: it hung: t · hil")
    assert page.locator("#icon").get_attribute("href") != fine
