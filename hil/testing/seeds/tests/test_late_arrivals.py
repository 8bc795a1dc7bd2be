"""Bytes that arrive within a window behind their writing."""

import pytest

from hil.sim.inputs import Bytes
from hil.testing import Bench

BOARD = {"bench": "b", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
WINDOW_NS = 5_000_000
PROGRAM = """
import serial, sys, time
with serial.Serial("m1", timeout=1) as port:
    for _ in range(5):
        port.write(b"p")
        print(time.monotonic_ns(), port.readline())
"""


def delays_ns(seed: int, window_ms: float = 5) -> list[int]:
    """How late each of 40 bytes was."""
    with Bench(BOARD, seed, arrival_window_ms=window_ms) as bench:
        bench.start()
        written_ns = []
        for _ in range(40):
            written_ns.append(bench.now_ns)
            bench.port("m1").write(b"p")
            bench.run(ms=20)
        at_ns = [each.at_ns for each in bench.inputs.inputs if isinstance(each.input, Bytes)]
        return [at - written for at, written in zip(at_ns, written_ns, strict=True)]


def test_each_piece_comes_within_the_window_at_a_time_of_the_seed():
    drawn = delays_ns(3)
    assert drawn == delays_ns(3) != delays_ns(4)
    assert 0 <= min(drawn) < WINDOW_NS / 5
    assert WINDOW_NS * 4 / 5 < max(drawn) <= WINDOW_NS
    assert len(set(drawn)) > 35
    assert set(delays_ns(3, 0)) == {0}


def test_no_piece_overtakes_one_before_it():
    with Bench(BOARD, 3, arrival_window_ms=50) as bench:
        bench.start()
        for number in range(20):
            bench.port("m1").write(b"%d" % number)
        bench.run(ms=60)
        pieces = [each.input.data for each in bench.inputs.inputs if isinstance(each.input, Bytes)]
        assert pieces == [b"%d" % number for number in range(20)]
        assert bench.arrivals.due_ns > bench.now_ns


def test_a_read_waits_for_the_answer_to_bytes_that_come_late():
    def times(seed: int, window_ms: float = 5) -> list[int]:
        with Bench(BOARD, seed, arrival_window_ms=window_ms) as bench:
            bench.start()
            with bench.serial("m1", timeout=1) as port:
                port.reset_input_buffer()
                made = []
                for _ in range(10):
                    port.write(b"p")
                    assert port.readline().startswith(b"stepNumber")
                    made.append(bench.now_ns)
                return made

    assert times(1) == times(1) != times(2)
    assert 0 < times(1)[-1] - times(1, 0)[-1] <= 10 * WINDOW_NS


@pytest.mark.thorough
def test_a_program_has_them_late_too(tmp_path):
    (tmp_path / "ask.py").write_text(PROGRAM)

    def run(seed: int, window_ms: float) -> str:
        with Bench(BOARD, seed, arrival_window_ms=window_ms) as bench:
            program = bench.program([tmp_path / "ask.py"])
            bench.run(ms=3)
            bench.port("m1").write(b"\n")  # the test's own, meanwhile
            assert program.wait() == 0, program.stderr
            late = [each.at_ns for each in bench.inputs.inputs if isinstance(each.input, Bytes)]
            return f"{late} {program.stdout}"

    assert run(1, 5) == run(1, 5) != run(2, 5)
    assert run(1, 0) == run(2, 0) != run(1, 5)


@pytest.mark.parametrize("window_ms", [-1, 60_001])
def test_a_window_has_bounds(window_ms):
    with pytest.raises(ValueError, match="a window of arrival is 0 to 60000 ms, not"):
        Bench(BOARD, arrival_window_ms=window_ms)
