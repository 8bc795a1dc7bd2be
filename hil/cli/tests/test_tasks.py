"""Tasks of the page of commands: each line is taken, and does at a bench what the page says."""

import json
import shlex
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from hil.cli.documents.command_page import command_page
from hil.cli.documents.tasks import TASKS, TaskRow, tasks_about
from hil.cli.framework.command_group import app
from hil.cli.tests.test_grammar import parsed
from hil.testing import ServedBench, live
from hil.testing.served_bench import HIL

CONFIG = {
    "bench": "tasks",
    "speed": 4,
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}},
}
START_MS = 5000
"""Time in which a Mechaduino starts, which is 4 s, and a little more."""
SQUARE = "run: square\naxes: {m1: {}}\nsteps: [{move: {m1: 9000}}, {move: {m1: 0}}]\n"
ELSEWHERE = {
    "init": "test_help_examples.py",
    "check": "test_help_examples.py",
    "serve": "test_help_examples.py",
    "shutdown": "test_help_examples.py",
    "virtual": "test_help_examples.py",
    "doctor": "its exit code says what it finds here",
    "gcode": "test_help_examples.py",
    "sketch": "test_help_examples.py",
    "parity": "there is no board",
    "bundle": "test_help_examples.py",
    "monitor": "it goes on until Ctrl-]",
    "top": "it goes on until q",
    "capture": "it goes on until Ctrl-C",
    "log commands": "test_log_commands.py: no commands are kept here",
    "list --connect": "test_help_examples.py: no router is here",
    "diff": "test_help_examples.py: there is one recording",
    "axis m1 calibrate": "half a minute",
}
"""Lines that are not carried out here, by how they begin, and why."""
HERE = [task for task in TASKS if not any(task.line.startswith(f"hil {begin}") for begin in ELSEWHERE)]


@pytest.mark.parametrize("task", TASKS, ids=[task.line for task in TASKS])
def test_a_line_is_taken(task: TaskRow) -> None:
    words = shlex.split(task.line)
    assert words[0] == "hil"
    parsed(words[1:])
    assert not task.want.endswith(".")


def test_the_page_has_them() -> None:
    page = command_page(app)
    assert [task for task in TASKS if f"| {task.want} | `{task.line}` |" not in page] == []


def test_a_word_finds_its_tasks() -> None:
    assert [task.line for task in tasks_about("jam")] == ["hil fault inject shaft_jam m1 --for 2s"]
    assert "hil capture bus0 -w bus0.pcapng" in [task.line for task in tasks_about("wireshark")]
    assert tasks_about("frobnicate") == []


def test_help_of_a_word_is_its_tasks() -> None:
    shown = CliRunner().invoke(app, ["help", "jam"])
    assert (shown.exit_code, "hil fault inject shaft_jam m1 --for 2s" in shown.output) == (0, True)
    guessed = CliRunner().invoke(app, ["help", "start"])
    assert (guessed.exit_code, "hil serve bench.yaml" in guessed.output) == (0, True)
    assert "`hil docs frobnicate` searches" in CliRunner().invoke(app, ["help", "frobnicate"]).output
    for words in (["frobnicate"], ["fault", "jam"]):
        wrong = CliRunner().invoke(app, ["help", *words])
        assert (wrong.exit_code, "there is no command" in wrong.output) == (2, True)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedBench]:
    folder = tmp_path_factory.mktemp("tasks")
    (folder / "square.yaml").write_text(SQUARE)
    with live(CONFIG) as made:
        made.type("s2", b"$CM86\r", b"$R\r", until=b"SAC>")
        made.folder_of_files = folder  # type: ignore[attr-defined]
        yield made


@pytest.mark.long
def test_each_does_it_at_a_bench(bench: ServedBench) -> None:
    """In the order of the page, as somebody who reads it from above."""
    failed = dict[str, str]()
    for task in HERE:
        code, said = carried_out(bench, shlex.split(task.line)[1:])
        if code:
            failed[task.line] = said
        if task.line == "hil reset m1":
            bench.run(START_MS)
    assert "\n".join(map(str, failed.items())) == ""
    nodes = json.loads(bench.hil("list", "--json"))[0]["nodes"]
    assert {"node": "s2.network", "id": 86, "bus": "bus0"} in nodes


def carried_out(bench: ServedBench, words: list[str]) -> tuple[int, str]:
    """Exit code and words of a command, in the folder of the run; ``last`` is this bench's recording. A
    replay that parts and a condition that never held are no failures."""
    folder: Path = bench.folder_of_files  # type: ignore[attr-defined]
    words = [str(bench.recording_file) if word in ("last", "run.hil.gz") else word for word in words]
    words = [{"12s": "1s", "13s": "2s"}.get(word, word.replace("at=12.5s", "at=1s")) for word in words]
    command: Any = typer.main.get_command(app)
    options = {flag for each in _command(command, words).params for flag in each.opts}
    if "--runtime-dir" in options:
        words = [*words, "--runtime-dir", str(bench.folder / "run")]
    done = subprocess.run([*HIL, *words], cwd=folder, capture_output=True, text=True, check=False)
    may_differ = words[0] in ("replay", "find")
    return (0 if done.returncode == 1 and may_differ else done.returncode), done.stdout + done.stderr


def _command(command: Any, words: list[str]) -> Any:
    for word in words:
        if not hasattr(command, "commands") or (below := command.get_command(None, word)) is None:
            break
        command = below
    return command
