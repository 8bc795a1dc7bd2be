"""The faults view in a browser: a place of the bench, what fits it, and faults that come again."""

import json
from collections.abc import Iterator

import pytest
from browser_pages import PHONE, Bench, fits, served, violations
from e2e_support import config
from playwright.sync_api import Browser, Page, expect

DEVICES = {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}}
SEGMENTS = {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, json.loads(config(speed=1, devices=DEVICES, segments=SEGMENTS))) as bench:
        yield bench


@pytest.fixture
def page(bench: Bench) -> Iterator[Page]:
    yield bench.open("bench/m1")
    for row in bench.server.ask("faults"):
        bench.server.ask("clear", number=row["number"])
    bench.close_pages()


def test_a_wire_is_broken_from_where_it_is_seen(page: Page, bench: Bench) -> None:
    page.get_by_role("link", name="Break…").click()
    expect(page.get_by_role("region", name="What can fail on m1")).to_contain_text("Encoder frozen")
    page.goto(f"{bench.url}#/wire/bus0")
    page.get_by_role("link", name="Break…").click()
    fitting = page.get_by_role("region", name="What can fail on bus0")
    expect(fitting.get_by_role("button")).to_have_count(2)
    page.get_by_role("navigation", name="What to break").get_by_role("link", name="s1.network").click()
    cut = page.get_by_role("region", name="What can fail on s1.network").get_by_role(
        "button", name="Wire cut"
    )
    cut.click()
    form = page.get_by_role("region", name="Inject a fault")
    form.get_by_label("for_s", exact=True).fill("0.4")
    form.get_by_label("every_s", exact=True).fill("0.3")
    form.get_by_role("button", name="Inject wire_cut").click()
    expect(page.get_by_text("write more than that")).to_be_visible()
    form.get_by_label("every_s", exact=True).fill("0.8")
    form.get_by_label("Name of the preset").fill("loose plug")
    form.get_by_role("button", name="Keep as a preset").click()
    page.reload()
    page.get_by_role("button", name="Inject loose plug").click()
    row = page.get_by_role("region", name="Active faults").locator("tbody tr")
    expect(row).to_contain_text("Wire cut")
    expect(row).to_contain_text("for 0.4 s, again every 0.8 s")
    (told,) = bench.server.ask("faults")
    assert (told["target"], told["parameters"]["every_s"]) == ("s1.network", 0.8)
    row.get_by_role("button").click()
    expect(row).to_have_count(0)
    page.get_by_role("button", name="Forget loose plug").click()
    expect(page.get_by_role("region", name="Presets")).to_have_count(0)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everybody_can_break_something(page: Page, bench: Bench, scheme: str) -> None:
    page = bench.open("faults/m1", color_scheme=scheme)
    expect(page.get_by_role("button", name="Shaft jammed")).to_be_visible()
    assert violations(page) == []
    page.set_viewport_size(PHONE)
    fits(page, PHONE["width"])
    assert violations(page) == []
