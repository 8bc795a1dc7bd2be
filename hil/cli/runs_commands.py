"""``hil runs``: the runs of a bench, one of them, and the end of one."""

import json
from pathlib import Path
from typing import Annotated

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench
from hil.cli.run_command import run_named
from hil.cli.run_reports import is_under_way, run_line, run_report

runs_app = typer.Typer(
    help="List runs, show one, cancel one.\n\nWithout a command: those that wait, move or have ended.",
    invoke_without_command=True,
)
RunName = Annotated[str, typer.Argument(help="The run's name, as `hil run` said it.", show_default=False)]
AsJson = Annotated[bool, typer.Option("--json", help="JSON for programs.")]


@runs_app.callback()
def runs(
    context: typer.Context, as_json: AsJson = False, bench: Bench = None, runtime_dir: RuntimeDir = None
) -> None:
    if context.invoked_subcommand is not None:
        context.obj = (bench, runtime_dir)
        return
    rows = ask_bench(bench, runtime_dir, "runs", name="")
    if as_json:
        typer.echo(json.dumps(rows))
        return
    for progress in rows:
        typer.echo(run_line(progress))
    if not rows:
        typer.echo("no run was submitted to this bench", err=True)


@runs_app.command()
def show(
    context: typer.Context,
    name: RunName,
    as_json: AsJson = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Show how a run does, or how it went: its state, its axes, their following errors."""
    progress = run_named(*_meant(context, bench, runtime_dir), name)
    typer.echo(json.dumps(progress) if as_json else run_report(progress))


@runs_app.command()
def cancel(
    context: typer.Context,
    name: RunName,
    at_once: Annotated[
        bool, typer.Option("--at-once", help="Stop its axes immediately, not on their ramps.")
    ] = False,
    as_json: AsJson = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Cancel a run: one that waits never begins, the axes of one that moves stop.

    Does not wait until they stand. A run that has ended stays as it is.
    """
    how = "prejudice" if at_once else "grace"
    progress = ask_bench(*_meant(context, bench, runtime_dir), "cancel_run", name=name, how=how)
    if as_json:
        typer.echo(json.dumps(progress))
    elif is_under_way(progress):
        typer.echo(f"{name}: its axes stop; `hil runs show {name}` says where")
    else:
        typer.echo(run_line(progress))


def _meant(
    context: typer.Context, bench: str | None, runtime_dir: Path | None
) -> tuple[str | None, Path | None]:
    """Bench and folder, said before the command's name or after it."""
    before = context.obj or (None, None)
    return bench or before[0], runtime_dir or before[1]
