"""Programs beside a bench in a process of its own, in real time."""

import sys
from pathlib import Path

import pytest

from hil.testing import NoPythonProgram, ProgramRunsOn, live

pytestmark = pytest.mark.long  # they start daemons

BENCH = {"bench": "t", "speed": 20, "devices": {"s1": {"profile": "sac"}}}
ASKS = """
import sys, serial
with serial.Serial(sys.argv[1], 38400, timeout=20) as port:
    port.write(b"vd\\r")
    print(port.read_until(b"SAC>"))
"""


def test_programs_have_ports_by_names_and_by_a_map(tmp_path: Path) -> None:
    file = tmp_path / "asks.py"
    file.write_text(ASKS)
    with live(BENCH, capture=False) as b:
        for words in ([file, "s1"], ["python", str(file), "/dev/ttyUSB0"]):
            program = b.program(words, map={"/dev/ttyUSB0": "s1"})
            assert program.wait(timeout_ms=600_000) == program.returncode == 0
            assert "0\\t0" in program.stdout
        runs_on = b.program(["sleep", "1000"])
        with pytest.raises(ProgramRunsOn, match="has not ended within 100 ms"):
            runs_on.wait(timeout_ms=100)
        silent = b.program([sys.executable, "-c", "exit(3)"])
        assert silent.wait() == 3
        report = dict(b.report())
        assert report["program (runs)"] == ""
        assert report["program (ended with 3)"] == ""
    assert not runs_on.is_running
    assert "0\\t0" in program.stdout  # what it has said stays


def test_mistakes_are_as_on_simulated_time() -> None:
    with live(BENCH, capture=False) as b:
        with pytest.raises(NoPythonProgram, match=r"nothing\.py: there is no such program"):
            b.program(["nothing.py"])
        with pytest.raises(KeyError, match="there is no port 'm7'"):
            b.program(["sleep", "1"], map={"x": "m7"})
        with pytest.raises(ValueError, match="a program is a list of words"):
            b.program([])
        assert b.programs == []
