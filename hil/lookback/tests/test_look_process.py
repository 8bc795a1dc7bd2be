"""The process that looks at a recording: its answers are what the bench was, whatever way it goes there."""

import gzip
import json
import os
import select
import signal
import struct
import subprocess
import sys
from base64 import b64decode
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

import pytest

from hil.compose.replay import replay
from hil.lookback.look_head import DROPPED, GIVEN, HEAD, WORKER
from hil.recorded.recorded_run import open_recorded
from hil.sim.log_checks import without_checks
from hil.testing import Bench
from hil.vocab.time import SimTimeNs

pytestmark = pytest.mark.long

S = 1_000_000_000
LONGEST_S = 60


class Looking:
    """Process of a recording, asked one thing after another, or several at a time."""

    def __init__(self, path: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", WORKER, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self._count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        assert self.process.stdin
        assert self.process.stdout
        assert self.process.stderr
        self.process.stdin.close()
        self.process.wait(30)
        self.process.stdout.close()
        self.process.stderr.close()

    def send(self, what: str, lane: str = "", **given: Any) -> int:
        """Ask; answers the request's number."""
        assert self.process.stdin
        self._count += 1
        asked = {
            "lane": lane or what,
            "known_ns": 0,
            "from_ns": given.get("to_ns", 0),
            "points": 1200,
            "most": 400,
        }
        line = json.dumps({**asked, "id": self._count, "what": what, **given})
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()
        return self._count

    def read(self) -> tuple[int, int, bytes]:
        """Next answer: number of the request, how it ended, and its text."""
        assert self.process.stdout
        assert select.select([self.process.stdout], [], [], LONGEST_S)[0], "no answer"
        number, status, length = HEAD.unpack(self.process.stdout.read(HEAD.size))
        return number, status, self.process.stdout.read(length)

    def ask(self, what: str, **given: Any) -> Any:
        """Ask, and answer what comes."""
        self.send(what, **given)
        _, status, text = self.read()
        assert status == GIVEN, text
        return json.loads(text)

    def refused(self, what: str, **given: Any) -> str:
        """Ask for what is refused; answers why."""
        self.send(what, **given)
        _, status, text = self.read()
        assert status != GIVEN
        return text.decode()


def rows_of(series: dict[str, Any]) -> list[tuple[float, ...]]:
    """Rows of a series: a time in seconds, and a value for each field."""
    return list(struct.iter_unpack(f"<{1 + len(series['fields'])}d", b64decode(series["data"])))


TWO = {
    "bench": "two",
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
}
LENGTH_S = 120


def record(bench: Bench, path: Path, until_s: int) -> None:
    """Let a person turn a motor and type, now and then, and write the recording."""
    bench.start()
    bench.device("m1").do("enable")
    fault = None
    for turn in range(int(bench.now_ns / S), until_s, 4):
        bench.device("m1").do("position", position_deg=(turn % 7) * 30.0)
        bench.port("s1").write(b"?\r")
        if turn == 40:
            fault = bench.fault("shaft_load", "m1", torque_Nm=0.01)
        if fault and turn == 60:
            fault.clear()
        bench.run((until_s * S - bench.now_ns) / 1e6 if turn + 4 >= until_s else 4000)
    with path.open("w") as file:
        bench.inputs.write_to(file)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "two.log"
    with Bench(TWO) as bench:
        record(bench, path, LENGTH_S)
    return path


@pytest.fixture(scope="module")
def looking(recording: Path) -> Iterator[Looking]:
    with Looking(recording) as process:
        yield process


@pytest.mark.parametrize("at_ns", [90 * S, 45 * S + 123_456_789, 3 * S, 61 * S])
def test_a_state_is_that_of_a_straight_replay(looking: Looking, recording: Path, at_ns: int) -> None:
    looking.ask("state", to_ns=100 * S)  # check points stand
    told = looking.ask("state", to_ns=at_ns)
    run = open_recorded(recording)
    run.run_until(SimTimeNs(at_ns))
    assert told["at_ns"] == at_ns
    for axis in ("m1", "s1"):
        assert told["axes"][axis] == run.runtime.snapshot(axis).as_dict()
    assert [fault["kind"] for fault in told["faults"]] == (["shaft_load"] if 40 * S < at_ns < 60 * S else [])


def test_bytes_at_a_port_are_those_of_the_log(looking: Looking, recording: Path) -> None:
    """From any check point, up to any time: both ways, in order, with their times."""
    replayed = replay(recording)
    for at_s in (110, 33, 71):
        told = looking.ask("bytes", of="s1", to_ns=at_s * S)["items"]
        sent = [(each.at_ns / 1e9, each.data.hex()) for each in replayed.sent["s1"] if each.at_ns <= at_s * S]
        assert [(each["at_s"], each["hex"]) for each in told if each["to"] == "client"] == sent
        typed = [each for each in told if each["to"] == "board"]
        assert len(typed) == at_s // 4
        assert {each["hex"] for each in typed} == {b"?\r".hex()}


def test_samples_at_full_rate_are_those_of_the_bench(looking: Looking, recording: Path) -> None:
    """A window of a few steps has each sample; a longer one the smallest and the largest of each interval."""
    from_ns, to_ns = 44 * S, 44 * S + S // 10
    told = looking.ask("samples", from_ns=from_ns, to_ns=to_ns, fields=["m1.e", "m1.yw"], points=2000)
    (series,) = told["series"]
    run = open_recorded(recording)
    run.run_until(SimTimeNs(from_ns - 1))
    run.runtime.watch("m1", 0, told["interval_ns"], 4096)
    run.run_until(SimTimeNs(to_ns))
    assert not series["is_summed"]
    rows = rows_of(series)
    assert len(rows) == series["rows"] == len(run.runtime.take_samples("m1", 0)[0]) == 667
    at_s, error_deg, angle_deg = rows[-1]
    run.run_until(SimTimeNs(to_ns))
    assert (error_deg, angle_deg) == (run.runtime.snapshot("m1").e, run.runtime.snapshot("m1").yw)
    assert at_s == pytest.approx(to_ns / 1e9, abs=2e-4)

    summed = looking.ask("samples", from_ns=from_ns, to_ns=to_ns, fields=["m1.e", "m1.yw"], points=100)[
        "series"
    ][0]
    few = rows_of(summed)
    assert summed["is_summed"]
    assert 90 <= len(few) <= 100
    for column in (1, 2):
        assert min(row[column] for row in few) == min(row[column] for row in rows)
        assert max(row[column] for row in few) == max(row[column] for row in rows)
    assert [row[0] for row in few] == sorted(row[0] for row in few)


def test_a_drag_is_followed_by_its_newest_request_alone(looking: Looking) -> None:
    looking.ask("state", to_ns=110 * S)
    sent = [
        looking.send("samples", from_ns=at * S, to_ns=(at + 30) * S, fields=["m1.e"]) for at in range(20, 60)
    ]
    ends = {number: status for number, status, _ in (looking.read() for _ in sent)}
    assert ends[sent[-1]] == GIVEN
    assert sum(status == DROPPED for status in ends.values()) > len(sent) // 2


def test_overview_has_marks_by_lane(looking: Looking) -> None:
    looking.ask("state", to_ns=110 * S)
    told = looking.ask("overview")
    assert told["end_ns"] == pytest.approx(LENGTH_S * S, abs=5 * S)
    assert not told["is_growing"]
    assert told["problem"] == ""
    (fault,) = [mark for mark in told["marks"] if mark["lane"] == "faults"]
    assert fault["text"].startswith("shaft_load")
    assert (fault["of"], fault["to_ns"] - fault["from_ns"]) == ("m1", 20 * S)
    verbs = [mark["text"] for mark in told["marks"] if mark["lane"] == "verbs"]
    assert verbs[0] == "m1 enable"
    assert "marks" not in looking.ask("overview", revision=told["revision"])
    few = [mark for mark in looking.ask("overview", most=5)["marks"] if mark["lane"] == "verbs"]
    assert len(few) <= 6
    assert sum(mark.get("count", 1) for mark in few) == len(verbs)


def test_what_is_not_there_is_refused_in_words(looking: Looking) -> None:
    assert "position_deg" in looking.refused("samples", to_ns=S, fields=["m1.positoin_deg"])
    assert "s1" in looking.refused("bytes", to_ns=S, of="s2")
    assert "there was no wire" in looking.refused("packets", to_ns=S, of="bus0")


def test_times_beyond_the_end_are_the_end(looking: Looking) -> None:
    end_ns = looking.ask("overview")["end_ns"]
    assert looking.ask("state", to_ns=10_000 * S)["at_ns"] == end_ns


def test_check_points_that_are_killed_are_made_again(recording: Path) -> None:
    """Whoever takes them away, as the kernel does where memory is short, what is asked next is answered."""
    with Looking(recording) as looking:
        before = looking.ask("state", to_ns=100 * S)
        for copy in _copies_of(looking.process.pid):
            with suppress(ProcessLookupError):  # it has answered and ended
                os.kill(copy, signal.SIGKILL)
        assert looking.ask("state", to_ns=100 * S) == before


def _copies_of(pid: int) -> list[int]:
    """Processes that were copied from one, and still run."""
    command = Path(f"/proc/{pid}/cmdline").read_bytes()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != pid:
            try:
                if (entry / "cmdline").read_bytes() == command:
                    found.append(int(entry.name))
            except OSError:
                pass
    return found


def test_all_copies_end_with_their_asker(recording: Path) -> None:
    with Looking(recording) as looking:
        looking.ask("state", to_ns=100 * S)
        copies = _copies_of(looking.process.pid)
        assert len(copies) > 5
        looking.process.kill()
    left = [copy for copy in copies if _runs_after(copy)]
    assert not left


def _runs_after(pid: int) -> bool:
    """Wait for the end of a process that is no child; answers whether it runs still after ten seconds."""
    try:
        ended = os.pidfd_open(pid)
    except ProcessLookupError:
        return False
    try:
        return not select.select([ended], [], [], 10)[0]
    finally:
        os.close(ended)


def test_a_recording_that_grows_is_followed(tmp_path: Path) -> None:
    """And what is compressed, too: each piece as far as it was written."""
    path, whole = tmp_path / "grows.log.gz", tmp_path / "whole.log"
    with Bench(TWO) as bench:
        record(bench, whole, 60)
    lines = whole.read_text().splitlines(keepends=True)
    half = len(lines) // 2
    with gzip.open(path, "wt") as file:
        file.writelines(lines[:half])
    with Looking(path) as looking:
        told = looking.ask("overview")
        assert told["is_growing"]
        assert 20 * S < told["end_ns"] < 40 * S
        with gzip.open(path, "at") as file:
            file.writelines(lines[half:])
        while (later := looking.ask("overview"))["is_growing"]:
            pass
        assert later["end_ns"] > told["end_ns"]
        state = looking.ask("state", to_ns=later["end_ns"])
    run = open_recorded(whole)
    run.run_until(SimTimeNs(later["end_ns"]))
    assert state["axes"]["m1"] == run.runtime.snapshot("m1").as_dict()


def test_what_was_logged_late_takes_check_points_back(tmp_path: Path) -> None:
    """A group that is late has inputs of times at which check points stand already."""
    whole, path = tmp_path / "whole.log", tmp_path / "late.log"
    with Bench(TWO) as bench:
        record(bench, whole, 60)
    lines = without_checks(whole.read_text())
    cut = next(at for at, line in enumerate(lines) if '"at_ns":3' in line and len(line.split(",")[0]) == 20)
    path.write_text("".join(lines[:cut]))
    with Looking(path) as looking:
        looking.ask("state", known_ns=50 * S, to_ns=50 * S)
        with path.open("a") as file:
            file.writelines(lines[cut:])
        while looking.ask("overview")["is_growing"]:
            pass
        state = looking.ask("state", to_ns=50 * S)
    run = open_recorded(whole)
    run.run_until(SimTimeNs(50 * S))
    assert state["axes"]["m1"] == run.runtime.snapshot("m1").as_dict()


@pytest.mark.thorough
@pytest.mark.parametrize("has_checks", [True, False])
@pytest.mark.parametrize(
    "line", ["no json", '{"at_ns":50000000000,"device":"m9","input":"reset"}', '{"at_ns":1,"end":0}']
)
def test_what_is_whole_before_damage_is_shown(
    recording: Path, tmp_path: Path, line: str, has_checks: bool
) -> None:
    text = recording.read_text()
    lines = text.splitlines(keepends=True) if has_checks else without_checks(text)
    cut = len(lines) // 2
    path = tmp_path / "damaged.log"
    path.write_text("".join([*lines[:cut], line + "\n", *lines[cut:]]))
    with Looking(path) as looking:
        assert looking.ask("state", to_ns=30 * S)["at_ns"] == 30 * S
        if "m9" in line and not has_checks:
            assert "m9" in looking.refused("state", to_ns=110 * S)
        else:
            assert 40 * S < looking.ask("state", to_ns=110 * S)["at_ns"] < 70 * S
        assert str(path) in looking.ask("overview")["problem"]


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "no.log"
    path.write_text("hello\n")
    with Looking(path) as looking:
        assert looking.process.stderr
        assert "this is no recording" in looking.process.stderr.read().decode()
        assert looking.process.wait(30) == 1


def test_check_points_keep_to_their_number_and_memory(tmp_path: Path) -> None:
    """An hour of two boards: no more than 64, and less than 400 MB that they do not share."""
    path = tmp_path / "hour.log"
    with Bench(TWO) as bench:
        bench.start()
        for _turn in range(360):
            bench.port("s1").write(b"?\r")
            bench.run(10_000)
        with path.open("w") as file:
            bench.inputs.write_to(file)
    with Looking(path) as looking:
        looking.ask("state", to_ns=3500 * S)
        assert "900 s are the most" in looking.refused("samples", from_ns=0, to_ns=901 * S, fields=["m1.e"])
        told = looking.ask("overview")
        assert 30 <= told["check_points"] <= 64
        copies = _copies_of(looking.process.pid)
        assert len(copies) <= 66
        assert sum(map(_pss_kB, copies)) < 400_000


def _pss_kB(pid: int) -> int:
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return 0
    return int(text.split("\nPss:")[1].split()[0])
