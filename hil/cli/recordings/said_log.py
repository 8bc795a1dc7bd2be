"""``hil log``: what a bench and its boards said, from the recording of its run."""

import json
import sys
import time
from contextlib import closing, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import AsJson
from hil.host.journal import say

if TYPE_CHECKING:
    from hil.recorded.said_lines import SaidLine, SaidLines
    from hil.recorded.said_reading import SaidReading, SaidWish

LINES = 50
_LOOK_S = 0.2
"""Time between two looks at a recording that grows: a line is in it 0.2 s after it was said."""
_NEXT_RUN_S = 1.0


def log(
    device: Annotated[
        str | None,
        typer.Argument(
            help="Only what is of this device, segment or bus, and all that it printed. [default: all]",
            show_default=False,
        ),
    ] = None,
    follow: Annotated[
        bool, typer.Option("--follow", "-f", help="Go on with what is said, and with the bench's next run.")
    ] = False,
    lines: Annotated[
        int, typer.Option("--lines", "-n", help="The last so many; 0: all.", min=0, max=10_000_000)
    ] = LINES,
    since: Annotated[
        str | None,
        typer.Option(
            "--since",
            help="Only what was said in the last 90s, 30min, 2h of simulated time, or since"
            " 2026-11-29T14:30 (UTC).",
            metavar="TIME",
        ),
    ] = None,
    level: Annotated[
        str, typer.Option("--level", help="At least: info, warning, error.", metavar="LEVEL")
    ] = "info",
    recording: Annotated[
        str | None,
        typer.Option(
            "--recording",
            help="Of this recording: a file, or its name in `hil recordings`, as last-1. [default: of the"
            " bench that runs; if none runs, of the latest run]",
            show_default=False,
        ),
    ] = None,
    state_dir: Annotated[
        Path | None,
        typer.Option("--state-dir", help="Folder of benches' state. [default: yours and that of services]"),
    ] = None,
    bench: BenchOptions = ANY_BENCH,
    as_json: AsJson = False,
) -> None:
    """Show what a bench and its boards said, in the order of simulated time.

    Warnings and faults, runs, refusals, clients, reloads; lines of text that boards printed, also where
    nobody read them. With a device its bytes that are no text, too. `hil log commands` says who commanded
    what.

    Example: hil log m1 --level warning
    """
    from hil.recorded.said_lines import LEVELS
    from hil.recorded.said_reading import SaidReading, SaidWish
    from hil.sim.inputs import InputLogError

    if level not in LEVELS:
        raise fail(f"hil: --level: there is no level {level!r}; write {', '.join(LEVELS)}", 2)
    path = _recording(recording, state_dir, bench)
    wish = SaidWish(device, level, lines)
    if path is None:
        _tell_kept(bench, wish, as_json)
        return
    try:
        with closing(SaidReading(path)) as reading:
            shown = reading.latest(wish, goes_on=follow)
            _check_name(device, reading.said, shown)
            since_ns = _since_ns(since, reading.said) if since else 0
            for each in shown:
                if each.at_ns >= since_ns:
                    _tell(each, as_json)
            then = _followed(reading, wish, as_json, is_alone=recording is not None) if follow else None
        while then:
            say(f"hil: the bench began again: {then.name}", sys.stderr)
            with closing(SaidReading(then)) as reading:
                then = _followed(reading, wish, as_json, is_alone=False)
    except BrokenPipeError:
        raise
    except InputLogError as error:
        raise fail(f"hil: {error}", 2) from None
    except OSError as error:
        raise fail(f"hil: {path}: {error.strerror or error}") from None


def _recording(named: str | None, state_dir: Path | None, bench: BenchOptions) -> Path | None:
    """Recording that is meant; None: a bench runs, and has none. Raises Exit: there is none."""
    import os

    from hil.cli.recordings.opened import named as path_of
    from hil.compose.recordings_folder import run_name
    from hil.host.paths import state_bases
    from hil.net.benches_here import find
    from hil.recorded.recording_names import bench_of, recordings_of

    if named:
        return path_of(Path(named), state_dir)
    here = find(bench.runtime_dir, os.environ).running()
    meant = here.meant(bench.bench)
    if meant:
        status = bench.ask("status")
        path = (status.get("recording") or {}).get("path")
        return Path(path) if path else None
    bases = state_bases(state_dir, os.environ)
    there = recordings_of(bases, bench.bench)
    if not there:
        of = f" of {bench.bench}" if bench.bench else ""
        where = " and ".join(map(str, bases))
        raise fail(f"hil: no bench is running here, and there is no recording{of} in {where}")
    say(f"hil: {bench_of(there[-1])} does not run; its run {run_name(there[-1])} said:", sys.stderr)
    return there[-1]


def _tell_kept(bench: BenchOptions, wish: "SaidWish", as_json: bool) -> None:
    """Print the events that a bench without a recording keeps."""
    from hil.recorded.said_lines import line_of
    from hil.sim.noted_events import noted_event

    say(
        "hil: this run is not recorded: only the latest events are there, and not what boards said",
        sys.stderr,
    )
    lines = [line_of(noted_event(each)) for each in bench.ask("events")["events"]]
    wanted = [each for each in lines if wish.wants(each)]
    for each in wanted[-wish.most :] if wish.most else wanted:
        _tell(each, as_json)


def _check_name(device: str | None, said: "SaidLines", kept: "list[SaidLine]") -> None:
    """Raise Exit with 2 if the run has no such device or wire."""
    from hil.vocab.address import owner_of
    from hil.vocab.near_words import meant

    if device is None or kept or owner_of(device) in said.names:
        return
    raise fail(f"hil: there is no {device!r} in this run; {meant(device, sorted(said.names))}", 2)


def _since_ns(text: str, said: "SaidLines") -> int:
    """Simulated time that --since means. Raises Exit with 2: it is none."""
    from hil.recorded.time_words import NoSuchTime, parse_length

    with suppress(NoSuchTime):
        return max(said.end_ns - parse_length(text), 0)
    try:
        at = datetime.fromisoformat(text)
        begun = datetime.fromisoformat(str(said.header.get("begun", "")))
    except ValueError:
        raise fail(
            f"hil: --since {text[:80]!r} is no time; write 90s, 30min, 2h, or 2026-11-29T14:30", 2
        ) from None
    passed = (at if at.tzinfo else at.replace(tzinfo=UTC)) - begun
    speed = said.header.get("speed")
    return round(passed / timedelta(microseconds=1) * 1000 * (speed if isinstance(speed, float) else 1.0))


def _tell(line: "SaidLine", as_json: bool) -> None:
    from hil.cli.framework.shown_view import Line, ShownView
    from hil.vocab.shown_text import printable

    if as_json:
        typer.echo(json.dumps(line.as_dict()))
        return
    style = {"warning": "yellow", "error": "red"}.get(line.level, "")
    word = f"{line.level}: " if line.level != "info" else ""
    head = f"{line.at_ns / 1e9:12.6f}  {line.source:10}  "
    ShownView(Line([(head, "dim"), (f"{word}{printable(line.text)}", style)])).print()


def _followed(reading: "SaidReading", wish: "SaidWish", as_json: bool, *, is_alone: bool) -> Path | None:
    """Print what is said from now on, until Ctrl-C or the bench's next run, whose recording it answers.
    ``is_alone``: until the end of this run."""
    looked_s = time.monotonic()
    with suppress(KeyboardInterrupt):
        while True:
            for each in [*reading.more(), *reading.said.silent(reading.said.end_ns)]:
                if wish.wants(each):
                    _tell(each, as_json)
            sys.stdout.flush()
            if reading.said.end and is_alone:
                say(f"hil: the run has ended: {reading.said.end}", sys.stderr)
                return None
            time.sleep(_LOOK_S)
            if not is_alone and time.monotonic() - looked_s >= _NEXT_RUN_S:
                looked_s = time.monotonic()
                if then := _next_run(reading.path):
                    return then
    return None


def _next_run(path: Path) -> Path | None:
    """Later recording of the same bench; None: there is none."""
    from hil.compose.recordings_folder import recordings_in

    there = recordings_in(path.parent)
    return there[-1] if there and there[-1] != path and path in there else None
