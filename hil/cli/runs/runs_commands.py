"""``hil run list`` and the like: the runs of a bench, one of them, its pace, and its end."""

import json
from typing import Annotated

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions
from hil.cli.framework.command_answers import AsJson, CommandAnswer, pasteable, wants_json
from hil.cli.runs.run_command import run_named
from hil.cli.runs.run_reports import is_under_way, run_line, run_report

RunName = Annotated[str, typer.Argument(help="The run's name, as `hil run` printed it.", show_default=False)]


def runs(context: typer.Context, as_json: AsJson = False, bench: BenchOptions = ANY_BENCH) -> None:
    if context.invoked_subcommand is not None:
        return
    answer = list_runs(bench)
    if as_json or answer.text:
        typer.echo(json.dumps(answer.answer) if as_json else pasteable(answer.text))


def list_runs(bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """List runs: those that wait, move or have ended.

    Example: hil run list
    """
    rows = bench.ask("runs", name="")
    if not rows and not wants_json():
        typer.echo("no run was submitted to this bench", err=True)
    return CommandAnswer(rows, "\n".join(map(run_line, rows)))


def show(name: RunName, bench: BenchOptions = ANY_BENCH) -> CommandAnswer:
    """Show a run: its state, its axes, their following errors.

    Example: hil run show square
    """
    progress = run_named(bench, name)
    return CommandAnswer(progress, run_report(progress))


def cancel(
    name: RunName,
    at_once: Annotated[
        bool, typer.Option("--at-once", help="Stop its axes immediately, not on their ramps.")
    ] = False,
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Cancel a run: a waiting run never begins; the axes of a moving run stop.

    Does not wait until they stand. A run that has ended stays as it is.

    Example: hil run cancel square --at-once
    """
    how = "prejudice" if at_once else "grace"
    progress = bench.ask("cancel_run", name=name, how=how)
    stops = f"{name}: its axes stop; `hil run show {name}` says where"
    return CommandAnswer(progress, stops if is_under_way(progress) else run_line(progress))


def pace(
    name: RunName,
    share: Annotated[
        float,
        typer.Argument(
            help="Share of the planned speed: 0 pauses the run on its path, 1 lets it go on as planned.",
            metavar="PACE",
            show_default=False,
        ),
    ],
    bench: BenchOptions = ANY_BENCH,
) -> CommandAnswer:
    """Slow a run down along its paths, pause it, let it go on.

    The axes stay on their paths. What has times of its own, moves of SACs and levels of pins, goes on to its
    end first. A run that has ended stays as it is.

    Example: hil run pace square 0.5
    """
    progress = bench.ask("pace_run", name=name, pace=share)
    return CommandAnswer(progress, run_line(progress))
