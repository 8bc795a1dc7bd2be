"""Faults and runs in a browser, and two browsers that look at the same bench."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_pages import DESK, PHONE, Bench, editor, fits, served, write
from e2e_support import READY_NS
from playwright.sync_api import Browser, Locator, Page, expect

DEVICES = {
    "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
    "s1": {"profile": "sac", "flash": {}},
}
GOOD = "run: wave\naxes:\n  m1: {velocity_rpm: 120}\nsteps:\n- move: {m1: 90}\n- move: {m1: 0}\n"
BAD = "run: wave\naxes:\n  m1: {velocity_rpm: fast}\nsteps:\n- move: {m1: 90}\n- mve: {m1: 0}\n"
LABEL = "Run, as YAML or JSON"
SLOW = "run: slow\naxes:\n  m1: {velocity_rpm: 1}\nsteps:\n- move: {m1: 300}\n"


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, {"bench": "t", "speed": 4, "devices": DEVICES}) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        for name, given in (("enable", {}), ("position", {"position_deg": 0})):
            bench.server.ask("do", device="m1", name=name, parameters=given)
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.server.ask("clear", number="all")
    bench.close_pages()


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def inject(page: Page, kind: str, on: str, **given: str) -> None:
    page.goto(f"{page.url.partition('#')[0]}#/faults/{on}")
    page.get_by_role("region", name=f"What can fail on {on}").get_by_role("button").filter(
        has=page.get_by_text(kind, exact=True)
    ).click()
    for name, value in given.items():
        page.get_by_label(name, exact=True).fill(value)
    button(page, f"Inject {kind}")


def active(page: Page) -> Locator:
    return page.get_by_role("region", name="Active faults").locator("tbody tr")


def upload(page: Page, text: str, name: str = "wave.yaml") -> None:
    file: Any = {"name": name, "mimeType": "text/yaml", "buffer": text.encode()}
    page.locator("input[type=file]").set_input_files(file)


def test_a_fault_is_injected_seen_on_the_plots_and_cleared(pages: Bench) -> None:
    page = pages.open("faults")
    expect(active(page)).to_have_count(0)
    inject(page, "shaft_jam", "m1")
    expect(active(page)).to_have_count(1)
    expect(active(page)).to_contain_text(re.compile(r"shaft_jam.*m1"))
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
    page.set_viewport_size(DESK)
    page.goto(f"{pages.url}#/bench/m1")
    expect(page.get_by_role("list", name="Faults on the plots of m1")).to_contain_text(
        re.compile(r"shaft_jam on m1: since [\d.]+ s")
    )
    expect(page.locator(".pill.is-fault")).to_have_text("shaft jam")
    told = page.get_by_role("list", name="Faults on the plots of m1").inner_text()
    begin_s = float(told.removesuffix(" s").rpartition(" ")[2])
    (told,) = pages.server.ask("faults")
    assert begin_s == pytest.approx(told["begin_ns"] / 1e9, abs=0.06)
    page.goto(f"{pages.url}#/faults")
    button(page, f"Clear fault {active(page).first.locator('td').first.inner_text()}, shaft_jam on m1")
    expect(active(page)).to_have_count(0)
    page.goto(f"{pages.url}#/bench/m1")
    expect(page.get_by_role("list", name="Faults on the plots of m1")).to_contain_text(
        re.compile(rf"shaft_jam on m1: {begin_s:.1f} s to [\d.]+ s")
    )


def test_the_kinds_that_fit_have_forms_and_all_are_cleared(pages: Bench) -> None:
    page = pages.open("faults/m1")
    kinds = page.get_by_role("region", name="What can fail on m1").locator("button[aria-pressed]")
    expect(kinds.nth(14)).to_be_visible()
    for kind in kinds.all():
        kind.click()
        name = kind.locator(".kind-name").inner_text()
        expect(page.get_by_role("button", name=f"Inject {name}")).to_be_enabled()
    inject(page, "shaft_load", "m1", torque_Nm="0.01")
    inject(page, "byte_drop", "s1", rate="0.5", for_s="5000")
    expect(active(page)).to_have_count(2)
    expect(active(page).filter(has_text="byte_drop")).to_contain_text("rate 0.5")
    button(page, "Clear all")
    expect(active(page)).to_have_count(0)


def test_a_fault_that_cannot_be_is_refused_in_its_place(pages: Bench) -> None:
    page = pages.open("faults")
    inject(page, "byte_flip", "m1", rate="2")
    expect(page.get_by_label("rate", exact=True)).to_have_attribute("aria-invalid", "true")
    expect(page.get_by_role("alert")).to_contain_text("0 to 1")
    page.goto(f"{pages.url}#/faults/%3Cscript%3E")
    expect(page.get_by_text("There is no place “<script>” on this bench")).to_be_visible()
    expect(active(page)).to_have_count(0)


def test_a_run_with_errors_is_marked_at_its_lines(pages: Bench) -> None:
    page = pages.open("runs")
    upload(page, BAD)
    expect(page.get_by_text("wave.yaml")).to_be_visible()
    problems = page.get_by_role("list", name="Problems of the run").get_by_role("listitem")
    expect(problems).to_have_count(2)
    expect(problems.nth(0)).to_contain_text("velocity_rpm")
    expect(page.locator(".cm-lint-marker-error")).to_have_count(2)
    expect(page.get_by_role("button", name="Start", exact=True)).not_to_have_class("primary")
    page.get_by_role("button", name=re.compile("^6:3")).click()
    text = editor(page, LABEL)
    expect(text).to_be_focused()
    expect(text).to_have_attribute("aria-invalid", "true")
    expect(page.locator(".cm-activeLine")).to_contain_text("mve")
    button(page, "Start")
    expect(problems).to_have_count(2)
    assert pages.server.ask("runs", name="") == []
    # It is mended by typing: the marks go, and the check is good.
    write(page, LABEL, GOOD)
    expect(page.get_by_text("run wave, 2 steps, no problems")).to_be_visible()
    expect(page.locator(".cm-lint-marker-error")).to_have_count(0)
    expect(page.get_by_role("button", name="Start", exact=True)).to_have_class("primary")
    for garbage in (
        "",
        "run: [",
        "\x00",
        "a: &a [*a, *a]",
        "{" * 2000,
        "run: <script>alert(1)</script>\naxes: {}",
    ):
        write(page, LABEL, garbage)
        button(page, "Check")
        expect(problems.first).to_be_visible()


def test_a_run_goes_on_and_is_done(pages: Bench) -> None:
    page = pages.open("runs")
    upload(page, GOOD)
    expect(page.get_by_text("no problems")).to_be_visible()
    button(page, "Start")
    card = page.get_by_role("article", name=re.compile("^Run wave"))
    expect(card.first.locator(".pill")).to_have_text("done")
    expect(card.first).to_contain_text("step 2 of 2")
    expect(card.first.get_by_role("row", name=re.compile("^m1"))).to_contain_text("0.00 deg")


def test_a_run_is_cancelled(pages: Bench) -> None:
    page = pages.open("runs")
    upload(page, SLOW, "slow.yaml")
    expect(page.get_by_text("no problems")).to_be_visible()
    button(page, "Start")
    card = page.get_by_role("article", name="Run slow", exact=True)
    expect(card.locator(".pill")).to_have_text("running")
    expect(card).to_contain_text("s left")
    card.get_by_role("button", name="Cancel").click()
    expect(card.locator(".pill")).to_have_text("cancelled")


def test_a_file_that_is_no_run_is_told(pages: Bench, tmp_path: Path) -> None:
    page = pages.open("runs")
    expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()
    upload(page, "x" * 1_000_000)
    expect(page.locator(".notice.is-error")).to_contain_text("1000000 bytes")
    write(page, LABEL, "x" * 1_100_000)
    expect(page.get_by_text("too long for the bench: 1,100,004 of 1,047,576 bytes")).to_be_visible()
    expect(page.get_by_role("button", name="Check", exact=True)).to_be_disabled()
    expect(page.get_by_role("status", name="Connection: connected")).to_be_visible()
    page.locator("input[type=file]").set_input_files(
        {"name": "<b>.yaml", "mimeType": "text/yaml", "buffer": b"\xff\xfe\x00run"}
    )
    expect(page.get_by_role("list", name="Problems of the run").get_by_role("listitem").first).to_be_visible()
    expect(page.get_by_text("<b>.yaml")).to_be_visible()


def test_two_browsers_see_the_same(pages: Bench) -> None:
    one, two = pages.open("faults"), pages.open("faults")
    inject(one, "shaft_load", "m1", torque_Nm="0.01")
    expect(active(two)).to_contain_text("shaft_load")
    button(two, "Clear all")
    expect(active(one)).to_have_count(0)
    one.goto(f"{pages.url}#/runs")
    two.goto(f"{pages.url}#/runs")
    upload(one, SLOW.replace("slow", "both"), "both.yaml")
    button(one, "Start")
    card = two.get_by_role("article", name="Run both", exact=True)
    expect(card.locator(".pill")).to_have_text("running")
    card.get_by_role("button", name="Stop at once").click()
    expect(one.get_by_role("article", name="Run both", exact=True).locator(".pill")).to_have_text("cancelled")
    # A page that comes later knows of the runs before.
    late = pages.open("runs")
    expect(late.get_by_role("article", name="Run both", exact=True).locator(".pill")).to_have_text(
        "cancelled"
    )
