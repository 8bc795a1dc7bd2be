"""``hil line`` at a running bench: what is printed, for people and for programs, and exit codes."""

import json
import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from hil.testing import LiveError, ServedBench, live

pytestmark = pytest.mark.long
CONFIG = {
    "bench": "line",
    "devices": {name: {"profile": "sac"} for name in ("s4", "s5")},
    "segments": {"bus0": {"stations": ["s4", "s5"], "taps": {"master": {"port": "pty"}}}},
}
ROW = " {} , 100 , 1 , 1 , 69 , 4321 , 1 , 10.47 , .5 , 3 , 1 , 2400000 \r\n"
WATCHED = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(CONFIG) as made:
        for number in (4, 5):
            made.type(f"s{number}", b"$CM%d\r" % number, b"$R\r", until=b"SAC>")
        yield made


def on_line(bench: ServedBench, *words: str) -> str:
    return bench.hil("line", *words)


def test_outcomes_of_commands(bench: ServedBench) -> None:
    said = on_line(bench, "send", "bus0.master", "4-5", "v150", "m10")
    assert [line.partition(",")[0] for line in said.splitlines()] == [
        *("4 v150: done", "5 v150: done", "4 m10: done", "5 m10: done")
    ]
    assert on_line(bench, "send", "bus0.master", "all", "v100") == "all v100: sent\n"


def test_outcomes_that_are_not_known_and_refused(bench: ServedBench) -> None:
    bench.hil("fault", "inject", "packet_no_ack", "s4.network")
    with pytest.raises(LiveError, match="exit code 5"):
        on_line(bench, "send", "bus0.master", "4", "m10", "v150")
    bench.hil("fault", "clear")
    bench.hil("fault", "inject", "packet_nak", "s4.network")
    with pytest.raises(LiveError, match="exit code 1"):
        on_line(bench, "send", "bus0.master", "4", "v150")
    bench.hil("fault", "clear")


def test_outcomes_for_programs(bench: ServedBench) -> None:
    (row,) = json.loads(on_line(bench, "send", "bus0.master", "5", "v150", "--json"))
    assert 4 < row.pop("round_trip_ms") < 1000
    assert row == {
        **{"line": "bus0.master", "node": 5, "command": "v150"},
        **{"outcome": "done", "why": "", "tries": 1},
    }


def test_stop_release_and_text(bench: ServedBench) -> None:
    assert on_line(bench, "release", "bus0.master") == "all y: sent\n"
    said = on_line(bench, "stop", "bus0.master", "--nodes", "4", "--at-once").splitlines()
    assert said[0] == "all S: sent"
    assert said[1].startswith("4 S: done")
    assert on_line(bench, "text", "bus0.master", "5", "good", "morning").startswith("5 good morning: done")


def test_scan_and_nodes(bench: ServedBench) -> None:
    (found,) = json.loads(on_line(bench, "scan", "bus0.master", "--addresses", "4-9", "--json"))
    assert [each["node"] for each in found["nodes"]] == [4, 5]
    assert found["addresses"] == 6
    said = on_line(bench, "nodes", "bus0.master", "--addresses", "4-9").splitlines()
    assert [line.split()[:2] for line in said] == [
        ["line", "node"],
        ["bus0.master", "4"],
        ["bus0.master", "5"],
    ]


@pytest.mark.thorough
def test_a_queue_is_there_and_read_back(bench: ServedBench, tmp_path: Path) -> None:
    file = tmp_path / "queue.txt"
    file.write_text("".join(ROW.format(position) for position in range(1, 31)))
    said = on_line(bench, "queue", "bus0.master", "4,5", str(file))
    assert said == "".join(f"{node}: 30 of 30 rows are there; read back, as sent\n" for node in (4, 5))
    rows = json.loads(on_line(bench, "queue", bench.port("bus0.master"), "4", str(file), "--json"))
    assert [(row["done"], row["is_read_back"]) for row in rows] == [(30, False)]


def test_a_queue_with_problems_goes_nowhere(bench: ServedBench, tmp_path: Path) -> None:
    file = tmp_path / "queue.txt"
    file.write_text("".join(ROW.format(position) for position in range(1, 31)).replace("4321", "4000"))
    with pytest.raises(
        LiveError,
        match=r"exit code 2\nhil: 30 problems in .*\n.*queue.txt:1:1: RPM 69 and cycle 4000 contradict",
    ):
        on_line(bench, "queue", "bus0.master", "4", str(file))


def test_what_nodes_say_is_printed_as_it_comes(bench: ServedBench) -> None:
    on_line(bench, "send", "bus0.master", "4", "$O1")
    where = ("--runtime-dir", str(bench.folder / "run"))
    words = ("line", "watch", "bus0.master", "-c", "6", "--json", *where)
    with subprocess.Popen(
        [sys.executable, "-P", "-c", WATCHED, *words], stdout=subprocess.PIPE, text=True
    ) as watching:
        assert watching.stdout
        while watching.poll() is None:  # what is said before it listens is lost
            bench.type("s4", b"m100v300a999d999\r", until=b"SAC>")
            with suppress(subprocess.TimeoutExpired):
                watching.wait(0.5)
        rows = [json.loads(line) for line in watching.stdout]
    assert watching.returncode == 0
    assert len(rows) == 6
    assert {(row["node"], row["kind"]) for row in rows} == {(4, "DC1"), (4, "DC2")}
    times_ms = [row["command_ms"] for row in rows if row["command_ms"] is not None]
    assert times_ms
    assert all(50 < each < 5000 for each in times_ms)
    on_line(bench, "send", "bus0.master", "4", "$O0")


def test_a_live_table_ends_by_a_key(bench: ServedBench) -> None:
    where = ("--runtime-dir", str(bench.folder / "run"))
    words = ("line", "nodes", "bus0.master", "--addresses", "4-6", "--live", *where)
    ours, theirs = pty.openpty()
    with subprocess.Popen([sys.executable, "-P", "-c", WATCHED, *words], stdout=theirs) as going_on:
        os.close(theirs)
        said = b""
        while not re.search(rb"bus0\.master +5 ", said):
            said += os.read(ours, 4096)
        going_on.terminate()
        try:
            while os.read(ours, 4096):
                pass
        except OSError:
            pass
        assert going_on.wait(60) == 0
    os.close(ours)
