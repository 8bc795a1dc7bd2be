"""A firmware that is stopped from outside, at a point that simulated time does not tell: the replay stops it
in the same turn, with the same bytes, and runs on."""

import io
from collections.abc import Iterator
from typing import Any

import pytest

from device_profiles.mechaduino.firmware import COMMANDS_BY_LETTER, Command
from hil.compose.replay import replay
from hil.sim.bench import BenchHooks
from hil.sim.firmware_guard import FirmwareHung
from hil.sim.input_log import InputLogWriter
from hil.sim.log_checks import without_checks
from hil.testing import Bench
from hil.vocab.firmware import Delay

MACHINE: dict[str, Any] = {"is_slow": False}
"""State of the machine, on which a run in real time depends, and its replay does not."""


def query(board: Any) -> Iterator[Delay]:
    """Replacement of the Mechaduino's ``query``: much of what a board can do in one turn, and an endless
    loop."""
    board.serial.print("before ")
    yield Delay(0)
    board.axis.output(30.0, 200)
    board.axis.set("pKp", 3.0)
    board.axis.spi(0xFFFC)
    for number in range(5 if MACHINE["is_slow"] else 5000):
        board.serial.print(f"{number} ")
        if number % 3 == 0:
            yield Delay(0)
    if MACHINE["is_slow"]:
        raise FirmwareHung("one step took more than it may")


def query_at_once(board: Any) -> None:
    for _ in query(board):
        pass


def answer_q(monkeypatch: pytest.MonkeyPatch, body: Any) -> None:
    monkeypatch.setitem(COMMANDS_BY_LETTER, ord("q"), Command("q", "", body))


@pytest.fixture
def slow() -> Iterator[None]:
    MACHINE["is_slow"] = True
    yield
    MACHINE["is_slow"] = False


def logged_bench(config: dict[str, Any]) -> tuple[Bench, io.StringIO]:
    with Bench(config) as fresh:
        memories = {"m1": fresh._runtime.devices["m1"].nvm}
    log = io.StringIO()
    return Bench(config, around=BenchHooks(log=InputLogWriter(log, "test", config, memories))), log


def logged_run(device: dict[str, Any], act: Any) -> io.StringIO:
    """Log of a run in which ``act`` gets the firmware stopped, and somebody uses it afterwards."""
    config = {
        "bench": "f",
        "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}} | device},
    }
    bench, log = logged_bench(config)
    bench.run(ms=4500)
    bench.fault("byte_flip", "m1", rate=0.02, seed=4)
    act(bench)
    bench.run(ms=300)
    assert str(bench.device("m1").failed).startswith("FirmwareHung: one step took more than it may (")
    bench.axis("m1").load_torque_Nm = 0.05
    bench.device("m1").reset()
    bench.run(ms=5000)
    bench.port("m1").write(b"p")
    bench.run(ms=300)
    log.seek(0)
    return log


def typed(bench: Bench) -> None:
    bench.port("m1").write(b"sq")
    bench.run(ms=10)
    bench.port("m1").write(b"pppp")


@pytest.mark.parametrize("device", [{}, {"plant": "full"}, {"baud": 115200}, {"baud": 9600}], ids=str)
@pytest.mark.parametrize("body", [query, query_at_once])
def test_the_replay_stops_where_the_run_did(
    slow: None, monkeypatch: pytest.MonkeyPatch, device: dict[str, Any], body: Any
) -> None:
    answer_q(monkeypatch, body)
    log = logged_run(device, typed)
    assert '"input":"stopped","turn":' in log.getvalue()
    MACHINE["is_slow"] = False
    assert replay(log).difference() is None


def test_a_stop_that_does_not_come_again_is_told(slow: None, monkeypatch: pytest.MonkeyPatch) -> None:
    answer_q(monkeypatch, query)
    text = logged_run({}, typed).getvalue()
    lines = without_checks(text)
    moved = [line.replace('"turn":', '"turn":1000') for line in lines]
    difference = replay(moved).difference()
    assert difference is not None
    MACHINE["is_slow"] = False
    without = [line for line in lines if '"stopped"' not in line]
    assert replay(without).difference() is not None


def test_what_a_firmware_has_no_memory_for_is_no_matter_of_simulated_time(
    slow: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def deep(board: Any) -> None:
        board.serial.print("x")
        if MACHINE["is_slow"]:
            deep(board)

    answer_q(monkeypatch, deep)
    config = {"bench": "f", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
    bench, log = logged_bench(config)
    bench.run(ms=4500)
    bench.port("m1").write(b"q")
    assert "RecursionError" in str(bench.device("m1").failed)
    MACHINE["is_slow"] = False
    log.seek(0)
    assert replay(log).difference() is None
