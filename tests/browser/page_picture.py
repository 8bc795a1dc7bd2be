"""Makes the picture of the page in the README: `.venv/bin/python -m pytest tests/browser/page_picture.py`.

It is no test, and its name keeps it out of them.
"""

from browser_pages import ROOT, served
from e2e_support import READY_NS
from playwright.sync_api import Browser

PICTURE = ROOT / "docs/images/page.png"
TARGETS_DEG = (120, -60, 180, 0)
MOVE = {"velocity_rpm": 60, "acceleration_rpm_per_s": 300}


def test_the_page_has_its_picture_taken(chromium: Browser) -> None:
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    devices = {"m1": servo, "s1": {"profile": "sac", "flash": {}}}
    with served(chromium, {"bench": "demo", "devices": devices}) as bench:
        bench.server.ready("m1", boot_ns=READY_NS)
        page = bench.open("bench/m1", viewport={"width": 1600, "height": 1000}, color_scheme="light")
        page.get_by_role("tab", name="Terminal", exact=True).click()
        page.wait_for_timeout(800)
        page.locator(".xterm-helper-textarea").first.focus()
        for _ in range(2):
            page.keyboard.type("p")
            page.wait_for_timeout(1000)
        bench.server.ask("do", device="m1", name="enable", parameters={})
        page.wait_for_timeout(1500)
        for position_deg in TARGETS_DEG:
            given = {"position_deg": position_deg, **MOVE}
            bench.server.ask("do", device="m1", name="move_abs", parameters=given)
            page.wait_for_timeout(2000)
        page.mouse.move(0, 0)
        page.screenshot(path=PICTURE)
