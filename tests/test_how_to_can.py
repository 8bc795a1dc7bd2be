"""The bench and the program of ``docs/how-to/can.md``, as they stand there."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place
from markdown_blocks import block

NAME = "docs/how-to/can.md"
PATIENT = Path(__file__).with_name("patient_master.py")
TITLE = "Drives on a CAN bus: CANopen"


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        place.serve(f"{block(NAME, TITLE)}speed: 4\n", bench="cell").ready()
        yield place


def test_the_program_prints_what_the_page_shows(place: Place, tmp_path: Path) -> None:
    program, shown = block(NAME, TITLE, 1), block(NAME, TITLE, 2)
    path, eds = tmp_path / "master.py", tmp_path / "drive.eds"
    path.write_text(program)
    eds.write_text(place.hil("can", "eds", "m1", "--runtime-dir", str(place.runtime)))
    command = [sys.executable, str(PATIENT), str(path), str(place.runtime / "cell" / "can0.slcan0"), str(eds)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S, check=False)
    assert (ran.stdout, ran.stderr) == (shown, "")
