"""``hil run``: a multi-axis run from a file."""

import json
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.framework.ask import ANY_BENCH, BenchOptions, fail
from hil.cli.framework.command_answers import AsJson
from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.interrupts import noted
from hil.cli.framework.paused_note import told_if_paused
from hil.cli.framework.shown_words import counted
from hil.cli.runs.run_reports import EXIT_OF, is_under_way, run_report, shown
from hil.vocab.problem import not_text

RUN_LOOK_S = 0.1
SUBMIT_S = 60.0
"""Maximum wait for a submission: reading a run of a megabyte takes some ten seconds."""


def run(
    file: Annotated[Path, typer.Argument(help="The run (YAML or JSON).", show_default=False)],
    check: Annotated[bool, typer.Option("--check", help="Check the run, and do not carry it out.")] = False,
    name: Annotated[
        str,
        typer.Option(
            "--name",
            metavar="NAME",
            help="Carry it out at most once under this name; if it was carried out before, print its result.",
            show_default=False,
        ),
    ] = "",
    detach: Annotated[bool, typer.Option("--detach", help="Do not wait for its end.")] = False,
    as_json: AsJson = False,
    bench: BenchOptions = ANY_BENCH,
) -> None:
    """Carry out a multi-axis run.

    Each time, under a name that is not taken: square, square-2, square-3. Its problems are listed before
    anything moves. Ctrl-C and SIGTERM stop its axes on their ramps. Exits with 3 if it fails, with 4 if
    somebody else cancels it.

    Example: hil run square.yaml
    """
    from hil.runs.run_document import DOCUMENT_BYTES

    try:
        text = file.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise fail(str(not_text(str(file), error)), Exit.MISTAKE) from None
    except OSError as error:
        raise fail(f"hil: {file}: {error.strerror}", Exit.MISTAKE) from None
    if len(text) > DOCUMENT_BYTES:
        raise fail(f"hil: {file}: {len(text)} characters; a run has at most {DOCUMENT_BYTES}", Exit.MISTAKE)
    request = {"text": text, "file": str(file), "check": check, "name": name, "fresh": not name}
    if check:
        answer = _submitted(bench, request)
        typer.echo(f"{file}: run {answer['run']}, {counted(answer['steps'], 'step')}, no problems")
        return
    interrupted = False
    with noted() as interrupts:  # from here on: the bench may have the run before its answer is here
        progress = _submitted(bench, request)
        name = progress["run"]
        if progress["submissions"] > 1:
            is_old = "is under way already" if is_under_way(progress) else "was carried out before"
            typer.echo(f"{name}: it {is_old}; this is how it does", err=True)
        with told_if_paused(bench.meant().socket), shown(is_quiet=as_json or detach) as show:
            while not detach and is_under_way(progress):
                show(progress)
                if interrupts:
                    interrupts.clear()
                    interrupted = True
                    bench.ask("cancel_run", name=name, how="grace")
                else:
                    time.sleep(RUN_LOOK_S)
                progress = run_named(bench, name)
    typer.echo(json.dumps(progress) if as_json else run_report(progress))
    code = EXIT_OF.get(progress["state"], Exit.DONE)
    if code:
        raise typer.Exit(Exit.INTERRUPTED if interrupted and code == Exit.RUN_CANCELLED else code)


def _submitted(bench: BenchOptions, request: dict[str, Any]) -> dict[str, Any]:
    """Submit a run; its problems end the command."""
    answer: dict[str, Any] = bench.ask("run", timeout_s=SUBMIT_S, **request)
    if "problems" in answer:
        raise fail(answer["problems"], Exit.MISTAKE)
    if not request["check"] and "state" not in answer:
        raise fail("hil: the bench does not say how the run does; is it another version of hil?")
    return answer


def run_named(bench: BenchOptions, name: str) -> dict[str, Any]:
    """Progress of one run."""
    rows: list[dict[str, Any]] = bench.ask("runs", name=name)
    if not rows:
        raise fail(f"hil: the bench knows no run {name!r} any more")
    return rows[0]
