"""``hil fault``."""

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hil.cli.boards.axis_command import number_or_text
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.vocab.faults import FAULT_KINDS, TARGETS, TIMING, FaultKind
from hil.vocab.near_words import meant

NONE = "no fault is active"


def kinds(
    target: Annotated[
        str | None,
        typer.Argument(
            help="A place of a running bench, as in s2: only the kinds that fit it.", show_default=False
        ),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """List the kinds of faults with their parameters.

    Example: hil fault kinds m1
    """
    found = list(FAULT_KINDS.values() if target is None else _fitting(bench.ask("fault_places"), target))
    rows = [
        {
            "kind": kind.name,
            "title": kind.title,
            "about": kind.about,
            "on": TARGETS[kind.target],
            "parameters": {each.name: each.described() for each in (*kind.parameters, *TIMING)},
        }
        for kind in found
    ]
    lines = []
    for kind in found:
        lines.append(f"{kind.name}: {kind.about}; on {TARGETS[kind.target]}")
        lines += [f"  {each.name}: {each.described()}" for each in kind.parameters]
    lines += ["every kind:", *(f"  {each.name}: {each.described()}" for each in TIMING)]
    return CommandAnswer(rows, "\n".join(lines))


def _fitting(places: list[dict[str, Any]], target: str) -> Iterator[FaultKind]:
    """Kinds that fit a place of a bench. Raises typer.Exit: it has no such place."""
    known = {row["place"]: row["kinds"] for row in places}
    if target not in known:
        raise fail(f"hil: there is no {target!r}; {meant(target, list(known))}")
    return (FAULT_KINDS[name] for name in known[target])


def inject(
    fault: Annotated[str, typer.Argument(help="Its kind; `hil fault kinds` lists them.")],
    target: Annotated[str, typer.Argument(help="The place of the fault, as in s2.")],
    parameters: Annotated[list[str] | None, typer.Argument(help="As in rate=0.01 towards=board.")] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Inject a fault. It lasts until it is cleared.

    Example: hil fault inject byte_drop m1 rate=0.01
    """
    given: dict[str, Any] = {}
    for name, value in map(_parameter, parameters or []):
        if name in given:
            raise fail(f"hil: {name} is given twice", 2)
        given[name] = value
    answer = bench.ask("inject", fault=fault, target=target, parameters=given)
    return CommandAnswer(answer, f"fault {answer['number']}")


def _parameter(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals:
        raise fail(f'hil: "{text}" is no parameter; write it as in rate=0.01', 2)
    return name, number_or_text(value)


def clear(
    number: Annotated[
        int | None,
        typer.Argument(help="A number of `hil fault list`; left out: all faults.", show_default=False),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Clear a fault, or all.

    Example: hil fault clear 1
    """
    active = bench.ask("faults")
    numbers = [number] if number is not None else [row["number"] for row in active]
    for each in numbers:
        bench.ask("clear", number=each)
    return CommandAnswer({"cleared": numbers}, "\n".join(f"fault {each} cleared" for each in numbers) or NONE)


def list_faults(bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """List the faults that are active.

    A fault without for_s lasts until it is cleared.

    Example: hil fault list
    """
    rows = bench.ask("faults")
    lines = []
    for row in rows:
        said = [str(row["number"]), row["kind"], row["target"], *_parameters_said(row["parameters"])]
        changed = f", {row['changed_bytes']} bytes" if "changed_bytes" in row else ""
        lines.append(" ".join(said) + changed)
    return CommandAnswer(rows, "\n".join(lines) or NONE)


def _parameters_said(parameters: dict[str, Any]) -> Iterator[str]:
    """Parameters of a fault as they are typed; without those of its timing that say nothing."""
    timing = {each.name: each.default for each in TIMING}
    for name, value in parameters.items():
        if value != timing.get(name):
            yield f"{name}={value:.15g}" if isinstance(value, float) else f"{name}={value}"
