"""``hil replay`` on the command line: times of a run, what if, and what it says of bad input."""

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
        for text in (b"y", b"x", b"r\r", b"90\r", b"p"):
            bench.port("m1").write(text)
            bench.run(300.25)
        bench.inputs.write_to(opened)
    return file


def replay(*words: object) -> Result:
    return CliRunner().invoke(app, ["replay", *map(str, words)])


def test_alone_it_is_identical(log: Path) -> None:
    done = replay(log)
    assert (done.exit_code, done.stdout[:10]) == (0, "identical:")


@pytest.mark.parametrize("option", ["m1.pKp=15", "m1.plant=simple", "seed=0"])
def test_what_it_was_already_changes_nothing(log: Path, option: str) -> None:
    done = replay(log, "--set", option, "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["identical"]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "option",
    [
        ("--set", "m1.pKp=10"),
        ("--set", "m1.axis.inertia_kg_m2=0.0001"),
        ("--set", "m1.plant=full"),
        ("--fault", "shaft_load m1 torque_Nm=0.05 at=4.5s for=0.1s"),
    ],
)
def test_what_if_tells_where_the_runs_part_and_draws_them(
    log: Path, option: tuple[str, str], tmp_path: Path
) -> None:
    done = replay(log, *option)
    assert done.exit_code == 0, done.output
    assert done.stdout.startswith("the runs part at ")
    picture = tmp_path / "then.svg"
    told = json.loads(replay(log, *option, "-o", picture, "--json").stdout)
    assert not told["identical"]
    assert picture.read_text().count("<svg") == 1


def test_bad_input_is_told_with_its_remedy(log: Path) -> None:
    for words, said in (
        (("--set", "m1.pKq=10"), "pKp"),
        (("--set", "m9.pKp=10"), "m9"),
        (("--set", "m1.pKp"), "="),
        (("--set", "m1.pKp=many"), "write 0 to"),
        (("--until", "99999s"), "within the run"),
        (("--until", "yesterday"), "12.5s"),
        (("--field", "m1.positon_deg", "--set", "m1.pKp=10"), "position_deg"),
    ):
        done = replay(log, *words)
        assert done.exit_code == 2, (words, done.output)
        assert said in done.stderr, (words, done.output)
