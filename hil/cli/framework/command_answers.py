"""Answers of commands: text for people, or with --json one line of JSON for programs, in one shape.

A command that tells something answers a ``CommandAnswer``, and has the option --json by that. Of one that
fails the line is ``{"error": {"message": ..., "exit_code": ...}}``, with ``problems`` where the message lists
some. Command lines that messages name, as in `hil reset m1`, have the options without which they would not
work where they are pasted.
"""

import dataclasses
import functools
import inspect
import json
import re
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.host.shown_stream import own

AsJson = Annotated[bool, typer.Option("--json", help="JSON for programs.")]
_PROBLEM = re.compile(r"([^\n:]+):(\d+):(\d+): (.*) \((.*)\)")
_OPTION = "--json"


@dataclasses.dataclass(frozen=True)
class CommandAnswer:
    """Answer of a command. ``text``: what a person reads; empty: nothing is printed."""

    answer: Any
    text: str = ""
    exit_code: int = 0
    is_harmless: bool = False
    """True if there is nothing of others in the text, or it was made harmless: it may have colours."""


def telling(command: Any) -> Any:
    """Wrap a command so that typer knows its options: a parameter that is a group of options, a named tuple,
    is those. One that answers a ``CommandAnswer`` has --json, and the answer is printed."""
    signature = inspect.signature(command)
    parameters, tells = list(signature.parameters.values()), signature.return_annotation is CommandAnswer

    @functools.wraps(command)
    def tell(**given: Any) -> None:
        as_json = tells and given.pop("as_json")
        told = command(**{each.name: _gathered(each, given) for each in parameters})
        if not tells:
            return
        if as_json:
            typer.echo(json.dumps(told.answer))
        elif told.text:
            typer.echo(pasteable(told.text), file=own(sys.stdout) if told.is_harmless else None)
        if told.exit_code:
            raise typer.Exit(told.exit_code)

    options = [option for each in parameters for option in _options(each)]
    if tells:
        place = next((i for i, each in enumerate(options) if each.name == "bench"), len(options))
        options.insert(place, _option("as_json", AsJson, False))
    tell.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    tell.__annotations__ = {each.name: each.annotation for each in options}
    return tell


def _is_group(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, tuple)


def _option(name: str, kind: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)


def _options(parameter: inspect.Parameter) -> list[inspect.Parameter]:
    """Options of a parameter: itself, or those of its group."""
    if not _is_group(kind := parameter.annotation):
        return [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)]
    return [option for each in _fields(kind) for option in _options(each)]


def _fields(group: Any) -> list[inspect.Parameter]:
    return [_option(name, group.__annotations__[name], group._field_defaults[name]) for name in group._fields]


def _gathered(parameter: inspect.Parameter, given: dict[str, Any]) -> Any:
    """Value of a parameter: what was given, or its group of that."""
    if not _is_group(kind := parameter.annotation):
        return given[parameter.name]
    return kind(*(_gathered(each, given) for each in _fields(kind)))


def wants_json() -> bool:
    """True if the command line asks for JSON, whether or not it could be understood."""
    words = sys.argv[1:]
    if words[:1] == ["with-lines"]:
        return False  # it would be another program's option
    return _OPTION in words[: words.index("--") if "--" in words else None]


def error_line(message: str, exit_code: int) -> str:
    """Error of a command as a line of JSON."""
    error: dict[str, Any] = {"message": message.removeprefix("hil: "), "exit_code": exit_code}
    found = [_PROBLEM.fullmatch(line) for line in message.split("\n")]
    problems = [
        {"file": each[1], "line": int(each[2]), "column": int(each[3]), "message": each[4], "remedy": each[5]}
        for each in found
        if each
    ]
    return json.dumps({"error": error | ({"problems": problems} if problems else {})})


_HINT = re.compile(r"`hil ([a-z][^`]*)`")
_words: list[str] = []
_root: list[Any] = []
"""The command `hil`, once its line is read."""
_NAMING = ("device", "axes", "target", "sources", "line", "lines", "bus", "tap", "fields")
"""Parameters whose values name parts of a bench."""
names: list[str] = []
"""Names on the command line that parts of a bench have."""
chosen: list[Path] = []
"""Folder of the bench that was chosen by these names."""


def begin(root: Any) -> None:
    """Begin a command line of ``root``, which asks no bench yet."""
    _root[:], _words[:], names[:], chosen[:] = [root], [], [], []


def note_names(given: Mapping[str, Any]) -> None:
    """Note which parts of a bench a command names, by the values of its parameters."""
    values = [given[each] for each in _NAMING if given.get(each)]
    each_alone = [[value] if isinstance(value, str) else value for value in values]
    names[:] = [word for part in each_alone if isinstance(part, list | tuple) for word in part]


def ask_with(words: list[str]) -> None:
    """Note the options that the bench needs which this command line asks: as ``Found.options`` says them."""
    _words[:] = words


def pasteable(text: str, words: list[str] | None = None) -> str:
    """Text whose command lines in backquotes have the options ``words``; None: those that were noted."""
    options = shlex.join(_words if words is None else words)
    if not options:
        return text
    return _HINT.sub(lambda hint: f"`hil {options} {hint[1]}`" if _may_ask(hint[1]) else hint[0], text)


def all_pasteable(answer: Any, words: list[str] | None = None) -> Any:
    """A bench's answer with all its texts as ``pasteable`` has them."""
    if isinstance(answer, str):
        return pasteable(answer, words)
    if isinstance(answer, list):
        return [all_pasteable(each, words) for each in answer]
    if isinstance(answer, dict):
        return {name: all_pasteable(each, words) for name, each in answer.items()}
    return answer


def _may_ask(line: str) -> bool:
    if not _root:
        return False
    command = _root[0]
    for word in line.split():
        if not (below := hasattr(command, "commands") and command.get_command(None, word)):
            break
        command = below
    return asks_a_bench(command)


def asks_a_bench(command: Any) -> bool:
    """True if a command's --bench is one that runs: ``Bench`` of ``ask.py``, by its parameter's name."""
    return any(each.name == "bench" for each in command.params)
