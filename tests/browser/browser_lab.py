"""The page of a bench of a lab in a browser: a stop for all benches, and whose lease it is."""

import re
from collections.abc import Iterator

import pytest
import zenoh
from browser_pages import DESK, PHONE, Bench, fits, served
from e2e_support import free_port, until
from playwright.sync_api import Browser, expect

from bridges.zenoh.zenoh_config import opened, router_config

AXES = {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}


@pytest.fixture(scope="module")
def benches(chromium: Browser) -> Iterator[tuple[Bench, Bench]]:
    """Two benches at one router."""
    door = f"tcp/127.0.0.1:{free_port()}"
    router: zenoh.Session = opened(router_config([door], None, True))
    joined = {"web": {"listen": 0}, "zenoh": {"listen": [], "connect": [door]}}
    with (
        served(chromium, {"bench": "mill", "devices": AXES, "bridges": joined}) as mill,
        served(chromium, {"bench": "lathe", "devices": AXES, "bridges": joined}) as lathe,
    ):
        until(lambda: [row["bench"] for row in mill.server.ask("benches")] == ["lathe"], "a sight of lathe")
        yield mill, lathe
    router.close()  # type: ignore[no-untyped-call]


def speed_rpm(bench: Bench) -> float:
    speed_rpm: float = bench.server.ask("state", device="m1")["velocity_rpm"]
    return speed_rpm


def test_a_stop_of_the_site_says_which_benches_have_confirmed(benches: tuple[Bench, Bench]) -> None:
    mill, lathe = benches
    lathe.server.ready("m1").ask("do", device="m1", name="enable", parameters={})
    turn = {"position_deg": 36_000.0, "velocity_rpm": 60.0}
    lathe.server.ask("do", device="m1", name="move_abs", parameters=turn)
    until(lambda: speed_rpm(lathe) > 50, "a motion")
    page = mill.open("bench")
    page.get_by_role("button", name="Stop site", exact=True).click()
    said = page.get_by_role("status").get_by_text(re.compile("^Stop site: 2 of 2 confirmed: "))
    expect(said.first).to_be_visible()
    until(lambda: abs(speed_rpm(lathe)) < 1, "an end of the motion")


def test_a_lease_stands_in_the_head_of_the_page(benches: tuple[Bench, Bench]) -> None:
    mill, _ = benches
    mill.server.ask("take_lease", why="press tests", for_s=600.0)
    try:
        page = mill.open("bench")
        expect(page.get_by_role("banner")).to_contain_text(re.compile("leased by .+ until "))
        for size in (DESK, PHONE):
            page.set_viewport_size(size)
            fits(page, size["width"])
    finally:
        mill.server.ask("give_lease")
    expect(page.get_by_role("banner")).not_to_contain_text("leased by")
