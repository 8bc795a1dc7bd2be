"""Parts of ``hil line ...`` that its commands share: lines, nodes, outcomes."""

import re
from collections.abc import Callable, Coroutine, Iterable, Sequence
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.exit_codes import Exit

if TYPE_CHECKING:
    from hil.master import LinePlace, LiveMaster, Transaction
    from hil.vocab.line_node import LineNodes

OneLine = Annotated[
    str,
    typer.Argument(
        help="A tap of the running bench, as bus0.master; or a port: a path, socket://... or rfc2217://...",
        metavar="LINE",
        show_default=False,
    ),
]
Lines = Annotated[
    list[str],
    typer.Argument(
        help="Taps of the running bench, as bus0.master; or ports: paths, socket://... or rfc2217://...",
        metavar="LINE...",
        show_default=False,
    ),
]
NodeNames = Annotated[
    str, typer.Argument(help="Addresses, as 4, 4,7-9 or all.", metavar="NODE", show_default=False)
]
Asked = Annotated[str, typer.Option("--addresses", metavar="NODE", help="Which, as in 4-35.")]
Baud = Annotated[
    int | None, typer.Option("--baud", help="Baud of the line. [default: that of the tap, or 38400]", min=1)
]
Latency = Annotated[
    float | None,
    typer.Option(
        "--latency-ms",
        help="Maximum delay between here and the line, and back. [default: 25 for a tap, 35 for a path, 60]",
        min=0,
        max=10_000,
    ),
]
HasEcho = Annotated[
    bool | None,
    typer.Option(
        "--echo/--no-echo",
        help="Whether the line's adapter echoes what it sends. [default: recognised by itself]",
        show_default=False,
    ),
]
ProfileName = Annotated[
    str | None,
    typer.Option("--profile", help="Kind of the nodes. [default: the one kind that has a master]"),
]
TO_ALL = "all"
MOST_LISTED = 5
_PART = re.compile(r"([0-9]{1,3})(?:-([0-9]{1,3}))?")


class LineOptions(NamedTuple):
    """Options that say how a line is reached."""

    baud: Baud = None
    latency_ms: Latency = None
    profile: ProfileName = None
    echo: HasEcho = None
    bench: BenchOptions = ANY_BENCH


ANY_LINE = LineOptions()


def place_of(line: str, options: LineOptions) -> "LinePlace":
    """Find a line, or say why there is none and end the command."""
    from hil.master import LineUnreachable, find_line
    from hil.master.line_place import is_address, tap_place

    latency_ns = None if options.latency_ms is None else round(options.latency_ms * 1e6)
    of_nodes: dict[str, Any] = {"profile": options.profile, "echo": options.echo}
    try:
        if is_address(line):
            return find_line(line, baud=options.baud, latency_ns=latency_ns, **of_nodes)
        here = options.bench.meant()
        return tap_place(here, line, baud=options.baud, latency_ns=latency_ns, **of_nodes)
    except LineUnreachable as error:
        raise fail(f"hil: {error}", Exit.MISTAKE if error.is_mistake else Exit.FAILED) from None


def on_lines(
    places: Sequence["LinePlace"],
    tries: int,
    work: Callable[[Sequence["LiveMaster"]], Coroutine[Any, Any, Any]],
) -> Any:
    """Do some work with lines that are open; answers its result. A port that goes ends the command."""
    import asyncio

    from hil.master import LineGone, LineUnreachable, open_line

    async def run() -> Any:
        async with AsyncExitStack() as stack:
            masters = [await stack.enter_async_context(open_line(place, tries=tries)) for place in places]
            return await work(masters)

    try:
        return asyncio.run(run())
    except LineUnreachable as error:
        raise fail(f"hil: {error}", Exit.FAILED) from None
    except LineGone as error:
        code = (
            Exit.NOT_KNOWN if any(each.outcome == "not known" for each in error.outstanding) else Exit.FAILED
        )
        raise fail(f"hil: {error}", code) from None
    except ValueError as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None


def addresses(text: str, nodes: "LineNodes") -> list[int]:
    """Read addresses; ``all`` is everybody. Ends the command: they are none."""
    if text == TO_ALL:
        return [nodes.to_all]
    found: list[int] = []
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
        span = range(first, last + 1)
        if not span or not all(each in nodes.addresses for each in span):
            least, most = min(nodes.addresses), max(nodes.addresses)
            why = f"{text!r} are no addresses of nodes: write {least} to {most}, as in 4,7-9, or {TO_ALL}"
            raise fail(f"hil: {why}", Exit.MISTAKE)
        found += [each for each in span if each not in found]
    return found


def asked_of(places: Iterable["LinePlace"], text: str) -> list[list[int] | None]:
    """Read the addresses that are asked on each line; None: all."""
    return [None if text == TO_ALL else addresses(text, place.nodes) for place in places]


def row_of(line: str, sent: "Transaction") -> dict[str, Any]:
    """A transaction for JSON."""
    outcome = sent.outcome
    answered = outcome is not None and outcome.value == "done"
    return {
        "line": line,
        "node": sent.unit,
        "command": sent.command.decode("latin-1"),
        "outcome": outcome.value if outcome else None,
        "why": sent.why,
        "tries": sent.sent,
        "round_trip_ms": round(sent.round_trip_ns / 1e6, 3) if answered else None,
    }


def line_of(row: dict[str, Any], *, names_line: bool) -> str:
    """A transaction for people."""
    where = f"{row['line']} " if names_line else ""
    node = row["node"] or TO_ALL
    said = f"{where}{node} {row['command'].strip()}: {row['outcome']}"
    if row["why"]:
        return f"{said} ({row['why']})"
    if row["round_trip_ms"] is None:
        return said
    tries = f", at try {row['tries']}" if row["tries"] > 1 else ""
    return f"{said}, {row['round_trip_ms']:.1f} ms{tries}"


def exit_of_rows(rows: Iterable[dict[str, Any]]) -> Exit:
    """Exit code of a command by the outcomes of its transactions."""
    outcomes = {row["outcome"] for row in rows}
    if "not known" in outcomes:
        return Exit.NOT_KNOWN
    return Exit.FAILED if outcomes & {"refused", "not sent"} else Exit.DONE
