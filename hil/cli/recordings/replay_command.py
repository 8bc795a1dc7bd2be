"""The command that runs a recorded run again: to compare it, or to look at it."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.recordings.fork_command import ForkOptions, serve_fork
from hil.cli.recordings.opened import OfBench, Trust
from hil.cli.recordings.what_if_view import WhatIfOptions, changes_of, what_if

if TYPE_CHECKING:
    from hil.recorded.bench_then import BenchThen
    from hil.recorded.recorded_run import RecordedRun
    from hil.sim.bench import BenchRuntime

UNCHANGED, NO_FORK = WhatIfOptions(), ForkOptions()
_TIME = "as 12.5s, 1:02:03.5, 900ms, -10s before the end, or fault-1s before the latest fault"


def replay(
    log: Annotated[
        Path,
        typer.Argument(help="A recording: a file or bundle, or its name in `hil recordings`, as last."),
    ],
    until: Annotated[
        str | None,
        typer.Option("--until", help=f"Show the bench as it was at this time, {_TIME}.", metavar="TIME"),
    ] = None,
    since: Annotated[
        str | None,
        typer.Option(
            "--from",
            help="List what came to the boards and what they sent from this time on.",
            metavar="TIME",
        ),
    ] = None,
    to: Annotated[
        str | None,
        typer.Option("--to", help="The end of that list. [default: the run's end]", metavar="TIME"),
    ] = None,
    events: Annotated[
        bool,
        typer.Option("--events", help="List its events, as the page has them."),
    ] = False,
    options: WhatIfOptions = UNCHANGED,
    fork: ForkOptions = NO_FORK,
    trust: Trust = False,
    bench: OfBench = None,
) -> CommandAnswer:
    """Run a log again and compare every byte, or look into it.

    On the virtual clock. Alone it exits with 1 if a byte, a time or a state of an axis differs; a log that
    was cut is compared up to where it ends. Of one that is damaged, what its checks confirm is compared; then
    the command exits with 2. With --until it shows the bench as it was then. With --from and --to it lists
    what happened between. With --events it lists, up to --until or the end, who asked for what, faults,
    runs, refusals, clients, reloads and lateness. With --set, --fault or --no-fault it runs the same inputs
    at a bench with that changed, says where the runs part, and draws both and their difference. With --serve
    it becomes a bench that goes on from there by itself, changed or not; the recording's later inputs are not
    given to it.

    Example: hil replay bench.log

    Example: hil replay bench.log --until -0.1s
    """
    if events:
        if since is not None or to is not None or fork.serve or options.is_given:
            raise fail("hil: --events goes with --until alone", 2)
        return _told_events(log, until)
    if unused := fork.unused:
        raise fail(f"hil: {unused} is for a bench that goes on: give --serve too", 2)
    if fork.serve:
        if since is not None or to is not None:
            raise fail("hil: --serve goes on from --until; leave --from and --to out", 2)
        serve_fork(log, fork, until, partial(changes_of, options))
        raise typer.Exit
    if options.is_given:
        if until is not None:
            raise fail("hil: --until shows a run as it was, --set and --fault change it: leave one out", 2)
        return what_if(log, options, since, to)
    of_changed = {"--at": options.at, "--field": options.fields, "--output": options.output}
    if unused := next((flag for flag, given in of_changed.items() if given), None):
        raise fail(f"hil: {unused} is for a changed run: give --set, --fault or --no-fault too", 2)
    if since is not None or to is not None:
        if until is not None:
            raise fail("hil: --until shows one time, --from and --to list what was between two: give one", 2)
        return _listed(log, since, to)
    return _compared(log) if until is None else _shown(log, until)


def _compared(log: Path) -> CommandAnswer:
    from hil.cli.framework.progress_bars import bar
    from hil.cli.recordings.opened import named, refusals, trusts
    from hil.compose.replay import read_log, replay_log

    log = named(log)
    with refusals(log):
        read = read_log(log, strict=False, trusts=trusts)
        runs: list[BenchRuntime] = []

        def look() -> tuple[float, float] | None:
            return (runs[0].now_ns / 1e9, read.end_ns / 1e9) if runs and read.end_ns else None

        with bar(f"{log.name} runs again", "s simulated", look):
            replayed = replay_log(read, runs.append)
    if difference := replayed.difference():
        raise fail(f"different: {difference}\n`hil diff {log}` says what was before it")
    if damage := replayed.logged.damage:
        raise fail(f"hil: {damage}; before it, identical: {replayed.counts()}", 2)
    values = {"identical": True, "is_cut": bool(replayed.logged.cut), "summary": replayed.summary()}
    return CommandAnswer(values, f"identical: {replayed.summary()}")


def _shown(log: Path, until: str) -> CommandAnswer:
    from hil.cli.recordings.opened import named, opened, run_bar, shown_name, time_of
    from hil.recorded.bench_then import bench_then

    log = named(log)
    with opened(log) as run:
        at_ns = time_of("--until", until, run)
        with run_bar(log, run, at_ns):
            then = bench_then(run, at_ns)
        return CommandAnswer(then.values() | {"end_ns": run.end_ns}, _then_text(shown_name(log), run, then))


def _listed(log: Path, since: str | None, to: str | None) -> CommandAnswer:
    from hil.cli.recordings.opened import opened, run_bar, time_of
    from hil.recorded.run_events import events
    from hil.recorded.time_words import time_text
    from hil.vocab.time import SimTimeNs

    with opened(log) as run:
        from_ns = SimTimeNs(0) if since is None else time_of("--from", since, run)
        to_ns = run.end_ns if to is None else time_of("--to", to, run)
        if to_ns < from_ns:
            raise fail(
                f"hil: --to {time_text(to_ns)} is before --from {time_text(from_ns)}; exchange them", 2
            )
        with run_bar(log, run, to_ns):
            found = [*events(run, from_ns, to_ns)]
    lines = [event.line() for event in found]
    nothing = f"nothing happened from {time_text(from_ns)} to {time_text(to_ns)}"
    return CommandAnswer([event._asdict() for event in found], "\n".join(lines) or nothing)


def _told_events(log: Path, until: str | None) -> CommandAnswer:
    from hil.cli.recordings.opened import opened, time_of
    from hil.recorded.time_words import time_text
    from hil.sim.noted_events import latest_events
    from hil.vocab.shown_text import printable

    with opened(log) as run:
        until_ns = run.end_ns if until is None else time_of("--until", until, run)
        found = [each for each in latest_events(run.log.events) if each.at_ns <= until_ns]
    lines = [
        f"{time_text(each.at_ns):17}  {each.kind:9}  {each.of:12}  {each.text}"
        + (f" x{each.count}" if each.count > 1 else "")
        + (f" ({each.who})" if each.who else "")
        for each in found
    ]
    nothing = "nobody asked for anything, and nothing went wrong; recordings of tests have no events"
    return CommandAnswer([each.as_dict() for each in found], "\n".join(map(printable, lines)) or nothing)


def _then_text(log: str, run: "RecordedRun", then: "BenchThen") -> str:
    from hil.cli.bench.views import field_lines
    from hil.recorded.run_events import bytes_words, fault_words
    from hil.recorded.time_words import time_text

    wholes = f"{log} at {time_text(then.at_ns)} of {time_text(run.end_ns)}"
    parts = [wholes, *(each for each in (run.log.damage, run.log.cut) if each)]
    parts += [
        f"{name} is a real board at {at}: a replay does not have it" for name, at in then.absent.items()
    ]
    parts += [f"{name} had stopped: {why}" for name, why in then.failed.items()]
    for axis, fields in then.axes.items():
        told = {name: value if abs(value) < float("inf") else None for name, value in fields.items()}
        parts.append("\n".join([f"\n{axis}", *(f"  {line}".rstrip() for line in field_lines(told))]))
    words = [f"  {place:12}  {bytes_words(data)}" for place, data in then.words.items()]
    faults = [
        f"  {row['target']:12}  " + fault_words(row["kind"], row["parameters"], f"{row['number']} ")
        for row in then.faults
    ]
    parts.append("\n".join(["\nlast bytes sent", *(words or ["  none"])]))
    parts.append("\n".join(["\nfaults", *(faults or ["  none"])]))
    return "\n".join(parts)
