"""``hil axis``: verbs of a device, from the shell."""

from typing import Annotated, Any

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench, fail

TIMEOUT_S = 30
"""Maximum wait for an answer: a real board's terminal takes its time."""


def axis(
    device: Annotated[str, typer.Argument(help="A device of the bench, as in m1.", show_default=False)],
    verb: Annotated[
        str | None, typer.Argument(help="As in move-abs; left out: list what there is.", show_default=False)
    ] = None,
    values: Annotated[
        list[str] | None,
        typer.Argument(help="In the order of the list, or as in velocity_rpm=120.", show_default=False),
    ] = None,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Ask something of a device: hil axis m1 move-abs 90."""
    table = {row["verb"]: row for row in ask_bench(bench, runtime_dir, "verbs", device=device)}
    if verb is None:
        _list(table)
        return
    name = verb.replace("-", "_")
    if name not in table:
        known = ", ".join(each.replace("_", "-") for each in table)
        raise fail(f"hil: {device} has no {verb!r}; it has {known}", 2)
    given = _given(list(table[name]["parameters"]), table[name]["texts"], values or [])
    answer = ask_bench(
        bench, runtime_dir, "do", timeout_s=TIMEOUT_S, device=device, name=name, parameters=given
    )
    for key, value in answer.items():
        typer.echo(f"{key}: {value:.10g}" if isinstance(value, float) else f"{key}: {value}")


def _list(table: dict[str, dict[str, Any]]) -> None:
    for name, row in table.items():
        typer.echo(f"{name.replace('_', '-')}: {row['about']}")
        for parameter, described in row["parameters"].items():
            typer.echo(f"  {parameter}: {described}")


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
                raise fail(f"hil: there is no parameter {wrong!r}; {takes}", 2)
            if not name:
                raise fail(f"hil: {value!r} is too much; {takes}", 2)
        if name in given:
            raise fail(f"hil: {name} is given twice", 2)
        given[name] = text if name in texts else _value(text)
    return given


def _value(text: str) -> float | int | str:
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            continue
    return text
