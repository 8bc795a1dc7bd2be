"""Programs on the bench of a test."""

from pathlib import Path

import pytest

from hil.testing import Bench, NoPythonProgram, ProgramRunsOn
from hil.vocab.time import NS_PER_S

BOARDS = {
    "bench": "b",
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
}
TURNS = """
import serial, sys, time
m = serial.Serial(sys.argv[1], 115200, timeout=1); m.reset_input_buffer()
for text in (b"x", b"r90\\r\\n", b"y"):
    m.write(text); time.sleep(1); print(time.monotonic(), m.read_all(), flush=True)
sys.exit(3)
"""


def file_of(folder: Path, text: str) -> Path:
    path = folder / "program.py"
    path.write_text(text)
    return path


def test_a_test_and_its_program_see_one_bench(tmp_path: Path) -> None:
    with Bench(BOARDS) as b:
        b.port("s1").write(b"$?\r")
        done = b.program([file_of(tmp_path, TURNS), "/dev/ttyUSB0"], map={"/dev/ttyUSB0": "m1"})
        before_ns = b.now_ns
        assert done.wait() == 3
        assert 3 * NS_PER_S <= b.now_ns - before_ns < 3.001 * NS_PER_S
        assert done.stdout.count("\n") == 3
        assert done.stderr == ""
        sent = b"".join(data for _, data in b.port("m1").timeline)
        heard = [line.partition(" ")[2] for line in done.stdout.splitlines()]
        assert all(eval(each) in sent for each in heard)


def test_a_fault_in_the_middle_is_seen_by_the_program(tmp_path: Path) -> None:
    text = """
import serial, time
s = serial.Serial("m1", 115200, timeout=0.5); s.reset_input_buffer()
for _ in range(4): s.write(b"p"); print(len(s.readline()) > 20, flush=True); time.sleep(0.5)
"""
    with Bench(BOARDS) as b:
        p = b.program([file_of(tmp_path, text)])
        b.run(ms=800)
        assert p.stdout == "True\nTrue\n"
        b.device("m1").reset()
        assert p.is_running
        p.wait()
        assert p.stdout.splitlines()[2] == "False"


def test_a_program_goes_on_while_its_test_reads_at_a_port(tmp_path: Path) -> None:
    text = """
import serial, time
s = serial.Serial("m1", 115200); time.sleep(0.3); s.write(b"p"); time.sleep(1); print("end", flush=True)
"""
    with Bench(BOARDS) as b, b.serial("m1", timeout=2) as beside:
        p = b.program([file_of(tmp_path, text)])
        beside.reset_input_buffer()
        before_ns = b.now_ns
        assert beside.readline().startswith(b"stepNumber")  # what the program asked for
        assert 0.3 * NS_PER_S <= b.now_ns - before_ns < 0.5 * NS_PER_S
        assert p.is_running
        assert beside.read(1) == b""
        assert p.stdout == "end\n"
        assert not p.is_running


def test_two_runs_are_the_same(tmp_path: Path) -> None:
    def run() -> tuple[str, object]:
        with Bench(BOARDS) as b:
            p = b.program([file_of(tmp_path, TURNS), "m1"])
            for _ in range(10):
                b.run(ms=333.3)
            return p.stdout, b.port("m1").timeline

    assert run() == run()


def test_a_program_that_runs_on_is_told_with_what_it_waits_for(tmp_path: Path) -> None:
    text = 'import serial\ns = serial.Serial("m1"); s.reset_input_buffer()\ns.read(1)'
    with Bench(BOARDS) as b:
        p = b.program([file_of(tmp_path, text)])
        with pytest.raises(
            ProgramRunsOn, match=r"within 2000 ms:\n  MainThread waits for read at m1 at .*:3"
        ):
            p.wait(timeout_ms=2000)
        assert p.is_running
        with pytest.raises(ValueError, match="another program runs on this bench"):
            b.program([file_of(tmp_path, text)])


def test_mistakes_are_told(tmp_path: Path) -> None:
    with Bench(BOARDS) as b:
        with pytest.raises(NoPythonProgram, match=r"nothing\.py: there is no such program"):
            b.program(["nothing.py"])
        with pytest.raises(KeyError, match="there is no port 'm7'"):
            b.program(["nothing.py"], map={"x": "m7"})
        with pytest.raises(ValueError, match="a program is a list of words"):
            b.program([])
        p = b.program([file_of(tmp_path, "1 / 0")])
        assert p.wait() == 1
        assert "ZeroDivisionError" in p.stderr


def test_a_program_by_its_module(tmp_path: Path) -> None:
    with Bench(BOARDS) as b:
        p = b.program(["-m", "this"], cwd=tmp_path)
        assert p.wait() == 0
        assert "Beautiful is better than ugly" in p.stdout
