"""The maker's own library as the master, at the pty of a bench that is served."""

import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from pytrinamic.connections import ConnectionManager
from pytrinamic.tmcl import TMCLReplyStatusError

from hil.testing import ServedBench, live

BENCH = Path(__file__).parents[1] / "bench.yaml"
TURN = 51_200


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedBench]:
    with live(BENCH) as served:
        yield served


@pytest.fixture
def master(bench: ServedBench) -> Iterator[Any]:
    port = bench.port("bus0.master")
    connection = ConnectionManager(f"--interface serial_tmcl --port {port} --data-rate 9600")
    with connection.connect() as interface:
        interface.set_timeout(20)
        yield interface


def until(condition: Callable[[], Any]) -> None:
    end_s = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < end_s


def test_it_finds_the_modules(master: Any) -> None:
    assert master.get_version_string(1)[4] == "V"
    assert master.get_global_parameter(66, 0, 3) == 3


@pytest.mark.parametrize("module", [1, 3])
def test_it_moves_rotates_and_stops_an_axis(master: Any, module: int) -> None:
    master.set_axis_parameter(4, 0, 2 * TURN, module)
    master.set_axis_parameter(1, 0, 0, module)
    assert master.move_to(0, TURN, module) == TURN
    until(lambda: master.get_axis_parameter(8, 0, module))
    here = master.get_axis_parameter(1, 0, module, signed=True)
    assert here == pytest.approx(TURN, abs=300)
    master.move_by(0, -2 * TURN, module)
    until(lambda: master.get_axis_parameter(8, 0, module))
    assert master.get_axis_parameter(1, 0, module, signed=True) == pytest.approx(-TURN, abs=300)
    master.rotate(0, TURN, module)
    until(lambda: abs(master.get_axis_parameter(3, 0, module, signed=True) - TURN) < TURN // 10)
    master.stop(0, module)
    until(lambda: abs(master.get_axis_parameter(3, 0, module, signed=True)) < TURN // 100)


def test_it_is_told_what_a_module_does_not_do(master: Any) -> None:
    with pytest.raises(TMCLReplyStatusError):
        master.set_axis_parameter(6, 0, 256, 1)
    with pytest.raises(TMCLReplyStatusError):
        master.reference_search(0, 0, 1)


def test_outputs_keep_their_levels(master: Any) -> None:
    master.set_digital_output(1, 1)
    assert (master.get_digital_output(1, 1), master.get_digital_output(0, 1)) == (1, 0)


def test_status_shows_modules(bench: ServedBench, master: Any) -> None:
    master.get_axis_parameter(6, 0, 1)
    (row,) = bench.ask("segments")
    assert row["nodes"]["m1.tmcl"]["unit"] == 1
    assert re.search(r"m1\.tmcl +1 ", bench.hil("status"))


def test_a_capture_is_in_words(bench: ServedBench, master: Any) -> None:
    master.move_to(0, TURN, 1)

    def said() -> str:
        command = [Path(sys.executable).with_name("hil"), "decode", bench.capture_file]
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout

    until(lambda: "from 1: ok MVP 51200" in said())
    assert "to 1: MVP ABS 0 51200" in said()
