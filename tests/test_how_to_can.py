"""The bench, the programs and the tests of ``docs/how-to/can.md``, as they stand there."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place
from markdown_blocks import block, fits

NAME = "docs/how-to/can.md"
TITLE = "Drives on a CAN bus: CANopen"
COUNTS = r"( +\d+\.\d%)?( +\d+)+"


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        place.serve(block(NAME, TITLE), bench="cell").ready()
        yield place


def test_the_lists_are_what_the_page_shows(place: Place) -> None:
    listed, _, status = block(NAME, "Status").partition("$ hil status\n")
    where = ("--runtime-dir", str(place.runtime))
    shown = [re.sub(r"\s+", " ", each) for each in listed.splitlines()[2:]]
    said = re.sub(r"[ ]+", " ", place.hil("list", *where))
    assert all(line in said for line in shown), said
    columns = [line.split() for line in status.splitlines()[1:] if not re.search(r"\d", line)]
    for names in columns:
        assert " ".join(names) in re.sub(r"[ ]+", " ", place.hil("status", *where))


def test_the_program_prints_what_the_page_shows(place: Place, tmp_path: Path) -> None:
    program, shown = block(NAME, TITLE, 1), block(NAME, TITLE, 2)
    path, eds = tmp_path / "master.py", tmp_path / "drive.eds"
    path.write_text(program)
    eds.write_text(place.hil("can", "eds", "m1", "--runtime-dir", str(place.runtime)))
    command = [sys.executable, str(path), str(place.runtime / "cell" / "can0.slcan0"), str(eds)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S, check=False)
    assert (ran.stdout, ran.stderr) == (shown, "")


def test_the_faults_are_taken(place: Place) -> None:
    where = ("--runtime-dir", str(place.runtime))
    for command, said in re.findall(r"^\$ hil (.*)\n(.*)$", block(NAME, "Inject faults"), re.M):
        assert fits(said, place.hil(*command.split(), *where))
    place.hil("fault", "clear", *where)


def test_the_tests_pass(tmp_path: Path) -> None:
    path = tmp_path / "test_page.py"
    path.write_text(block(NAME, "In a test"))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(path)]
    ran = subprocess.run(
        command, capture_output=True, text=True, timeout=2 * PATIENCE_S, cwd=tmp_path, check=False
    )
    assert "2 passed" in ran.stdout, ran.stdout + ran.stderr
