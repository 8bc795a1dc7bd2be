"""A bench of a recording is at each time as the bench was, and goes on from there."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from hil.compose.replay import read_log
from hil.recorded.log_changes import ChangeRefused
from hil.recorded.recorded_run import RecordedRun
from hil.sim.inputs import CommitDone, InputLogError
from hil.sim.twin import Twin
from hil.testing import Bench, RecordedBench, UnsupportedHere, replay
from hil.vocab.time import NS_PER_MS, SimTimeNs

CONFIG = {
    "bench": "two",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "memory"}}}},
    "faults": [{"fault": "shaft_load", "target": "m1", "torque_Nm": 0.05}],
}
TO_85 = bytes.fromhex("02550179036400")


class SlowStore:
    """Store that answers when it is told to."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[bool], bool]] = []

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        self.waiting.append(answered)
        return None


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Log of moves, of a packet on a line, and of a calibration table that is written for 70 ms."""
    file, store = tmp_path_factory.mktemp("logs") / "bench.log", SlowStore()
    with Bench(CONFIG, store=store) as bench, file.open("w") as opened:
        bench.start()
        bench.run(0.5)
        for text in (b"y", b"x", b"r\r90\r", b"n", b"c"):
            bench.port("m1").write(text)
            bench.run(150.3)
        bench.tap("bus0.master").write(TO_85)
        while not store.waiting:
            bench.run(100)
        bench.run(70)
        store.waiting.pop()(True)
        bench.run(50)
        bench.port("m1").write(b"s")
        bench.run(300)
        bench.inputs.write_to(opened)
    return file


def commit_ms(log: Path) -> float:
    (at_ns,) = (each.at_ns for each in read_log(log).inputs if isinstance(each.input, CommitDone))
    return at_ns / NS_PER_MS


@pytest.mark.parametrize("until_ms", [0, 0.7, 4250.25, 4600, 10_000])
def test_it_is_as_the_bench_was(log: Path, until_ms: float) -> None:
    run = RecordedRun(read_log(log))
    run.run_until(SimTimeNs(round(until_ms * NS_PER_MS)))
    with RecordedBench(log, until_ms) as bench:
        assert bench.now_ns == run.now_ns
        for axis in run.runtime.parts.axes:
            assert repr(bench.axis(axis).snapshot().as_dict()) == repr(run.runtime.snapshot(axis).as_dict())


def test_followed_to_its_end_it_sends_the_same_bytes(log: Path, tmp_path: Path) -> None:
    then = read_log(log)
    with RecordedBench(log, 4200) as bench:
        bench.follow(5000)
        bench.follow()
        now = bench.inputs.log()
        kept = tmp_path / "again.log"
        with kept.open("w") as file:
            bench.inputs.write_to(file)
    for name in ("m1", "s1"):
        sent = [(each.at_ns, each.port, each.data) for each in now.sent if each.device == name]
        assert sent == [(each.at_ns, each.port, each.data) for each in then.sent if each.device == name]
    assert replay(kept).difference() is None


def test_it_goes_on_alone(log: Path) -> None:
    with RecordedBench(log, 4500) as bench:
        assert bench.port("m1").read() == b""
        bench.port("m1").write(b"n")
        bench.run(50)
        assert bench.axis("m1").snapshot().loop_on == 0
        bench.run(5000)
        assert b"Calibrat" not in bench.port("m1").read()


def test_a_memory_that_was_being_written_answers_when_it_did(log: Path) -> None:
    at_ms = commit_ms(log)
    with RecordedBench(log, at_ms - 20) as bench:
        bench.run(19.9)
        before = bench.port("m1").read()
        bench.run(100)
        assert bench.port("m1").read() != before
        assert bench.inputs.inputs[-1].input == CommitDone(durable=True)
        assert bench.inputs.inputs[-1].at_ns == round(at_ms * NS_PER_MS)
        bench.port("m1").write(b"c")  # another one is answered at once
        bench.run(60_000)
    with RecordedBench(log, at_ms - 20) as bench:
        bench.run(5)
        bench.follow()
        assert [each.data for each in bench.inputs.log().sent] == [each.data for each in read_log(log).sent]


def test_changes_hold_from_the_start(log: Path) -> None:
    with RecordedBench(log, 4500) as was, RecordedBench(log, 4500, settings=["m1.pKp=1"]) as now:
        assert now.axis("m1").snapshot().pKp == 1
        assert was.axis("m1").snapshot().position_deg != now.axis("m1").snapshot().position_deg
    with RecordedBench(log, 4500, settings=["m1.axis.inertia_kg_m2=0.001"]) as heavy:
        heavy.follow(4800)
    with pytest.raises(ChangeRefused, match="pKp"):
        RecordedBench(log, 4500, settings=["m1.pKpp=1"])


def test_what_cannot_be(log: Path, tmp_path: Path) -> None:
    with RecordedBench(log, 4500) as bench:
        end_ms = bench.end_ms
        with pytest.raises(
            ValueError, match=r"until_ms: write 4500 to .*, where the recording ends, not 4499"
        ):
            bench.follow(4499)
        with pytest.raises(UnsupportedHere):
            bench.program(["home.py"])
    for until_ms in (-1, end_ms + 1, float("nan")):
        with pytest.raises(ValueError, match="until_ms: write 0 to "):
            RecordedBench(log, until_ms)
    (tmp_path / "none.log").write_text("{}\n")
    with pytest.raises(InputLogError, match="this is no recording"):
        RecordedBench(tmp_path / "none.log")
    with pytest.raises(FileNotFoundError):
        RecordedBench(tmp_path / "nowhere.log")


def test_the_fixture(log: Path, recorded_bench: Callable[..., RecordedBench]) -> None:
    bench = recorded_bench(log, until_ms=3300)
    assert bench.now_ns == 3300 * NS_PER_MS
