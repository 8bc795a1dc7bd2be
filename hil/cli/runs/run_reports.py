"""Reports on runs in words, and a bar that says how far one is."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from hil.cli.framework.exit_codes import Exit
from hil.cli.framework.shown_words import fixed
from hil.cli.framework.usage_words import with_command

_END_WORDS = {
    None: "at",
    "stands": "stands at",
    "moves": "still moves, at",
    "off": "its loop is off, at",
    "failed": "failed, at",
    "unknown": "unknown, last heard of at",
}
EXIT_OF = {"failed": Exit.RUN_FAILED, "cancelled": Exit.RUN_CANCELLED}
"""Exit codes of runs that have ended in these states; of all others it is done."""


def is_under_way(progress: dict[str, Any]) -> bool:
    return progress["state"] in ("queued", "running")


def run_line(progress: dict[str, Any]) -> str:
    """State of a run in a line, as in ``square-2: running, step 3 of 12, 4 s left``."""
    line = f"{progress['run']}: {progress['state']}"
    if progress["state"] == "running":
        line += f", step {progress['step']} of {progress['steps']}"
    if (pace := progress.get("pace", 1)) != 1 and is_under_way(progress):
        line += f", at {pace:.0%} of its pace" if pace else ", paused"
    if progress.get("left_s") is not None:
        line += f", {progress['left_s']:.0f} s left"
    return line + (f": {with_command(progress['why'])}" if progress["why"] else "")


def run_report(progress: dict[str, Any]) -> str:
    """State of a run, then where its axes are or were left, a line for each."""
    lines = [run_line(progress)]
    for name, axis in progress["axes"].items():
        said = f"  {name}: {_END_WORDS[axis['at_end']]}"
        if axis["position_deg"] is not None:
            said += f" {fixed(axis['position_deg'], 2)} deg"
        elif axis["commanded_deg"] is not None:
            said += f" set-point {fixed(axis['commanded_deg'], 2)} deg (its terminal tells no position)"
        else:
            said += " a place that nobody knows"
        said += f", planned {fixed(axis['target_deg'], 2)}"
        if axis["error_max_deg"] is not None:
            said += (
                f"; following error at most {axis['error_max_deg']:.3f}, rms {axis['error_rms_deg']:.3f} deg"
            )
        lines.append(said)
    for name, bench in progress["benches"].items():
        lines.append(f"  {name}: {bench['state']}; {_began_words(bench)}{clock_words(bench)}")
    return "\n".join(lines)


def _began_words(bench: dict[str, Any]) -> str:
    """Words for how much later than here motion began on another bench."""
    if (apart_ns := bench.get("began_apart_ns")) is None:
        return ""
    return f"it began {abs(apart_ns) / 1e6:.3f} ms {'earlier' if apart_ns < 0 else 'later'}, "


def clock_words(bench: dict[str, Any]) -> str:
    offset_ms, error_ms = bench["clock_offset_ns"] / 1e6, bench["clock_error_ns"] / 1e6
    side = "ahead" if offset_ms >= 0 else "behind"
    return f"its clock is {abs(offset_ms):.3f} ms {side}, give or take {error_ms:.3f}"


@contextmanager
def shown(is_quiet: bool) -> Iterator[Callable[[dict[str, Any]], None]]:
    """Show a run's progress on the standard error, each time that the block calls what it is given: as a bar
    with the time left on a terminal, else in a line for each step."""
    if is_quiet:
        yield lambda progress: None
    elif sys.stderr.isatty():
        with _bar() as show:
            yield show
    else:
        yield _Lines()


class _Lines:
    """Progress in lines: state, then each step."""

    def __init__(self) -> None:
        self._said = ""

    def __call__(self, progress: dict[str, Any]) -> None:
        if not is_under_way(progress):
            return
        step = progress["step"]
        said = f"step {step} of {progress['steps']}" if step else str(progress["state"])
        if said != self._said:
            self._said = said
            typer.echo(f"{progress['run']}: {said}", err=True)


@contextmanager
def _bar() -> Iterator[Callable[[dict[str, Any]], None]]:
    from rich.progress import BarColumn, Progress, TextColumn

    from hil.cli.framework.consoles import ShownConsole

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[left]}"))
    with Progress(*columns, console=ShownConsole(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0, left="")

        def show(progress: dict[str, Any]) -> None:
            left_s = progress.get("left_s")
            where = f"step {progress['step']} of {progress['steps']}"
            waits = progress["state"] == "queued"
            bar.update(
                task,
                description=f"{progress['run']}: {'waits for its axes' if waits else where}",
                completed=done_part(progress),
                left="" if left_s is None else f"{left_s // 60:.0f}:{left_s % 60:02.0f} left",
            )

        yield show


def done_part(progress: dict[str, Any]) -> float:
    """Part of a run's planned time that is over, 0 to 1."""
    started_ns, end_ns, left_ns = (
        progress.get(key) for key in ("started_at_ns", "planned_end_ns", "left_ns")
    )
    if started_ns is None or end_ns is None or left_ns is None or end_ns <= started_ns:
        return 0.0
    return float(min(max(1 - left_ns / (end_ns - started_ns), 0.0), 1.0))
