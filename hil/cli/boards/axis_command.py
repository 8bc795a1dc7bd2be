"""``hil axis``: verbs of a device, from the shell."""

import re
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hil.cli.boards.any_board import OF_ANY_BOARD, of_any_board, say_own_command
from hil.cli.boards.axis_sentences import VerbDone, sentence
from hil.cli.boards.motion_bar import motion_bar
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.paused_note import told_if_paused
from hil.vocab.near_words import meant
from hil.vocab.typed_numbers import is_unit, number_problem, typed_number, unit_in
from hil.vocab.verbs import COMMON

TIMEOUT_S = 30
"""Maximum wait for an answer: a real board's terminal takes its time."""
MOTION_S = 3700.0
"""Maximum wait for a motion's end: the bench's own limit, and a little more."""
_OF_MOTION = ("effective_at_ns", "ends_after_ns", "set_point")
"""Keys of a verb's answer that describe its motion; the operation `wait` takes them."""
_OPTION = re.compile("--[a-z]")
_OPTIONS = ("--wait", "--bench", "--runtime-dir", "--json", "--help")


def axis(
    device: Annotated[str, typer.Argument(help="A device of the bench, as in m1.", show_default=False)],
    verb: Annotated[
        str | None, typer.Argument(help="As in move-abs; left out: list what there is.", show_default=False)
    ] = None,
    values: Annotated[
        list[str] | None,
        typer.Argument(help="In the order of the list, or as in velocity_rpm=120.", show_default=False),
    ] = None,
    wait: Annotated[
        bool, typer.Option("--wait", help="Wait until the motion that it begins has ended.")
    ] = False,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Carry out a verb of a device, or list its verbs.

    With --wait it exits with 1 if something else ended the motion.

    Example: hil axis m1 move-abs 90 --wait
    """
    table = {row["verb"]: row for row in bench.ask("verbs", device=device)}
    if verb is None:
        return CommandAnswer(list(table.values()), "\n".join([*_listed(table), of_any_board(device, table)]))
    name = verb.replace("-", "_")
    if name not in table:
        raise fail(_no_verb(device, verb, table), Exit.MISTAKE)
    row = table[name]
    given = _given(verb, list(row["parameters"]), row["texts"], values or [])
    answer = bench.ask("do", timeout_s=TIMEOUT_S, device=device, name=name, parameters=given)
    if wait:
        begun = {name: answer[name] for name in _OF_MOTION if name in answer}
        with told_if_paused(bench.meant().socket), motion_bar(bench, device, name, answer):
            ended = bench.ask("wait", timeout_s=MOTION_S, device=device, **begun)
        answer |= {"done": not ended["interrupted"], **ended}
    said = sentence(VerbDone(device, name, given, answer, row["about"]))
    if name in OF_ANY_BOARD:
        say_own_command(device, name)
    return CommandAnswer(answer, said, Exit.FAILED if answer.get("interrupted") else Exit.DONE)


def _no_verb(device: str, verb: str, table: dict[str, dict[str, Any]]) -> str:
    """Error of a verb that a device has not: says which it has."""
    known = [each.replace("_", "-") for each in table]
    if _OPTION.match(verb):
        return _no_option(verb)
    if not isinstance(typed_number(verb), str) and "move_abs" in table:
        line = f"hil axis {device} move-abs {verb}"
        return f"{device} has no {verb!r}; write a verb before the value, as in `{line}`"
    nor = "" if set(table) - {each.name for each in COMMON} else ", nor any verb that moves a motor"
    return f"{device} has no {verb!r}{nor}; {meant(verb, known)}"


def _no_option(word: str) -> str:
    return f"there is no option {word} of `hil axis`; {meant(word, _OPTIONS, '`hil axis --help` lists them')}"


def _listed(table: dict[str, dict[str, Any]]) -> Iterator[str]:
    for name, row in table.items():
        if name in OF_ANY_BOARD:
            continue
        yield f"{name.replace('_', '-')}: {row['about']}"
        for parameter, described in row["parameters"].items():
            yield f"  {parameter}: {described}"


def _given(verb: str, names: list[str], texts: list[str], values: list[str]) -> dict[str, Any]:
    """Map parameters' names to values; values without a name are in order."""
    given: dict[str, Any] = {}
    left = iter(names)
    for before, value in zip(["", *values], values, strict=False):
        if is_unit(value) and not isinstance(typed_number(before.rpartition("=")[2]), str):
            of = next(reversed(given))
            unit = f"{before.rpartition('=')[2]} {value}"
            raise fail(f"{of}: {'; '.join(number_problem(unit, unit_in(of)))}", Exit.MISTAKE)
        name, equals, text = value.partition("=")
        if not equals or name not in names:
            wrong, name, text = name if equals else "", next(left, ""), value
            takes = f"it takes {', '.join(names) or 'nothing'}"
            if _OPTION.match(value) and name not in texts:
                raise fail(_no_option(value), Exit.MISTAKE)
            if wrong and name not in texts:
                why = f"there is no parameter {wrong!r} of {verb}; {meant(wrong, names, takes)}"
                raise fail(why, Exit.MISTAKE)
            if not name:
                raise fail(f"{value!r} is too much for {verb}; {takes}", Exit.MISTAKE)
        if name in given:
            raise fail(f"{name} is given twice; write it once", Exit.MISTAKE)
        given[name] = text if name in texts else typed_number(text)
    return given


def number_or_text(text: str) -> float | int | str:
    """Value as it was typed: a number if it is one."""
    return typed_number(text)
