"""Old names of commands, which work for a release; and commands that have others below them."""

import json
import subprocess
from collections.abc import Iterator

import pytest
import typer
from typer.testing import CliRunner

from hil.cli.documents.command_tree import commands
from hil.cli.framework.command_classes import OrBelow
from hil.cli.framework.command_group import app
from hil.cli.framework.command_table import COMMANDS, OLD, rows_below
from hil.testing import ServedBench, live
from hil.testing.served_bench import HIL

SHOWN = {command.name: command for command in commands(app).all()}
GOES = "; the old name goes with the next release\n"
CONFIG = {
    "bench": "t",
    "devices": {"m1": {"profile": "mechaduino"}, "s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
}


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(CONFIG) as made:
        yield made


def said(bench: ServedBench, *words: str) -> tuple[int, str, str]:
    """Exit code of a command, and what it prints."""
    command = [*HIL, *words, "--runtime-dir", str(bench.folder / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("old", OLD)
def test_an_old_name_is_hidden_and_has_a_new_one(old: str) -> None:
    assert old not in SHOWN
    new = OLD[old].now.partition(" --")[0]
    assert new in SHOWN
    shown = CliRunner().invoke(app, [*old.split(), "--help"])
    assert shown.exit_code == 0
    assert f"Usage: hil {old} " in shown.output


def test_no_old_name_is_offered_or_listed() -> None:
    shown = CliRunner().invoke(app, ["--help"]).output
    for name in OLD:
        assert f"\n  {name} " not in shown
    assert "moth" in CliRunner().invoke(app, ["moth"]).output
    assert "mother" not in CliRunner().invoke(app, ["moth"]).output


@pytest.mark.parametrize(
    ("words", "given"),
    [
        (["list"], ("run list", [])),
        (["--json", "list"], ("run list", ["--json"])),
        (["-b", "x", "show", "list"], ("run show", ["-b", "x", "list"])),
        (["square.yaml"], ("run", ["square.yaml"])),
        (["./list", "--check"], ("run", ["./list", "--check"])),
        (["--name", "list", "a.yaml"], ("run", ["--name", "list", "a.yaml"])),
        (["--name=list", "a.yaml"], ("run", ["--name=list", "a.yaml"])),
        (["--", "list"], ("run", ["--", "list"])),
        ([], ("run", [])),
    ],
)
def test_a_file_or_a_command_of_the_group(words: list[str], given: tuple[str, list[str]]) -> None:
    root = typer.main.get_command(app)
    run = root.get_command(None, "run")  # type: ignore[attr-defined]
    assert isinstance(run, OrBelow)
    chosen, rest = run.chosen(words)
    name = "run" if chosen is run else f"run {rest[0]}"
    assert (name, rest if chosen is run else rest[1:]) == given


def test_rows_of_old_names_are_their_new_ones() -> None:
    below = [row for name in COMMANDS for row in rows_below(name)]
    old = [row for row in [*COMMANDS.values(), *below] if row.now]
    assert {row.name for row in old} == set(OLD)
    assert all(row.is_hidden for row in old)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("halt", "stop"),
        ("halt --at-once --json", "stop --at-once --json"),
        ("benches --json", "list --joined --json"),
        ("runs --json", "run list --json"),
        ("runs show nothing", "run show nothing"),
        ("runs cancel nothing --json", "run cancel nothing --json"),
        ("mother release bus0.master", "line release bus0.master"),
        ("mother scan bus0.mastr", "line scan bus0.mastr"),
        ("drive m1", "pulses m1"),
        ("play nothing.pcapng bus0.master", "line play nothing.pcapng bus0.master"),
        ("sketch reset s1", "reset s1"),
    ],
)
def test_an_old_name_does_the_same_with_a_word(bench: ServedBench, old: str, new: str) -> None:
    code, out, err = said(bench, *new.split())
    name = next(each for each in sorted(OLD, reverse=True) if f"{old} ".startswith(f"{each} "))
    word = f"hil: `hil {name}` is now `hil {OLD[name].now}`{GOES}"
    assert said(bench, *old.split()) == (code, out, word + err)


def test_a_mistake_does_not_teach_an_old_name(bench: ServedBench) -> None:
    code, _, err = said(bench, "mother", "gcode", "nothing.ngc")
    assert (code, "write `hil gcode --machine FILE`" in err) == (2, True)


def test_the_fields_of_axes_are_the_status_of_these(bench: ServedBench) -> None:
    one = bench.hil("status", "m1", "--json")
    old = json.loads(bench.hil("state", "m1", "--json"))
    assert list(json.loads(one)) == ["m1"]
    assert json.loads(one)["m1"].keys() == old.keys()
    both = bench.hil("status", "s1", "m1")
    assert both.startswith("s1:\n")
    assert "\n\nm1:\n" in both
    assert "\nposition_deg " in bench.hil("status", "m1")
    assert said(bench, "status", "m1", "m7")[0] == 2


def test_a_stop_of_axes(bench: ServedBench) -> None:
    assert said(bench, "stop", "s1") == (0, "s1: nothing moves\n", "")
    code, out, err = said(bench, "stop", "m1", "s7")
    assert (code, out) == (2, "")
    assert "there is no axis 's7'" in err
    assert said(bench, "stop")[2].startswith("hil: the bench runs on; `hil ")
    assert json.loads(said(bench, "stop", "--json")[1]) == {"stopped": [], "runs": [], "refused": {}}
    assert json.loads(bench.hil("list", "--json"))
