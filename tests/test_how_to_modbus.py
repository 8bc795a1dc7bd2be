"""The bench, the map and the program of ``docs/how-to/modbus.md``, as they stand there."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place, Server, free_port
from markdown_blocks import ROOT, block, blocks

from bridges.modbus.registers import layout

NAME = "docs/how-to/modbus.md"
PORT = "1502"
ANGLE = r" *-?\d+\.\d{3}$"


@pytest.fixture(scope="module")
def place() -> Iterator[Place]:
    with Place() as place:
        yield place


@pytest.fixture(scope="module")
def number() -> str:
    return str(free_port())


@pytest.fixture(scope="module")
def server(place: Place, number: str) -> Server:
    bench = block(NAME, "Axes for PLCs and SCADA: Modbus").replace(
        "modbus: {}", f"modbus: {{listen: 127.0.0.1:{number}}}\nspeed: 20"
    )
    return place.serve(bench, bench="plant").ready()


def test_the_program_prints_what_the_page_shows(server: Server, number: str, tmp_path: Path) -> None:
    """Where the shaft stands varies by the noise of its loop: within half a degree of what is shown."""
    heading = "Position in registers, start bit, done bit"
    program, shown = (each.text for each in blocks(NAME) if each.heading == heading)
    path = tmp_path / "plc.py"
    path.write_text(program.replace(PORT, number))
    ran = subprocess.run(
        [sys.executable, str(path)], capture_output=True, text=True, timeout=PATIENCE_S, check=True
    )
    assert [re.sub(ANGLE, "", line) for line in ran.stdout.splitlines()] == [
        re.sub(ANGLE, "", line) for line in shown.splitlines()
    ]
    angles = [[float(line.split()[-1]) for line in text.splitlines()] for text in (ran.stdout, shown)]
    assert angles[0] == pytest.approx(angles[1], abs=0.5)


def test_the_bits_of_the_status_word_are_all_named_in_their_order() -> None:
    (said,) = re.findall(r"\*\*Status word\.\*\*.*? on: (.*?)\.", (ROOT / NAME).read_text(), re.S)
    named = [re.sub(r"\s+", " ", each) for each in said.split(", ")]
    assert [name.replace("keeps its angle", "keeps angle") for name in named] == [
        name.replace("_", " ") for name, _ in layout.STATUS
    ]


LINE = "Nodes on an RS485 line"


@pytest.fixture(scope="module")
def line() -> Iterator[Place]:
    """A place where the bench with nodes runs."""
    with Place() as place:
        place.serve(f"{block(NAME, LINE)}speed: 20\n", bench="plant").ready()
        yield place


def test_the_master_on_the_line_prints_what_the_page_shows(line: Place, tmp_path: Path) -> None:
    program, shown = block(NAME, LINE, 1), block(NAME, LINE, 2)
    path = tmp_path / "master.py"
    path.write_text(program)
    tap = line.runtime / "plant" / "bus0.master"
    command = [sys.executable, str(path), str(tap)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    (said, wanted) = (float(re.findall(r"-?\d+", text)[-1]) for text in (ran.stdout, shown))
    assert said == pytest.approx(wanted, abs=1)
