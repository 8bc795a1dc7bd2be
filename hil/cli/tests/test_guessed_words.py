"""Words that newcomers type, and tasks that the page of commands answers."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from hil.cli.documents.command_page import command_page
from hil.cli.framework.command_group import app
from hil.cli.framework.guessed_words import GUESSES, guessed
from hil.cli.tests.test_grammar import parsed

ROOT = typer.main.get_command(app)
TASKS = {
    "stop everything": "stop",
    "stop only s1 and m1, at once": "stop s1 m1 --at-once",
    "end the bench": "shutdown",
    "start my bench": "serve bench.yaml",
    "is my configuration right": "check bench.yaml",
    "which benches run here, and at which ports": "list",
    "which benches are joined to mine": "list --joined",
    "where does m1 stand, and how warm is it": "status m1",
    "what passes on bus0": "capture bus0",
    "which address has s2": "list",
    "send a command to node 85": "line send bus0.master 85 v150 m300",
    "who commanded this bench yesterday": "log commands",
    "run my G-code": "gcode part.ngc --machine mill.yaml",
    "move m1 to 90 degrees, and wait": "axis m1 move-abs 90 --wait",
    "make s2 stop acknowledging": "fault inject packet_no_ack s2.network",
    "let all be well again": "fault clear",
    "pause the run square on its path": "run pace square 0",
    "talk to m1": "monitor m1",
    "what happened in yesterday's run": "recordings",
    "play a captured line again": "line play bus0.pcapng bus0.master",
    "have the bench for two hours": "lease take --for 2h --why tests",
}
"""Tasks, and what a reader of the page alone writes."""


@pytest.mark.parametrize("task", TASKS)
def test_a_task_is_one_command_of_the_page(task: str) -> None:
    parsed(shlex.split(TASKS[task]))
    words = [word for word in TASKS[task].split() if re.fullmatch("[a-z-]+", word)]
    page = command_page(app)
    assert any(f"| `hil {' '.join(words[:count])}" in page for count in (2, 1))


@pytest.mark.parametrize("word", GUESSES)
def test_a_guessed_word_is_no_command_and_leads_to_one(word: str) -> None:
    done = CliRunner().invoke(app, [word, "m1"])
    assert done.exit_code == 2
    assert f"`hil {GUESSES[word]}`" in done.output
    for line in GUESSES[word].split("` and `hil "):
        words = shlex.split(line)
        names = [words[0]] if len(words) == 1 else words[:2]
        assert ROOT.get_command(None, names[0]) is not None  # type: ignore[attr-defined]
        shown = CliRunner().invoke(app, [*names[:1], "--help"])
        assert shown.exit_code == 0


def test_a_word_that_nobody_guesses() -> None:
    assert guessed("frobnicate") == ""
    assert guessed("Move_Abs") == GUESSES["move-abs"]


@pytest.mark.parametrize("words", ["help", "help run", "help fault inject", "help line send"])
def test_help_is_the_help_of_the_command(words: str) -> None:
    shown, asked = (CliRunner().invoke(app, line) for line in (words.split(), [*words.split()[1:], "--help"]))
    assert (shown.exit_code, shown.output) == (0, asked.output)


def test_help_of_what_is_no_command() -> None:
    done = CliRunner().invoke(app, ["help", "stp"])
    assert done.exit_code == 2
    assert "stop" in done.output


def test_the_version_is_a_word_too() -> None:
    assert CliRunner().invoke(app, ["version"]).output == CliRunner().invoke(app, ["--version"]).output


def test_the_module_is_the_program(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "hil", "run"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "hil run [OPTION...] FILE" in done.stderr
    assert "python" not in done.stderr
