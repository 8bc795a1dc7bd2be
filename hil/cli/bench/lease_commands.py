"""``hil lease``: take a bench for a while, and give it back."""

import json
import re
import time
from datetime import datetime
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import AsJson, CommandAnswer
from hil.cli.lab.lab_options import NO_LAB, LabOptions
from hil.vocab.lease import time_said

_SECONDS = {"s": 1.0, "min": 60.0, "h": 3_600.0, "d": 86_400.0}
_PIECE = re.compile(r"(\d+\.?\d*|\.\d+)\s*(s|min|h|d)\s*")
NOBODY = "nobody has a lease; everybody may command"

For = Annotated[
    str | None,
    typer.Option("--for", metavar="TIME", help="Time from now to its end: 2h, 90min, 1d. [default: 1h]"),
]
Until = Annotated[
    str | None,
    typer.Option(
        "--until", metavar="TIME", help='Its end instead, in local time: 17:30, "2026-12-01 09:00".'
    ),
]


def lease(
    context: typer.Context,
    as_json: AsJson = False,
    bench: BenchOptions = ANY_BENCH,
    lab: LabOptions = NO_LAB,
) -> None:
    if context.invoked_subcommand is None:
        answer = _asked(bench, lab, "lease")
        typer.echo(json.dumps(answer) if as_json else said(answer))


def _asked(bench: BenchOptions, lab: LabOptions, operation: str, **given: Any) -> dict[str, Any]:
    """Ask the bench here, or one of a lab by its name."""
    if not lab.are_given:
        here: dict[str, Any] = bench.ask(operation, **given)
        return here
    return lab.asked(bench.bench, "/".join(reversed(operation.split("_"))), given)  # lease/take


def show(bench: BenchOptions = ANY_BENCH, lab: LabOptions = NO_LAB) -> CommandAnswer:
    """Show who has the bench, until when, and why.

    Example: hil lease show
    """
    answer = _asked(bench, lab, "lease")
    return CommandAnswer(answer, said(answer))


def begin(
    why: Annotated[str, typer.Option("--why", metavar="WHY", help="What for, in a line, for the others.")],
    length: For = None,
    until: Until = None,
    door: Annotated[
        list[str] | None,
        typer.Option(
            "--door",
            metavar="DOOR",
            help="Leave a door open that does not know who asks, may be repeated: ports, modbus, can, web,"
            " zenoh.",
        ),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
    lab: LabOptions = NO_LAB,
) -> CommandAnswer:
    """Take a lease of a bench: others may look and not command, until it ends.

    Serial ports and other doors that do not know who asks are closed to commands, except those of --door. A
    stop is never refused.

    Example: hil lease take --for 2h --why "press tests"
    """
    answer = _asked(bench, lab, "take_lease", why=why, doors=door or [], **_end(length, until))
    return CommandAnswer(answer, said(answer))


def renew(
    length: For = None,
    until: Until = None,
    bench: BenchOptions = ANY_BENCH,
    lab: LabOptions = NO_LAB,
) -> CommandAnswer:
    """Let your lease end at another time, counted from now.

    Example: hil lease renew --for 1h
    """
    answer = _asked(bench, lab, "renew_lease", **_end(length, until))
    return CommandAnswer(answer, said(answer))


def give(bench: BenchOptions = ANY_BENCH, lab: LabOptions = NO_LAB) -> CommandAnswer:
    """Give your lease back before its end.

    Example: hil lease give
    """
    return CommandAnswer(_asked(bench, lab, "give_lease"), "given back")


def end_anothers(bench: BenchOptions = ANY_BENCH, lab: LabOptions = NO_LAB) -> CommandAnswer:
    """End a lease of somebody else. The bench's log and its events say who did.

    Example: hil lease break
    """
    before = _asked(bench, lab, "lease")["lease"]
    answer = _asked(bench, lab, "break_lease")
    return CommandAnswer(answer, f"the lease of {before['user']} is over" if before else "it is over")


def said(answer: dict[str, Any]) -> str:
    """Format an answer in lines: holder, end, reason, doors, and what was not delivered."""
    if (row := answer["lease"]) is None:
        return NOBODY
    until = time.strftime("%Y-%m-%d %H:%M", time.localtime(row["until_wall_ns"] / 1e9))
    lines = [f"{row['user']} until {until} ({time_said(row['left_s'])} more): {row['why']}"]
    if row["closed"]:
        lines.append(f"closed to commands: {', '.join(row['closed'])}")
    if counts := row["undelivered"]:
        bytes_said = ", ".join(f"{label} {count}" for label, count in counts.items())
        lines.append(f"bytes that were not delivered: {bytes_said}")
    return "\n".join(lines)


def _end(length: str | None, until: str | None) -> dict[str, Any]:
    if until is None:
        return {"for_s": _length_s(length or "1h")}
    if length is not None:
        raise fail("hil: write either --for or --until", 2)
    return {"until_wall_ns": _until_ns(until)}


def _length_s(text: str) -> float:
    pieces = list(_PIECE.finditer(text.strip().lower()))
    if not pieces or "".join(piece[0] for piece in pieces) != text.strip().lower():
        raise fail(f"--for: {text!r} is no length of time; write a number and s, min, h or d, as in 90min", 2)
    return sum(float(piece[1]) * _SECONDS[piece[2]] for piece in pieces)


def _until_ns(text: str) -> int:
    """Read a time of today, or a date with one; without a zone it is local."""
    now = datetime.now()
    for form in ("%H:%M", "%H:%M:%S"):
        try:
            clock = datetime.strptime(text.strip(), form).time()
        except ValueError:
            continue
        return int(datetime.combine(now.date(), clock).timestamp() * 1e9)
    try:
        return int(datetime.fromisoformat(text.strip()).timestamp() * 1e9)
    except (ValueError, OverflowError):
        raise fail(f'hil: --until {text}: write it as in 17:30 or "2026-12-01 09:00"', 2) from None
