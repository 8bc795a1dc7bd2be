"""Python in ``docs/how-to``: tests are run as they stand there, programs print what the page shows.

Blocks below a heading that is a path are files of a page; the page's own test writes and runs them.
"""

import ast
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from e2e_support import Place, free_port
from markdown_blocks import ROOT, blocks, fits
from page_preparations import serve_line
from page_sessions import Session

PAGES = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs/how-to").glob("*.md"))
PROGRAMS = {
    ("add-a-profile", "Fields of your own"): "test_how_to_own_boards.py",
    ("add-a-profile", "Handlers instead of a main loop"): "test_how_to_own_boards.py",
    ("can-channels", "Channels"): "test_how_to_can_channels.py",
    ("can", "Drives on a CAN bus: CANopen"): "test_how_to_can.py",
    ("gcode", "In a test"): "test_page_python.py",
    ("lab", "Reserve a bench"): "test_e2e_lease.py",
    ("modbus", "Position in registers, start bit, done bit"): "test_how_to_modbus.py",
    ("modbus", "Nodes on an RS485 line"): "test_how_to_modbus.py",
    ("line", "In a program"): "test_page_python.py",
    ("line", "Units at a tap or a port"): "test_page_python.py",
    ("own-mechaduino", "Your own sketch on a Mechaduino"): "test_how_to_own_boards.py",
    ("ports", "tcp: a socket"): "test_page_python.py",
    ("ports", "rfc2217: a socket with baud, break and modem lines"): "test_page_python.py",
    ("ports", "With and without `baud:`"): "test_page_python.py",
    ("write-a-test", "The fixture"): "test_page_python.py",
    ("write-a-test", "A program of your own"): "test_page_python.py",
    ("web", "For programs"): "test_e2e_web.py",
    ("zenoh", "All benches of a lab"): "test_e2e_site.py",
    ("zenoh", "From Python"): "page_preparations.py",
    ("zenoh", "What is there"): "page_preparations.py",
}
"""Programs by page and heading, each with the file that runs it."""


class PageTest(NamedTuple):
    """Test function of a page."""

    page: str
    name: str


def python_of(page: str) -> Iterator[tuple[str, str]]:
    """Blocks of Python with their headings, those of files left out."""
    for each in blocks(page):
        if each.language == "python" and not re.fullmatch(r"[\w/]+\.py", each.heading):
            yield each.heading, each.text


def is_test(text: str) -> bool:
    return "def test_" in text


def of_all_pages() -> Iterator[PageTest]:
    for page in PAGES:
        for text in (text for _, text in python_of(page) if is_test(text)):
            names = [each.name for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)]
            yield from (PageTest(page, name) for name in names if name.startswith("test_"))


TESTS = list(of_all_pages())


@pytest.mark.parametrize("test", TESTS, ids=lambda test: test.name)
def test_tests_of_the_pages_pass(test: PageTest, request: pytest.FixtureRequest) -> None:
    """The blocks of a page are one file, in their order."""
    names: dict[str, Any] = {}
    for _, text in python_of(test.page):
        if is_test(text):
            exec(compile(text, test.page, "exec"), names)
    function: Callable[..., None] = names[test.name]
    function(**{name: request.getfixturevalue(name) for name in inspect.signature(function).parameters})


def test_each_block_is_a_test_or_a_program_that_is_run() -> None:
    assert len(TESTS) > 14
    programs = {
        (Path(page).stem, heading) for page in PAGES for heading, text in python_of(page) if not is_test(text)
    }
    assert programs == set(PROGRAMS)
    assert all((ROOT / "tests" / file).exists() for file in PROGRAMS.values())


# ---- programs ----


def test_ports_as_the_page_opens_them(place: Place) -> None:
    with Session(place, "docs/how-to/ports.md") as session:
        session.swaps |= {"7001": str(free_port()), "/tmp/m1": str(place.folder / "m1")}
        session.serve(session.text("Ports"))
        angle = "b'stepNumber: 0 , Angle: 0.00, raw encoder: 286\\r\\n'"
        assert fits(angle, session.program("tcp: a socket"))
        heading = "With and without `baud:`"
        assert fits(session.text(heading, "text"), session.program(heading))
        session.serve(session.text("Ports").replace("kind: tcp", "kind: rfc2217"))
        assert fits(angle, session.program("rfc2217: a socket with baud, break and modem lines"))


def test_a_program_is_the_master_of_a_line(place: Place) -> None:
    with Session(place, "docs/how-to/line.md") as session:
        serve_line(session)
        assert session.program("In a program") == session.text("In a program", "text")


@pytest.mark.thorough
def test_a_program_polls_units_of_modbus(place: Place) -> None:
    heading = "Units at a tap or a port"
    with Session(place, "docs/how-to/line.md") as session:
        session.serve(
            "bench: plant\n"
            "devices: {m1: {profile: mechaduino}, m2: {profile: mechaduino}}\n"
            "segments: {bus0: {modbus: {units: {m1: 1, m2: 2}}, baud: 38400, taps: {master: {port: pty}}}}\n"
        )
        assert session.program(heading) == session.text(heading, "text")


@pytest.mark.thorough
@pytest.mark.long
def test_a_drawing_is_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    (program,) = (text for _, text in python_of("docs/how-to/gcode.md"))
    exec(program, {})
    assert capsys.readouterr().out == "largest deviation 0.073 mm in 9.8 s\n"
    assert Path("plot.png").read_bytes().startswith(b"\x89PNG")


def test_the_bench_without_pytest(capsys: pytest.CaptureFixture[str]) -> None:
    (program,) = (text for heading, text in python_of("docs/how-to/write-a-test.md") if "with Bench(" in text)
    exec(program, {})
    assert "----- Mechaduino 0.X -----" in capsys.readouterr().out


@pytest.mark.thorough
def test_the_context_manager_prints(capsys: pytest.CaptureFixture[str]) -> None:
    (program,) = (text for heading, text in python_of("docs/how-to/write-a-test.md") if "with live(" in text)
    exec(program, {})
    assert capsys.readouterr().out.splitlines()[:2] == ["vd", "0\t0"]
