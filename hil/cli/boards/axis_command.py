"""``hil axis``: verbs of a device, from the shell."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.shown_words import shown_number
from hil.vocab.near_words import meant

TIMEOUT_S = 30
"""Maximum wait for an answer: a real board's terminal takes its time."""
MOTION_S = 3700.0
"""Maximum wait for a motion's end: the bench's own limit, and a little more."""
_OF_MOTION = ("effective_at_ns", "ends_after_ns", "set_point")
"""Keys of a verb's answer that describe its motion; the operation `wait` takes them."""


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
        return CommandAnswer(list(table.values()), "\n".join(_listed(table)))
    name = verb.replace("-", "_")
    if name not in table:
        known = [each.replace("_", "-") for each in table]
        raise fail(f"hil: {device} has no {verb!r}; {meant(verb, known)}", 2)
    given = _given(list(table[name]["parameters"]), table[name]["texts"], values or [])
    answer = bench.ask("do", timeout_s=TIMEOUT_S, device=device, name=name, parameters=given)
    if wait:
        begun = {name: answer[name] for name in _OF_MOTION if name in answer}
        ended = bench.ask("wait", timeout_s=MOTION_S, device=device, **begun)
        answer |= {"done": not ended["interrupted"], **ended}
    lines = [
        f"{key}: {shown_number(value)}" if isinstance(value, float) else f"{key}: {value}"
        for key, value in answer.items()
    ]
    if answer.get("interrupted"):
        lines.append("something else ended the motion")
    return CommandAnswer(answer, "\n".join(lines), 1 if answer.get("interrupted") else 0)


def _listed(table: dict[str, dict[str, Any]]) -> Iterator[str]:
    for name, row in table.items():
        yield f"{name.replace('_', '-')}: {row['about']}"
        for parameter, described in row["parameters"].items():
            yield f"  {parameter}: {described}"


def _given(names: list[str], texts: list[str], values: list[str]) -> dict[str, Any]:
    """Map parameters' names to values; values without a name are in order."""
    given: dict[str, Any] = {}
    left = iter(names)
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or name not in names:
            wrong, name, text = name if equals else "", next(left, ""), value
            takes = f"it takes {', '.join(names) or 'nothing'}"
            if wrong and name not in texts:
                raise fail(f"hil: there is no parameter {wrong!r}; {meant(wrong, names, takes)}", 2)
            if not name:
                raise fail(f"hil: {value!r} is too much; {takes}", 2)
        if name in given:
            raise fail(f"hil: {name} is given twice", 2)
        given[name] = text if name in texts else number_or_text(text)
    return given


def number_or_text(text: str) -> float | int | str:
    """Value as it was typed: a number if it is one."""
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            continue
    return text
