"""``hil run``: a multi-axis run from a file."""

import json
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from hil.cli.ask import Bench, RuntimeDir, ask_bench, fail
from hil.cli.interrupts import noted

POLL_S = 0.1
BAD_DOCUMENT = 2
SUBMIT_S = 60.0
"""Maximum wait for a submission: reading a run of a megabyte takes some ten seconds."""
_END_WORDS = {
    None: "at",
    "stands": "stands at",
    "moves": "still moves, at",
    "off": "its loop is off, at",
    "failed": "failed, at",
    "unknown": "unknown, last heard of at",
}


def run(
    file: Annotated[Path, typer.Argument(help="The run (YAML or JSON).", show_default=False)],
    check: Annotated[
        bool, typer.Option("--check", help="Say whether it can be done, and stop there.")
    ] = False,
    detach: Annotated[bool, typer.Option("--detach", help="Do not wait for its end.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="JSON for programs.")] = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """Carry out a multi-axis run.

    Its problems are listed before anything moves. Ctrl-C and SIGTERM end it with grace. Exits with 1 if it
    fails. A run that has ended is carried out again.

    Example: hil run square.yaml
    """
    from hil.runs.run_document import DOCUMENT_BYTES

    try:
        text = file.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise fail(f"hil: {file}: {error}", BAD_DOCUMENT) from None
    if len(text) > DOCUMENT_BYTES:
        raise fail(f"{file}: {len(text)} characters; a run has at most {DOCUMENT_BYTES}", BAD_DOCUMENT)
    request = {"text": text, "file": str(file), "check": check}
    if check:
        answer = _submitted(bench, runtime_dir, request)
        typer.echo(f"{file}: run {answer['run']}, {answer['steps']} step(s), no problems")
        return
    with noted() as interrupts:  # from here on: the bench may have the run before its answer is here
        progress = _submitted(bench, runtime_dir, request)
        if progress["submissions"] > 1:
            typer.echo(f"{progress['run']}: it is under way already; this is how that run does", err=True)
        name = progress["run"]
        step = -1
        while not detach and progress["state"] in ("queued", "running"):
            if progress["step"] != step and not as_json:
                step = progress["step"]
                said = f"step {step} of {progress['steps']}" if step else progress["state"]
                typer.echo(f"{name}: {said}", err=True)
            if interrupts:
                interrupts.clear()
                ask_bench(bench, runtime_dir, "cancel_run", name=name, how="grace")
            else:
                time.sleep(POLL_S)
            progress = ask_bench(bench, runtime_dir, "runs", name=name)[0]
    typer.echo(json.dumps(progress) if as_json else _report(progress))
    if progress["state"] in ("failed", "cancelled"):
        raise typer.Exit(1)


def _submitted(bench: str | None, runtime_dir: Path | None, request: dict[str, Any]) -> dict[str, Any]:
    """Submit a run; its problems end the command."""
    answer: dict[str, Any] = ask_bench(bench, runtime_dir, "run", timeout_s=SUBMIT_S, **request)
    if problems := answer.get("problems"):
        raise fail(problems, BAD_DOCUMENT)
    if not request["check"] and "state" not in answer:
        raise fail("hil: the bench does not say how the run does; is it another version of hil?")
    return answer


def benches(
    as_json: Annotated[bool, typer.Option("--json", help="JSON for programs.")] = False,
    bench: Bench = None,
    runtime_dir: RuntimeDir = None,
) -> None:
    """List the benches that are joined to this one, and how their clocks stand to its own.

    Example: hil benches
    """
    rows = ask_bench(bench, runtime_dir, "benches")
    if as_json:
        typer.echo(json.dumps(rows))
        return
    for row in rows:
        typer.echo(f"{row['bench']}: {row['why'] or 'hil ' + row['version'] + ', ' + clock_words(row)}")
    if not rows:
        typer.echo("no other bench is joined to this one", err=True)


def _report(progress: dict[str, Any]) -> str:
    why = f": {progress['why']}" if progress["why"] else ""
    lines = [f"{progress['run']}: {progress['state']}{why}"]
    for name, axis in progress["axes"].items():
        said = f"  {name}: {_END_WORDS[axis['at_end']]}"
        if axis["position_deg"] is not None:
            said += f" {axis['position_deg']:.2f} deg"
        elif axis["commanded_deg"] is not None:
            said += f" set-point {axis['commanded_deg']:.2f} deg (its terminal tells no position)"
        else:
            said += " a place that nobody knows"
        said += f", planned {axis['target_deg']:.2f}"
        if axis["error_max_deg"] is not None:
            said += (
                f"; following error at most {axis['error_max_deg']:.3f}, rms {axis['error_rms_deg']:.3f} deg"
            )
        lines.append(said)
    for name, bench in progress["benches"].items():
        lines.append(f"  {name}: {bench['state']}; {clock_words(bench)}")
    return "\n".join(lines)


def clock_words(bench: dict[str, Any]) -> str:
    offset_ms, error_ms = bench["clock_offset_ns"] / 1e6, bench["clock_error_ns"] / 1e6
    side = "ahead" if offset_ms >= 0 else "behind"
    return f"its clock is {abs(offset_ms):.3f} ms {side}, give or take {error_ms:.3f}"
