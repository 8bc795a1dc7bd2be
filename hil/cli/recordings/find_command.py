"""The command that searches a recorded run."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_words import counted, shown_number
from hil.cli.recordings.opened import OfBench, Trust, control_step, opened, run_bar, time_of
from hil.host.journal import say

if TYPE_CHECKING:
    from hil.recorded.search import FoundTime
    from hil.telemetry.sampler import Interval

_LONGEST = 60
"""Maximum characters of a text that are shown."""
_TIME = "as 12.5s, 1:02:03.5, 900ms, -10s before the end, or fault-1s before the latest fault"


def find(
    log: Annotated[
        Path, typer.Argument(help="A recording: a file or bundle, or its name in `hil recordings`, as last.")
    ],
    condition: Annotated[
        str,
        typer.Argument(
            help="Comparisons of fields, as m1.e, of counters of wires, as bus0.collisions, and of texts, as"
            ' m1.sent has "...". `and`, `or`, `not`, parentheses, + - * /, abs(), min(), max().',
            show_default=False,
        ),
    ],
    since: Annotated[
        str | None, typer.Option("--from", help=f"Where to begin, {_TIME}. [default: 0s]", metavar="TIME")
    ] = None,
    to: Annotated[
        str | None, typer.Option("--to", help="Where to end. [default: the run's end]", metavar="TIME")
    ] = None,
    every: Annotated[
        str,
        typer.Option(
            "--every",
            help="Simulated time between two looks at fields; step: each control step.",
            metavar="TIME",
        ),
    ] = "1ms",
    first: Annotated[bool, typer.Option("--first", help="The first time alone.")] = False,
    last: Annotated[bool, typer.Option("--last", help="The last time alone.")] = False,
    count: Annotated[bool, typer.Option("--count", help="The number of times alone.")] = False,
    trust: Trust = False,
    bench: OfBench = None,
) -> CommandAnswer:
    """List the times at which a condition begins to hold in a recorded run.

    Each with how long it holds, and what it compares. Of a board: sent, received, fault, verb and input are
    texts of moments, as in m1.sent has "Error" or m1.fault == "encoder_noise"; == compares a whole line. Of a
    wire: text, data, error, kind, from, to and can_id of a packet or frame, as `hil decode --json` has them.
    Exits with 1 if it never holds.

    Example: hil find bench.log 'abs(m1.e) >= 5'
    """
    from hil.net.condition import ConditionError, parse_condition
    from hil.recorded.search import search
    from hil.recorded.time_words import NoSuchTime, parse_length, time_text

    if sum((first, last, count)) > 1:
        raise fail("hil: choose one of --first, --last and --count", Exit.MISTAKE)
    try:
        wanted = parse_condition(condition, "m1.position_deg > 89")
        interval: Interval | None = None if every == "step" else parse_length(every)
    except NoSuchTime as error:
        raise fail(f"hil: --every: {error}", Exit.MISTAKE) from None
    except ConditionError as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None
    with opened(log) as run:
        from_ns = time_of("--from", since or "0s", run)
        to_ns = time_of("--to", to, run) if to else run.end_ns
        if from_ns > to_ns:
            text = f"hil: --from {time_text(from_ns)} is behind --to {time_text(to_ns)}; exchange them"
            raise fail(text, Exit.MISTAKE)
        kept: list[FoundTime] = []
        interval_ns = control_step(run) if interval is None else interval
        number = 0
        try:
            with run_bar(log, run, to_ns):
                for each in search(run, wanted, from_ns, to_ns, interval_ns):
                    number += 1
                    if last:
                        kept.clear()
                    if not count:
                        kept.append(each)
                    if first:
                        break
        except ConditionError as error:
            raise fail(f"hil: {error}", Exit.MISTAKE) from None
        except ValueError as error:
            raise fail(f"hil: --every {every}: {error}", Exit.MISTAKE) from None
        cut = run.log.cut
    window = f"between {time_text(from_ns)} and {time_text(to_ns)}"
    answer = {
        "condition": condition,
        "from_ns": from_ns,
        "to_ns": to_ns,
        "count": number,
        "is_cut": bool(cut),
        "times": [_values(each) for each in kept],
    }
    lines = [_line(each) for each in kept]
    if count:
        lines = [str(number)]
    elif not number:
        lines = [f"{condition} does not hold {window}"]
    elif not first and not last:
        lines.append(f"{counted(number, 'time')} {window}")
    if cut:
        say(f"hil: {log}: {cut}", sys.stderr)
    return CommandAnswer(answer, "\n".join(lines), Exit.DONE if number else Exit.FAILED)


def _values(found: "FoundTime") -> dict[str, Any]:
    held_s = None if found.ends_ns is None else (found.ends_ns - found.begins_ns) / 1e9
    return {"at_ns": found.begins_ns, "at_s": found.begins_ns / 1e9, "held_s": held_s, "values": found.values}


def _line(found: "FoundTime") -> str:
    from hil.recorded.time_words import time_text

    held = "to the end"
    if found.ends_ns is not None:
        length_ns = found.ends_ns - found.begins_ns
        held = f"for {time_text(length_ns)}" if length_ns else ""
    values = ", ".join(f"{name} is {_shown(value)}" for name, value in found.values.items())
    return f"{time_text(found.begins_ns):14} {held:14} {values}".rstrip()


def _shown(value: float | str) -> str:
    if isinstance(value, str):
        return repr(value if len(value) <= _LONGEST else f"{value[:_LONGEST]}...")
    return shown_number(value)
