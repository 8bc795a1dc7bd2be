"""``hil find`` on the command line: what it prints, its exit codes, and what it says of bad input."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from hil.cli.framework.command_group import app
from hil.testing import Bench

CONFIG = {"bench": "one", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("logs") / "bench.log"
    with Bench(CONFIG) as bench, file.open("w") as opened:
        bench.start()
        bench.run(0.5)
        for text in (b"y", b"x", b"r\r90\r", b"r\r0\r"):
            bench.port("m1").write(text)
            bench.run(400)
        bench.inputs.write_to(opened)
    return file


def find(*words: object) -> Result:
    return CliRunner().invoke(app, ["find", *map(str, words)])


def test_each_time_with_how_long_and_values(log: Path) -> None:
    done = find(log, "abs(m1.e) > 20")
    assert done.exit_code == 0
    *times, last = done.stdout.splitlines()
    assert [line.split()[1:5] for line in times] == [["for", line.split()[2], "m1.e", "is"] for line in times]
    assert times
    assert last.startswith(f"{len(times)} time")


def test_first_last_and_count(log: Path) -> None:
    every = json.loads(find(log, 'm1.sent has "."', "--json").stdout)
    assert every["count"] == len(every["times"]) > 2
    first = json.loads(find(log, 'm1.sent has "."', "--first", "--json").stdout)
    assert first["times"] == every["times"][:1]
    last = json.loads(find(log, 'm1.sent has "."', "--last", "--json").stdout)
    assert last["times"] == every["times"][-1:]
    assert find(log, 'm1.sent has "."', "--count").stdout == f"{every['count']}\n"
    (at_s,) = (each["at_s"] for each in first["times"])
    assert find(log, 'm1.sent has "."', "--first").stdout.startswith(f"{at_s:.15g}s ")
    begins = json.loads(find(log, "m1.loop_on == 1", "--from", "4s", "--json").stdout)["times"][0]
    assert begins["held_s"] is None
    assert begins["values"] == {"m1.loop_on": 1}


def test_at_each_control_step_the_times_are_finer(log: Path) -> None:
    (coarse,), (fine,) = (
        json.loads(find(log, "m1.loop_on == 1", "--every", every, "--json").stdout)["times"]
        for every in ("1ms", "step")
    )
    assert 0 <= coarse["at_ns"] - fine["at_ns"] < 1_000_000
    assert round(fine["at_ns"] * 48 / 7_385_000) * 7_385_000 // 48 == fine["at_ns"]


def test_nothing_is_found(log: Path) -> None:
    done = find(log, "m1.position_deg > 1e6", "--from", "3s", "--to", "4.1s")
    assert done.exit_code == 1
    assert done.stdout.startswith("m1.position_deg > 1e6 does not hold between ")
    assert done.stdout.endswith(" and 4.1s\n")
    done = find(log, "m1.position_deg > 1e6", "--count")
    assert (done.exit_code, done.stdout) == (1, "0\n")


def test_a_log_that_was_cut_is_searched_up_to_there(log: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.log"
    cut.write_bytes(log.read_bytes()[:-40])
    done = find(cut, 'm1.received has "r"')
    assert done.exit_code == 0
    assert "its last lines are missing" in done.stderr
    assert json.loads(find(cut, 'm1.received has "r"', "--json").stdout)["is_cut"] is True


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("m1.positon_deg > 5",), 'did you mean "position_deg"?'),
        (("m1.e >",), "behind > a field or a number is missing; write it as in `m1.e > 5`"),
        ((")",), "a field or a number is missing where ')' stands; write it as in `m1.position_deg > 89`"),
        (("m1.e > 5", "--from", "70s"), "--from: 70s is not within the run, which is "),
        (("m1.e > 5", "--to", "soon"), "--to: 'soon' is no time; write it as 12.5s"),
        (("m1.e > 5", "--from", "3s", "--to", "2s"), "--from 3s is behind --to 2s"),
        (("m1.e > 5", "--every", "1us"), "--every 1us: an interval of 1000 ns; write 50us or more"),
        (("m1.e > 5", "--every", "often"), "--every: 'often' is no time"),
        (("m1.e > 5", "--first", "--count"), "choose one of --first, --last and --count"),
    ],
)
def test_bad_input(log: Path, words: tuple[str, ...], said: str) -> None:
    done = find(log, *words)
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stdout == ""


def test_a_file_that_is_no_log(tmp_path: Path) -> None:
    done = find(tmp_path / "none.log", "m1.e > 5")
    assert done.exit_code == 2
    assert "No such file" in done.stderr
    (tmp_path / "some.log").write_text("{}\n")
    done = find(tmp_path / "some.log", "m1.e > 5")
    assert done.exit_code == 2
    assert "this is no recording" in done.stderr
