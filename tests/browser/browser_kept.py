"""What is typed in any place stays over views, loads, other benches and other tabs, in stores of any kind."""

import json
import re
from collections.abc import Iterator

import pytest
from browser_pages import Bench, editor, served, shows, write
from e2e_support import READY_NS
from playwright.sync_api import Browser, Page, expect

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
DEVICES = {"m1": SERVO, "s1": {"profile": "sac", "flash": {}}}
CONTENT = {
    "bench": "kept",
    "devices": DEVICES,
    "segments": {"bus0": {"stations": ["s1"]}},
    "can": {"can0": {"bit_rate": 500000, "nodes": {"m1": 5}}},
}
RUN = "Run, as YAML or JSON"
WRITTEN = """name => {
  const key = Object.keys(sessionStorage).find(key => key.endsWith("/" + name));
  return key !== undefined && sessionStorage.getItem(key).includes("typed");
}"""
REFUSING = """
for (const name of ["getItem", "setItem", "removeItem"])
  Storage.prototype[name] = () => { throw new DOMException("refused", "SecurityError"); };
"""
PLACES = [
    ("wire/bus0", "Command", "m3000"),
    ("wire/bus0", "to", "12"),
    ("wire/can0", "Identifier", "605"),
    ("wire/can0", "Data, hexadecimal", "40 00"),
    ("companion/s1", "Command", "v100"),
    ("companion/s1", "List", "1 3 7"),
    ("faults/m1", "Name of the preset", "a preset"),
    ("bench/m1", "Set load_torque_Nm", "0.125"),
    ("bench/m1", "Condition to look for", "m1.e > 5"),
]


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, CONTENT) as bench:
        bench.server.ready("m1", boot_ns=READY_NS).ready("s1")
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def go(page: Page, bench: Bench, where: str) -> None:
    page.goto(f"{bench.url}#/{where}")


def test_what_is_typed_in_small_places_stays_over_views_and_loads(pages: Bench) -> None:
    page = pages.open("bench/m1")
    page.get_by_role("tab", name="Fields", exact=True).click()
    go(page, pages, "faults/m1")
    page.get_by_role("button", name=re.compile("shaft", re.I)).first.click()
    for where, label, text in PLACES:
        go(page, pages, where)
        page.get_by_label(label, exact=True).fill(text)
    go(page, pages, "events")
    page.reload()
    for where, label, text in PLACES:
        go(page, pages, where)
        expect(page.get_by_label(label, exact=True)).to_have_value(text)


def test_tabs_add_to_what_they_have_together(pages: Bench) -> None:
    first = pages.open("layout/ready/tuning")
    second = first.context.new_page()
    go(second, pages, "layout/ready/wall")
    for page, name in ((first, "mine"), (second, "yours")):
        page.get_by_label("Name of the layout").fill(name)
        page.get_by_role("button", name="Save", exact=True).click()
        expect(page.locator(".notice").get_by_text(f"The layout “{name}” is saved")).to_be_visible()
    for page in (first, second):
        page.get_by_role("button", name="Layouts").click()
        for name in ("mine", "yours"):
            expect(page.get_by_role("link", name=name, exact=True)).to_be_visible()


@pytest.mark.thorough
def test_two_tabs_that_write_leave_each_other_alone(pages: Bench) -> None:
    first = pages.open("runs")
    second = first.context.new_page()
    go(second, pages, "runs")
    write(first, RUN, "run: first\n")
    write(second, RUN, "run: second\n")
    first.wait_for_function(WRITTEN.replace("typed", "first"), arg="run")
    shows(first, RUN, "run: first\n")
    first.reload()
    shows(first, RUN, "run: first\n")


def test_a_browser_that_keeps_nothing_says_so_once_and_works(pages: Bench) -> None:
    page = pages.open("wire/bus0", prepare=lambda page: page.add_init_script(REFUSING))
    command = page.get_by_label("Command", exact=True)
    told = page.locator(".notice", has_text="no room to keep")
    command.fill("m3000")
    expect(told).to_have_count(1)
    go(page, pages, "runs")
    expect(editor(page, RUN)).to_be_visible()
    go(page, pages, "wire/bus0")
    expect(command).to_have_value("m3000")
    command.fill("m3001")
    expect(told).to_have_count(1)


@pytest.mark.thorough
def test_another_bench_at_the_address_has_its_own_texts(chromium: Browser) -> None:
    """And undo does not bring those of the bench before."""
    with served(chromium, CONTENT | {"bridges": {"web": {"listen": 0}}}) as bench:
        page = bench.open("runs")
        write(page, RUN, "run: typed\n")
        page.wait_for_function(WRITTEN, arg="run")
        page.evaluate("window.isBefore = true")  # what its module has of the bench before goes with it
        bench.server.stop()
        port = int(bench.url.rsplit(":", 1)[1].strip("/"))
        for name in ("other", "kept"):
            text = json.dumps({**CONTENT, "bench": name, "bridges": {"web": {"listen": port}}})
            server = bench.place.serve(text, bench=name)
            expect(page.locator(".bench-name")).to_have_text(name)
            page.wait_for_function("window.isBefore === undefined")
            area = editor(page, RUN)
            if name == "kept":
                shows(page, RUN, "run: typed\n")
            else:
                expect(area).to_contain_text("run: example")
                area.press("ControlOrMeta+z")
                expect(area).to_contain_text("run: example")
            server.stop()
        page.close()
        bench.errors.clear()  # the connection was refused while nothing was served
