"""Answers of commands: text for people, or with --json one line of JSON for programs, in one shape.

A command that tells something answers a ``CommandAnswer``, and has the option --json by that. Of one that
fails the line is ``{"error": {"message": ..., "exit_code": ...}}``, with ``problems`` where the message lists
some.
"""

import dataclasses
import functools
import inspect
import json
import re
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.hints import pasteable
from hil.host.shown_stream import own

if TYPE_CHECKING:
    from hil.host.doctor import Diagnosis

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


def tell_findings(findings: "list[Diagnosis]", as_json: bool) -> None:
    """Print the findings of a doctor, in their order. Raises Exit with 1: something is a problem."""
    from hil.host.doctor import healthy

    if as_json:
        typer.echo(json.dumps([dataclasses.asdict(finding) for finding in findings]))
    else:
        from hil.cli.views import doctor_view, long_lines

        long_lines().print(doctor_view(findings))
    if not healthy(findings):
        raise typer.Exit(1)


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
