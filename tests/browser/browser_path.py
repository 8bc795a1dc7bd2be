"""A drawing in a browser: its problems, its figures, its run, and the path that the axes follow."""

import re
from collections.abc import Iterator

import pytest
from browser_pages import DESK, PHONE, Bench, editor, fits, in_layout, served, shows, violations, write
from e2e_support import READY_NS
from playwright.sync_api import Browser, Page, expect

LINEAR = "min_mm: -60, max_mm: 60, velocity_mm_per_min: 6000, acceleration_mm_per_s2: 1000"
MACHINE = f"""machine: plotter
segment_ms: 10
axes:
  x: {{axis: m1, deg_per_mm: 9, {LINEAR}}}
  y: {{axis: m2, deg_per_mm: 9, {LINEAR}}}
"""
PROGRAM = "G21 G90 G17\nG0 X20 Y0\nF1500\nG3 I-20\nM0\nG1 X0 Y0\nM2\n"
SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}


@pytest.fixture(scope="module")
def bench(chromium: Browser) -> Iterator[Bench]:
    with served(chromium, {"bench": "t", "devices": {"m1": SERVO, "m2": SERVO}}) as bench:
        for name in ("m1", "m2"):
            bench.server.ready(name, boot_ns=READY_NS)
            bench.server.ask("do", device=name, name="enable", parameters={})
        yield bench


@pytest.fixture
def pages(bench: Bench) -> Iterator[Bench]:
    yield bench
    bench.close_pages()


def fill(page: Page, program: str, machine: str = MACHINE) -> None:
    write(page, "Program", program)
    write(page, "Machine", machine)


def click(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def largest_mm(page: Page) -> float:
    """Largest deviation that a page tells."""
    told = page.get_by_test_id("deviation")
    expect(told).to_have_text(re.compile(r"\d mm"))
    return float(told.inner_text().split()[0])


def test_problems_stand_at_their_lines(pages: Bench) -> None:
    page = pages.open("path")
    fill(page, "G21 G90\nG1 X5\nG0 X99\nG5\n")
    click(page, "Check")
    problems = page.get_by_role("list", name="Problems of the program")
    expect(problems.get_by_role("listitem").first).to_contain_text("2:1")
    expect(page.locator(".cm-lint-marker-error").first).to_be_visible()
    problems.get_by_role("button").first.click()
    expect(editor(page, "Program")).to_be_focused()
    fill(page, PROGRAM, MACHINE.replace("m2", "m9").replace("max_mm: 60", "max_mm: what"))
    click(page, "Check")
    expect(page.get_by_role("list", name="Problems of the machine")).to_contain_text("what")
    fill(page, "G0 X1\n(" + "x" * 700_000)
    click(page, "Check")
    expect(page.get_by_role("list", name="Problems of the program")).to_be_visible()
    assert violations(page) == []


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (PROGRAM.encode("utf-16"), None),
        ("(Nut, 5 µm tief)\n".encode("latin-1") + PROGRAM.encode(), None),
        (b"\x00\x01\x02G0 X1", "1:1"),
        (bytes(range(256)) * 20, "1:1"),
    ],
)
def test_files_of_any_encoding_are_read_or_said_to_be_wrong(
    pages: Bench, data: bytes, problem: str | None
) -> None:
    page = pages.open("path")
    fill(page, "")
    file = {"name": "part.ngc", "mimeType": "application/octet-stream", "buffer": data}
    page.get_by_label("Open a file: Program").set_input_files([file])
    expect(page.get_by_role("region", name="Program").get_by_text("part.ngc")).to_be_visible()
    click(page, "Check")
    if problem is None:
        expect(page.get_by_role("region", name="Figures of the drawing")).to_contain_text("mm at a feed")
    else:
        problems = page.get_by_role("list", name="Problems of the program")
        expect(problems.get_by_role("listitem").first).to_be_visible()


def test_a_drawing_is_carried_out_and_two_browsers_see_it(pages: Bench) -> None:
    # No other test has this drawing, and its first part lasts while a busy computer shows it in two pages.
    program = PROGRAM.replace("20", "18").replace("F1500", "F500")
    page = pages.open("path")
    fill(page, program)
    click(page, "Check")
    figures = page.get_by_role("region", name="Figures of the drawing")
    expect(figures).to_contain_text("131.1 mm at a feed")
    page.reload()
    shows(page, "Machine", MACHINE)  # remembered
    other = pages.open("path")
    shows(other, "Program", program)
    click(page, "Start")
    expect(other.get_by_test_id("deviation")).to_have_text(re.compile(r"\d mm"))
    click(other, "Pause")
    for each in (page, other):
        expect(each.get_by_text("paused", exact=True)).to_be_visible()
        expect(each.get_by_test_id("deviation")).to_have_text(re.compile(r"\d mm"))
    standing(pages, page)
    click(page, "Resume")
    for each in (page, other):
        expect(each.get_by_text("The program waits at line 5.")).to_be_visible()
        assert 0.005 < largest_mm(each) < 0.25
    click(other, "Go on")
    expect(page.get_by_text("100 %")).to_be_visible()
    expect(page.get_by_text("done", exact=True)).to_be_visible()


def standing(pages: Bench, page: Page) -> None:
    """Wait until the set-points stand: the axes slow down on their path first."""
    places: list[float] = []
    for _ in range(100):
        before, places = places, [pages.server.ask("state", device=name)["r"] for name in ("m1", "m2")]
        if places == before:
            return
        page.wait_for_timeout(200)
    raise AssertionError(f"the set-points still move: {places}")


def test_it_is_stopped_on_its_path(pages: Bench) -> None:
    page = pages.open("path")
    fill(page, PROGRAM)
    click(page, "Start")
    expect(page.get_by_text(re.compile("line 4,"))).to_be_visible()
    click(page, "Stop")
    expect(page.get_by_text("cancelled", exact=True)).to_be_visible()
    x, y = (pages.server.ask("state", device=name)["r"] / 9 for name in ("m1", "m2"))
    assert (x * x + y * y) ** 0.5 == pytest.approx(20, abs=0.03)
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_everybody_can_use_it(pages: Bench, scheme: str, size: dict[str, int]) -> None:
    page = pages.open("path", viewport=size, color_scheme=scheme)
    fill(page, PROGRAM.replace("G3 I-20", "G3 I-20 Q1"))
    click(page, "Check")
    expect(page.get_by_role("list", name="Problems of the program")).to_be_visible()
    fill(page, PROGRAM)
    click(page, "Check")
    expect(page.get_by_role("region", name="Figures of the drawing")).to_be_visible()
    click(page, "Zoom in, XY")
    page.get_by_role("img").press("ArrowLeft")
    click(page, "Fit XY: show all of it")
    assert violations(page) == []
    fits(page, size["width"])


def test_a_plate_has_the_scale_and_the_range_of_the_machine(pages: Bench) -> None:
    pages.server.ask("drawing", text=PROGRAM, machine=MACHINE.replace("deg_per_mm: 9", "deg_per_mm: 4.5"))
    pages.server.ask("do", device="m1", name="position", parameters={"position_deg": 90})
    picture = {"kind": "picture", "of": "", "given": {"form": "plate"}}
    page = pages.open()
    made = {"version": 1, "name": "", "bench": "t", "root": {"tabs": [picture]}}
    page.goto(f"{pages.url}#/{in_layout(made)}")
    expect(
        page.get_by_role("img", name=re.compile(r"^Plate of m1 and m2: (19\.9|20\.0) mm, "))
    ).to_be_visible()
    page.get_by_role("button", name="Settings of Plate").click()
    expect(page.get_by_label("mm a turn")).to_have_attribute("placeholder", "of the machine")
    page.get_by_label("mm a turn").fill("36")
    page.keyboard.press("Enter")
    expect(page.get_by_role("img", name=re.compile(r"^Plate of m1 and m2: (9\.0|8\.9) mm, "))).to_be_visible()
