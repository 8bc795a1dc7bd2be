"""``hil fault``."""

from collections.abc import Iterable, Iterator
from typing import Annotated, Any

import typer

from hil.cli.boards.axis_command import number_or_text
from hil.cli.boards.time_given import seconds_of
from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.shown_view import Grid, Line, ShownView, line
from hil.vocab.address import owner_of
from hil.vocab.fault_words import GROUPS, example, group_of, shown_by
from hil.vocab.faults import FAULT_KINDS, TARGETS, TIMING, FaultKind
from hil.vocab.near_words import did_you_mean, nearest_or_begun
from hil.vocab.typed_numbers import quoted

NONE = "no fault is active"
_NO_HEAD = ("", "")
"""Columns of a table without names."""
_PATIENCE_S = 2.0
"""Time for a bench's answer that a text can do without."""


def kinds(
    kind: Annotated[
        str | None,
        typer.Argument(
            help="A kind, to have all about it; a group, as encoder; or a place of a running bench, as s2,"
            " or a kind of its boards, as sac: only the kinds that fit it. [default: all kinds, a line each]",
            show_default=False,
        ),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """List the kinds of faults in their groups, or show all about one.

    Example: hil fault kinds encoder_slip

    Example: hil fault kinds s1
    """
    if kind is not None and kind in FAULT_KINDS:
        return _one_kind(FAULT_KINDS[kind], _places_here(bench))
    if kind is None:
        found = list(FAULT_KINDS.values())
    elif kind in GROUPS:
        found = [each for each in FAULT_KINDS.values() if group_of(each) == kind]
    else:
        found = list(_fitting(kind, bench))
    width = max((len(each.name) for each in found), default=0)
    blocks = list[Line | Grid]()
    for group, about in GROUPS.items():
        if inside := [(each.name, each.about) for each in found if group_of(each) == group]:
            head = (f"{group}:".ljust(width), about)
            blocks += [Grid(head, head, inside, prose=head), line("")]
    hint = "`hil fault kinds KIND` has one's parameters, its places and an example."
    view = ShownView(*blocks, line(hint, wraps=True))
    return CommandAnswer([_row(each) for each in found], view.text())


def _row(kind: FaultKind) -> dict[str, Any]:
    return {
        "kind": kind.name,
        "title": kind.title,
        "group": group_of(kind),
        "about": kind.about,
        "shows": shown_by(kind),
        "on": TARGETS[kind.target],
        "parameters": {each.name: each.described() for each in (*kind.parameters, *TIMING)},
        "example": example(kind),
    }


def _one_kind(kind: FaultKind, places: list[dict[str, Any]] | None) -> CommandAnswer:
    """Answer all about a kind. ``places``: of the bench that runs; None: none, or several."""
    fit = None if places is None else [row["place"] for row in places if kind.name in row["kinds"]]
    about = [("group", GROUPS[group_of(kind)]), ("on", TARGETS[kind.target])]
    if fit is not None:
        about.append(("here on", ", ".join(fit) or "nothing: this bench has no such place"))
    about.append(("shows", shown_by(kind)))
    parameters = [(each.name, each.described()) for each in (*kind.parameters, *TIMING)]
    shown = example(kind, fit[0] if fit else "")
    view = ShownView(
        line(f"{kind.name}: {kind.about}", wraps=True),
        *(line(""), Grid(_NO_HEAD, _NO_HEAD, about, prose=_NO_HEAD)),
        *(line("\nparameters"), Grid(_NO_HEAD, _NO_HEAD, parameters, prose=_NO_HEAD)),
        line(f"\nexample\n {shown}"),
        *([] if kind.is_once else [line(" hil fault clear")]),
    )
    row = _row(kind) | {"example": shown}
    return CommandAnswer(row if fit is None else row | {"places": fit}, view.text())


def _places_here(bench: BenchOptions) -> list[dict[str, Any]] | None:
    """Places of the bench that is meant; None: none is, or several are, or it does not answer."""
    import os

    from hil.net.benches_here import find
    from hil.net.control_client import ControlError, ask

    meant = find(bench.runtime_dir, os.environ).running().meant(bench.bench)
    if len(meant) != 1:
        return None
    try:
        places: list[dict[str, Any]] = ask(meant[0].socket, "fault_places", timeout_s=_PATIENCE_S)
    except ControlError:
        return None
    return places


def _fitting(target: str, bench: BenchOptions) -> Iterator[FaultKind]:
    """Kinds that fit a place of a bench. Raises typer.Exit: it has no such place."""
    if (places := _places_here(bench)) is None and (near := nearest_or_begun(target, FAULT_KINDS)):
        raise fail(f"hil: there is no kind of fault {target!r}; {did_you_mean(*near)}", 2)
    if places is None:
        of_place = "those that fit a place of a bench: `hil -b BENCH fault kinds PLACE`"
        raise fail(f"there is no kind of fault {target!r}; `hil fault kinds` lists them, {of_place}", 2)
    known = {row["place"]: row["kinds"] for row in places}
    if target not in known and (of_profile := _places_of_profile(target, known, bench)):
        fit = {kind for place in of_profile for kind in known[place]}
        return (kind for name, kind in FAULT_KINDS.items() if name in fit)
    if target not in known:
        near = nearest_or_begun(target, [*FAULT_KINDS, *GROUPS, *known])
        there = f"`hil fault kinds` lists the kinds, and places here are {', '.join(known) or 'none'}"
        said = f"{did_you_mean(*near[:5])} {there}".strip()
        raise fail(f"hil: there is no kind of fault and no place {target!r}; {said}", 2)
    return (FAULT_KINDS[name] for name in known[target])


def _places_of_profile(profile: str, places: Iterable[str], bench: BenchOptions) -> list[str]:
    """Places of the devices that have a profile, as sac; none: no device of the bench has it."""
    devices = {row["device"] for row in bench.ask("list")["devices"] if row["profile"] == profile}
    return [place for place in places if owner_of(place) in devices]


def inject(
    fault: Annotated[str, typer.Argument(help="Its kind; `hil fault kinds` lists them.")],
    target: Annotated[str, typer.Argument(help="The place of the fault, as in s2.")],
    parameters: Annotated[list[str] | None, typer.Argument(help="As in rate=0.01 towards=board.")] = None,
    for_: Annotated[
        str | None,
        typer.Option(
            "--for",
            metavar="TIME",
            help="How long it lasts, of simulated time: 2s, 500ms, 1min; as for_s=2. [default: until it is"
            " cleared]",
            show_default=False,
        ),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Inject a fault. It lasts until it is cleared, or --for a time.

    Example: hil fault inject byte_drop m1 rate=0.01

    Example: hil fault inject shaft_jam m1 --for 2s
    """
    if fault not in FAULT_KINDS and target in FAULT_KINDS:
        raise fail(f"there is no fault {fault!r}; {did_you_mean(f'hil fault inject {target} {fault}')}", 2)
    words = [*(parameters or []), *([] if for_ is None else [f"for={for_}"])]
    given: dict[str, Any] = {}
    for name, value in map(_parameter, words):
        if name in given:
            raise fail(f"{name} is given twice; leave one out", 2)
        given[name] = value
    answer = bench.ask("inject", fault=fault, target=target, parameters=given)
    return CommandAnswer(answer, f"fault {answer['number']}")


def _parameter(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals:
        raise fail(f'"{text}" is no parameter; write its name before it, as in rate=0.01', 2)
    if name == "for":  # as the faults of `hil replay` have it
        return "for_s", seconds_of(value, "--for")
    return name, number_or_text(value)


def clear(
    number: Annotated[
        str | None,
        typer.Argument(help="A number of `hil fault list`; left out: all faults.", show_default=False),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Clear a fault, or all.

    Example: hil fault clear 1
    """
    if number is not None and not number.isdecimal():
        lists = "write its number, as `hil fault list` shows it; `hil fault clear` alone clears all"
        raise fail(f"{quoted(number)} is no number of a fault; {lists}", 2)
    active = bench.ask("faults")
    numbers = [int(number)] if number is not None else [row["number"] for row in active]
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
