"""``hil line``: the master of a line. Commands, texts, release, stop, and the search for nodes."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.progress_bars import bar
from hil.cli.lines.named_lines import (
    ANY_LINE,
    TO_ALL,
    Asked,
    LineOptions,
    Lines,
    NodeNames,
    OneLine,
    addresses,
    asked_of,
    exit_of_rows,
    line_of,
    on_lines,
    place_of,
    row_of,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hil.master import LiveMaster, Transaction

Tries = Annotated[int, typer.Option("--tries", help="How often a packet goes out at most.", min=1, max=100)]


def send(
    line: OneLine,
    node: NodeNames,
    commands: Annotated[
        list[str], typer.Argument(help="As typed at a node.", metavar="COMMAND...", show_default=False)
    ],
    tries: Tries = 3,
    keep_going: Annotated[
        bool, typer.Option("--keep-going", help="Go on with a node that has not done a command.")
    ] = False,
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Send commands to nodes, and say what became of each.

    No command is carried out twice. One that may come twice (a setting) is repeated when no answer comes, a
    motion is not: it is "not known" then. A refused one is repeated. Behind a command that is not done, a
    node gets no more. Exits with 1 if one was refused, with 5 if an outcome is not known.

    Example: hil line send bus0.master 85 v150 m300
    """
    place = place_of(line, options)
    units = addresses(node, place.nodes)

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        (live,) = masters
        for command in commands:  # all are tried before the first goes out
            for unit in units:
                live.master.nodes.encode(unit, command.encode("latin-1"))
        rows, left = [], list(units)
        for command in commands:
            sent = [live.start(unit, command) for unit in left]
            await live.settled(sent)
            rows += [row_of(line, each) for each in sent]
            rows += [_not_sent(line, unit, command) for unit in units if unit not in left]
            if not keep_going:
                left = [each.unit for each in sent if each.outcome in ("done", "sent")]
        return rows

    return told(on_lines([place], tries, work), names_line=False)


def text(
    line: OneLine,
    node: NodeNames,
    words: Annotated[
        list[str], typer.Argument(help="What is shown there.", metavar="WORD...", show_default=False)
    ],
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Show words at the terminals of nodes.

    Example: hil line text bus0.master 85 good morning
    """
    place = place_of(line, options)
    units = addresses(node, place.nodes)

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        (live,) = masters
        data = place.nodes.text(" ".join(words))
        sent = [live.start(unit, data) for unit in units]
        await live.settled(sent)
        return [row_of(line, each) for each in sent]

    return told(on_lines([place], 3, work), names_line=False)


def release(
    lines: Lines,
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Let all motions begin that wait for the sync: one packet to all. Nobody answers that.

    Example: hil line release bus0.master
    """
    places = [place_of(line, options) for line in lines]

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        sent = [(each, each.start(each.master.nodes.to_all, each.master.nodes.release)) for each in masters]
        for live, one in sent:
            await live.settled([one])
        return [row_of(live.place.name, one) for live, one in sent]

    return told(on_lines(places, 1, work), names_line=len(lines) > 1)


def stop(
    lines: Lines,
    at_once: Annotated[bool, typer.Option("--at-once", help="Without a deceleration.")] = False,
    node: Annotated[
        str, typer.Option("--nodes", metavar="NODE", help="Nodes that are told one by one, too, and answer.")
    ] = "",
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Stop all motion on lines: by a packet to all, which nobody answers, then node by node if you name them.

    Each stops with the deceleration that was set for it, and drops what waits. Exits with 5 if one that was
    named does not answer.

    Example: hil line stop bus0.master --nodes 85
    """
    places = [place_of(line, options) for line in lines]
    units = [addresses(node, place.nodes) if node else [] for place in places]

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        sent: list[tuple[LiveMaster, Transaction]] = []
        for live, own in zip(masters, units, strict=True):
            named = [each for each in own if each != live.master.nodes.to_all]
            told = live.start_stop(named, is_at_once=at_once)
            sent += [(live, each) for each in told]
        for live, one in sent:
            await live.settled([one])
        return [row_of(live.place.name, one) for live, one in sent]

    return told(on_lines(places, 3, work), names_line=len(lines) > 1)


def scan(
    lines: Lines,
    asked: Asked = TO_ALL,
    tries: Annotated[
        int, typer.Option("--tries", help="How often a silent address is asked.", min=1, max=9)
    ] = 1,
    options: LineOptions = ANY_LINE,
) -> CommandAnswer:
    """Find the nodes of lines: ask each address for something that changes nothing.

    Says how long it took, and how long it was to take: packets, turnarounds, and a time-out for each address
    that is silent.

    Example: hil line scan bus0.master --addresses 80-90
    """
    places = [place_of(line, options) for line in lines]
    wanted = asked_of(places, asked)

    async def one(live: "LiveMaster", of: list[int] | None) -> dict[str, Any]:
        began_ns = live.now_ns()
        there = await live.scan(of, tries)
        count = len(of or live.master.nodes.addresses)
        return {
            "line": live.place.name,
            "nodes": [
                {
                    "node": row.address,
                    "round_trip_ms": round(row.round_trip_ns / 1e6, 3) if row.round_trip_ns else None,
                }
                for row in there
            ],
            "addresses": count,
            "took_s": round((live.now_ns() - began_ns) / 1e9, 3),
            "calculated_s": round(live.master.scan_ns(count, len(there), tries) / 1e9, 3),
        }

    async def work(masters: "Sequence[LiveMaster]") -> list[dict[str, Any]]:
        import asyncio

        pairs = zip(masters, wanted, strict=True)
        return list(await asyncio.gather(*(one(live, of) for live, of in pairs)))

    with bar(f"{', '.join(lines)}: nodes are looked for"):
        rows = on_lines(places, 1, work)
    text_lines = []
    for row in rows:
        for each in row["nodes"]:
            trip_ms = each["round_trip_ms"]
            text_lines.append(
                f"{row['line']} {each['node']}" + (f", {trip_ms:.1f} ms" if trip_ms else ", refuses")
            )
        text_lines.append(
            f"{row['line']}: {len(row['nodes'])} of {row['addresses']} addresses answer;"
            f" {row['took_s']:.2f} s, calculated {row['calculated_s']:.2f} s"
        )
    is_empty = not any(row["nodes"] for row in rows)
    return CommandAnswer(rows, "\n".join(text_lines), Exit.FAILED if is_empty else Exit.DONE)


def _not_sent(line: str, unit: int, command: str) -> dict[str, Any]:
    """A command that a node does not get, for JSON."""
    why = "what came before it is not done"
    return {
        "line": line,
        "node": unit,
        "command": command,
        "outcome": "not sent",
        "why": why,
        "tries": 0,
        "round_trip_ms": None,
    }


def told(rows: list[dict[str, Any]], *, names_line: bool) -> CommandAnswer:
    """Answer of a command by its transactions."""
    return CommandAnswer(
        rows, "\n".join(line_of(each, names_line=names_line) for each in rows), exit_of_rows(rows)
    )
