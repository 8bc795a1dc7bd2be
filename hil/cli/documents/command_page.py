"""The page of all commands (``docs/commands.md``): the rule of their names, tasks, a line for each, old
names."""

import re
from collections.abc import Iterator

import typer

from hil.cli.documents.command_tree import CliCommand, commands
from hil.cli.documents.tasks import TASKS
from hil.cli.framework.command_group import panel_of
from hil.cli.framework.command_table import OLD, PANELS

_HEAD = """\
# Commands

Written by `hil reference --commands` from the table of commands; do not edit. Options and examples of one:
`hil help COMMAND`, or [the reference](reference.md).

A command is a verb and what it acts on: `hil check bench.yaml`, `hil monitor m1`, `hil replay RECORDING`.
Where a thing has several verbs, the thing comes first: `hil run list`, `hil fault clear`, `hil line scan`.
What any board has is a command of its own (`hil reset m1`, `hil stop m1`); the motions that a board knows are
verbs of `hil axis m1`, which lists them, as in `hil axis m1 move-abs 90`. `hil stop` stops what moves, and
the bench runs on; `hil shutdown` ends the bench. `-b BENCH` chooses among benches that run, and `--json` is
for programs; both stand before the verb or behind it.

Names stand for what a configuration has: `m1` is a device, `arm.elbow` an axis of one, `bus0` a segment, an
RS485 line, `bus0.master` a tap of it. A recording is a file, or its name in `hil recordings`, as `last`.
"""
_FOR = {
    "Bench": "Make a bench, run it, see how it does, end it.",
    "Board": "One board: its terminal, its power, its pins, its program.",
    "Motion": "Axes that move, and how they are stopped.",
    "Recordings": "What was in a run that is over, or goes on.",
    "Wire": "What passes on lines and buses, and a master of them.",
    "Faults": "Failures that are injected, until they are cleared.",
    "Service": "Logs, doctors, help, other programs.",
}


def command_page(app: typer.Typer) -> str:
    """Write Markdown."""
    root = commands(app)
    parts = [_HEAD, *_tasks(), ""]
    for panel in PANELS:
        parts.append(f"## {panel}\n\n{_FOR[panel]}\n\n| command | what it does | example |\n|---|---|---|")
        for command in root.commands:
            if panel_of(command.name) == panel:
                parts += _rows(command)
        parts.append("")
    parts.append(
        "## New names\n\nOld names work until the next release, and say on standard error what is new.\n"
    )
    parts += ["| new | old |", "|---|---|"]
    parts += [f"| `hil {old.now}` | `hil {name}` |" for name, old in OLD.items() if name not in _GROUPS]
    return "\n".join(parts) + "\n"


def _tasks() -> Iterator[str]:
    yield "## By task\n\nWhat you want, and what you type. `hil help WORD` finds a row of it by a word.\n"
    yield "| what you want | what you type |\n|---|---|"
    for want, typed in TASKS:
        yield f"| {want} | `{typed}` |"


_GROUPS = {name for name in OLD if any(each.startswith(f"{name} ") for each in OLD) and name != "runs"}
"""Old names of groups, which do nothing by themselves."""


def _example(command: CliCommand) -> str:
    """Find the first of its examples that is more than its name."""
    examples: list[str] = re.findall(r"^Example: (.+)", command.about, re.M)
    return next((each for each in examples if each != f"hil {command.name}"), examples[0])


def _rows(command: CliCommand) -> Iterator[str]:
    """Write a line for a command, and for those below it. A group that does nothing by itself has none."""
    if command.arguments or not command.commands or len(command.options) > 1:
        words = " ".join([f"hil {command.name}", *(each.usage for each in command.arguments)])
        about, example = (each.replace("|", r"\|") for each in (command.summary, _example(command)))
        yield f"| `{words}` | {about} | `{example}` |"
    for each in command.commands:
        yield from _rows(each)
