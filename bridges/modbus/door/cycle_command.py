"""``hil modbus cycle``: how long a cycle of polls takes on a serial line."""

import json
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import typer

BAUDS = (300, 4_000_000)


def cycle(
    polls: Annotated[
        list[str],
        typer.Argument(
            metavar="UNIT:FUNCTION[:COUNT]...",
            help="Polls, as in 1:4:10; 1-32:4:10 is one of each unit. Unit 0 is a broadcast.",
            show_default=False,
        ),
    ],
    baud: Annotated[int, typer.Option(help="Speed of the line.", min=BAUDS[0], max=BAUDS[1])] = 19200,
    form: Annotated[str, typer.Option("--format", help="8N1, 8E1, 8O1 or 8N2.")] = "8E1",
    response_ms: Annotated[
        float, typer.Option(help="Time from the end of a request (t3.5) to its answer.", min=0, max=60_000)
    ] = 1.0,
    turnaround_ms: Annotated[
        float, typer.Option(help="Wait of the master after a broadcast.", min=0, max=60_000)
    ] = 100.0,
    pause_ms: Annotated[
        float, typer.Option(help="Pause of the master between polls, in addition to t3.5.", min=0, max=60_000)
    ] = 0.0,
    as_json: Annotated[bool, typer.Option("--json", help="JSON for programs; times in ns.")] = False,
) -> None:
    """Compute the time of a poll cycle on a serial line, without a bench.

    A segment with Modbus nodes takes the same time to the nanosecond.

    Example: hil modbus cycle 1:3:10 2:3:10
    """
    from bridges.modbus.protocol.poll_cycle import PollCycle
    from hil.vocab.line_format import FORMATS
    from hil.vocab.time import ms

    if form not in FORMATS:
        typer.echo(f"hil: --format {form}: formats are {', '.join(FORMATS)}", err=True)
        raise typer.Exit(2)
    try:
        wanted = [poll for text in polls for poll in _polls(text)]
    except ValueError as error:
        typer.echo(f"hil: {error}", err=True)
        raise typer.Exit(2) from None
    times_ns = ms(response_ms), ms(turnaround_ms), ms(pause_ms)
    poll_cycle = PollCycle(baud, FORMATS[form], wanted, *times_ns)
    if as_json:
        typer.echo(json.dumps(_as_dict(poll_cycle), indent=1))
        return
    for line in _lines(poll_cycle):
        typer.echo(line)


def _polls(text: str) -> Iterator[Any]:
    """Polls that a word of the command line means. Raises ValueError: it means none."""
    from bridges.modbus.protocol.poll_cycle import Poll

    units, *numbers = text.split(":")
    first, dash, last = units.partition("-")
    digits = [first, *([last] if dash else []), *numbers]
    if not 1 <= len(numbers) <= 2 or not all(each.isascii() and each.isdigit() for each in digits):
        raise ValueError(f"{text}: write UNIT:FUNCTION or UNIT:FUNCTION:COUNT, as in 1:4:10 or 1-32:4:10")
    if dash and int(first) > int(last):
        raise ValueError(f"{text}: {first} comes after {last}")
    for unit in range(int(first), min(int(last), 999) + 1) if dash else [int(first)]:
        poll = Poll(unit, *map(int, numbers))
        if problem := poll.problem:
            raise ValueError(f"{text}: {problem}")
        yield poll


def _as_dict(cycle: Any) -> dict[str, Any]:
    rows = [
        {**each.poll._asdict(), "request_bytes": each.poll.request_bytes}
        | {"answer_bytes": each.poll.answer_bytes}
        | {name: value for name, value in each._asdict().items() if name != "poll"}
        for each in cycle.times()
    ]
    head = {"baud": cycle.baud, "format": cycle.line_format.name, "t1_5_ns": cycle.gap_ns}
    return {**head, "t3_5_ns": cycle.silence_ns, "polls": rows, **cycle.summary()}


def _lines(cycle: Any) -> Iterator[str]:
    said = cycle.summary()
    yield (
        f"{cycle.baud} baud {cycle.line_format.name}: t1.5 {_ms(cycle.gap_ns)} ms,"
        f" t3.5 {_ms(cycle.silence_ns)} ms"
    )
    rows: list[Sequence[str]] = [
        ("unit", "function", "count", "start ms", "request ms", "wait ms", "answer ms", "silence ms")
    ]
    for each in cycle.times():
        times_ns = (each.start_ns, each.request_ns, each.wait_ns, each.answer_ns, each.silence_ns)
        rows.append((*map(str, each.poll), *map(_ms, times_ns)))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
    yield (
        f"cycle {_ms(said['cycle_ns'])} ms, {said['polls_per_s']:.1f} polls/s,"
        f" {said['cycles_per_s']:.2f} cycles/s, load {said['load']:.1%}"
    )


def _ms(value_ns: float) -> str:
    return f"{value_ns / 1e6:.3f}"
