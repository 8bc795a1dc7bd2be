"""``hil line nodes`` and ``hil line watch``: the nodes of lines, and what they say by themselves."""

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.command_answers import AsJson, CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_view import Grid, ShownView, line
from hil.cli.framework.shown_words import echo_words
from hil.cli.lines.named_lines import (
    ANY_LINE,
    TO_ALL,
    Asked,
    LineOptions,
    Lines,
    asked_of,
    on_lines,
    place_of,
)
from hil.vocab.shown_text import printable

if TYPE_CHECKING:
    import asyncio

    from hil.master import LiveMaster, NodeEvent, NodeRow

ROUND_S = 1.0
"""Interval at which a live table asks each node again."""
PORTS_LOOK_S = 0.1
"""Interval of looks at signals and at ports that may have gone."""
_WORDS = {"DC1": "begins a command", "DC2": "has ended a command"}
_HEADS = ("line", "node", "seen", "round trip", "sent", "lost", "NAK", "state", "command", "text")
_TEXTS = ("line", "state", "text")


def nodes(
    lines: Lines,
    asked: Asked = TO_ALL,
    live: Annotated[bool, typer.Option("--live", help="Ask them again each second, until Ctrl-C.")] = False,
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Show a table of the nodes of lines: when each was seen, its round trip, what was lost.

    Nodes with soft_ops tell whether they move, and how long their last command took.

    Example: hil line nodes bus0.master --addresses 80-90
    """
    places = [place_of(line, options) for line in lines]
    wanted = asked_of(places, asked)

    import asyncio

    echoing: list[str] = []

    async def work(masters: Sequence["LiveMaster"]) -> list[dict[str, Any]]:
        await asyncio.gather(*(live.scan(of, 2) for live, of in zip(masters, wanted, strict=True)))
        if live:
            await _live(masters)
        echoing.extend(_echoing(masters))
        return _rows(masters)

    rows = on_lines(places, 3, work)
    view = _view(rows, echoing)
    return CommandAnswer(rows, "" if live else view.text(), Exit.DONE if rows else Exit.FAILED)


async def _live(masters: Sequence["LiveMaster"]) -> None:
    """Draw the table until a signal comes."""
    import asyncio

    from rich.live import Live

    from hil.cli.framework.consoles import ShownConsole
    from hil.cli.framework.interrupts import noted

    with noted() as interrupts, Live(console=ShownConsole(), auto_refresh=False) as screen:
        while not interrupts:
            screen.update(_view(_rows(masters)), refresh=True)
            await asyncio.gather(asyncio.sleep(ROUND_S), *(each.scan(list(each.table)) for each in masters))


def _rows(masters: Sequence["LiveMaster"]) -> list[dict[str, Any]]:
    return [_row(live, row) for live in masters for row in live.table.values()]


def _row(live: "LiveMaster", row: "NodeRow") -> dict[str, Any]:
    def ms(ns: int | None) -> float | None:
        return None if ns is None else round(ns / 1e6, 3)

    return {
        "line": live.place.name,
        "node": row.address,
        "seen_s_ago": None if row.seen_ns is None else round((live.now_ns() - row.seen_ns) / 1e9, 1),
        "round_trip_ms": ms(row.round_trip_ns),
        "sent": row.sent,
        "lost": row.lost,
        "refusals": row.refusals,
        "strays": row.strays,
        "state": row.state,
        "command_ms": ms(row.command_ns),
        "text": row.text,
        "echo": str(live.echo.state),
    }


def _echoing(masters: Sequence["LiveMaster"]) -> Iterator[str]:
    """Lines whose adapters echo."""
    for live in masters:
        if (echo := live.echo).state == "yes":
            yield f"{live.place.name}: {echo_words(echo.as_dict())}"


def _view(rows: Sequence[dict[str, Any]], echoing: Sequence[str] = ()) -> ShownView:
    """Table of nodes, and below it the lines whose adapters echo."""

    def cells(row: dict[str, Any]) -> tuple[str, ...]:
        trip, command = (row[name] for name in ("round_trip_ms", "command_ms"))
        return (
            row["line"],
            str(row["node"]),
            f"{row['seen_s_ago']:.1f} s ago",
            "" if trip is None else f"{trip:.1f} ms",
            *(str(row[name]) for name in ("sent", "lost", "refusals")),
            row["state"],
            "" if command is None else f"{command:.1f} ms",
            printable(row["text"]),
        )

    table = Grid(_HEADS, _TEXTS, list(map(cells, rows)), prose=("text",))
    return ShownView(
        table if rows else line("no node answers"), *(line(each, wraps=True) for each in echoing)
    )


def watch(
    lines: Lines,
    count: Annotated[
        int | None, typer.Option("--count", "-c", help="End after so many lines.", min=1)
    ] = None,
    as_json: AsJson = False,
    options: LineOptions = ANY_LINE,
) -> None:
    """Print what nodes say by themselves, as it comes, until Ctrl-C: texts, and with soft_ops begin and end
    of each command. Sends nothing.

    Example: hil line watch bus0.master -c 1
    """
    places = [place_of(line, options) for line in lines]

    import asyncio

    async def work(masters: Sequence["LiveMaster"]) -> None:
        began_ns = {live: live.now_ns() for live in masters}
        done = asyncio.Event()
        told = 0

        def show(live: "LiveMaster", event: "NodeEvent") -> None:
            nonlocal told
            if done.is_set():
                return
            told += 1
            typer.echo(_said(live, event, event.at_ns - began_ns[live], as_json))
            if told == count:
                done.set()

        for live in masters:
            live.listeners.append(partial(show, live))
        await _until(done, masters)

    on_lines(places, 1, work)


async def _until(done: "asyncio.Event", masters: Sequence["LiveMaster"]) -> None:
    """Wait for the end, a signal, or a port that has gone. Raises LineGone."""
    import asyncio

    from hil.cli.framework.interrupts import noted

    with noted() as interrupts:
        while not (done.is_set() or interrupts):
            for live in masters:
                if live.gone:
                    raise live.gone
            with suppress(TimeoutError):
                async with asyncio.timeout(PORTS_LOOK_S):
                    await done.wait()


def _said(live: "LiveMaster", event: "NodeEvent", after_ns: int, as_json: bool) -> str:
    row = live.master.table[event.node]
    command_ms = row.command_ns / 1e6 if event.kind == "DC2" and row.command_ns is not None else None
    if as_json:
        return json.dumps(
            {
                "line": live.place.name,
                "after_s": round(after_ns / 1e9, 6),
                "node": event.node,
                "kind": event.kind,
                "text": event.text,
                "command_ms": command_ms,
            }
        )
    said = _WORDS.get(event.kind, f"{event.kind}: {printable(event.text)}")
    if command_ms is not None:
        said += f", which took {command_ms:.1f} ms"
    return f"{after_ns / 1e9:12.6f} {live.place.name} {event.node} {said}"
