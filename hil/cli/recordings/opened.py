"""Recordings that commands open, and what is said of those that cannot be."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import wants_json

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from hil.cli.framework.progress_bars import ShownProgress
    from hil.recorded.recorded_run import RecordedRun
    from hil.telemetry.sampler import Interval
    from hil.vocab.time import SimTimeNs


def named(log: Path, state_dir: Path | None = None) -> Path:
    """Path of a recording that is given by its path or by its name. Raises Exit with 2: there is none."""
    import os

    from hil.host.journal import say
    from hil.host.paths import state_bases
    from hil.recorded.recording_names import NoSuchRecording, found_recording

    text = f"{_bench[0]}/{log}" if _bench[0] and not log.exists() and len(log.parts) == 1 else str(log)
    try:
        found = found_recording(text, state_bases(state_dir, os.environ))
    except NoSuchRecording as error:
        raise fail(f"hil: {error}", 2) from None
    if found != log and sys.stderr.isatty() and not wants_json():
        say(f"hil: {log} is {shown_name(found)}", sys.stderr)
    return found


def shown_name(path: Path) -> str:
    """Name of a recording as `hil recordings` lists it, or its path elsewhere."""
    from hil.compose.recordings_folder import RECORDINGS, run_name
    from hil.recorded.recording_names import bench_of

    return f"{bench_of(path)}/{run_name(path)}" if path.parent.name == RECORDINGS else str(path)


def _note_bench(bench: str | None) -> str | None:
    _bench[:] = [bench]
    return bench


OfBench = Annotated[
    str | None,
    typer.Option(
        "--bench",
        "-b",
        help="The bench that the recording is of, where it is given by its name, as last.",
        metavar="BENCH",
        callback=_note_bench,
    ),
]
"""Option of commands that open recordings; ``named`` knows what it was."""
_bench: list[str | None] = [None]


def _note_trust(trust: bool) -> bool:
    _trusted[:] = [trust]
    return trust


Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        help="Let code of boards run that came in the bundle, without asking.",
        callback=_note_trust,
    ),
]
"""Option of commands that open recordings; ``trusts`` knows what it was."""
_trusted = [False]


def trusts(boards: Sequence[str]) -> bool:
    """Say whether code of a bundle's boards may run here: by --trust, or by asking at a terminal."""
    if _trusted[0] or wants_json() or not (sys.stdin.isatty() and sys.stderr.isatty()):
        return _trusted[0]
    said = (
        f"The bundle has boards of its own: {', '.join(boards)}. Their code would run here, with your rights."
    )
    return typer.confirm(f"{said} Do you trust who made it?", err=True)


@contextmanager
def refusals(log: Path) -> Iterator[None]:
    """Say what is wrong with a recording that the block goes through. Raises Exit with 2: it cannot be."""
    from hil.compose.lanes import LanesRefused
    from hil.config import ConfigError
    from hil.sim.inputs import InputLogError

    try:
        yield
    except (InputLogError, LanesRefused) as error:
        raise fail(f"hil: {error}", 2) from None
    except ConfigError as error:
        raise fail(f"hil: {log}:1: the configuration of this log is refused:\n{error}", 2) from None
    except OSError as error:
        raise fail(f"hil: {log}: {error.strerror or error}", 2) from None


@contextmanager
def opened(log: Path) -> Iterator["RecordedRun"]:
    """Open the run of a recording, given by its path or name, for the block. Raises Exit as ``refusals``."""
    from hil.recorded.recorded_run import open_recorded

    log = named(log)
    with refusals(log), closing(open_recorded(log, trusts)) as run:
        yield run


def time_of(option: str, text: str, run: "RecordedRun") -> "SimTimeNs":
    """Time of the run that an option gives. Raises Exit with 2: it is none of it."""
    from hil.recorded.time_words import NoSuchTime, parse_time

    try:
        return parse_time(text, run.end_ns, _faults_ns(run))
    except NoSuchTime as error:
        raise fail(f"hil: {option}: {error}", 2) from None


def _faults_ns(run: "RecordedRun") -> dict[int, int]:
    """Times at which faults of a run began, by their numbers; one in its configuration at 0, or later."""
    from hil.sim.inputs import Inject

    begun_ns = {number: int(at_ns) for number, at_ns in run.runtime.faults.begin_ns.items()}
    for at_ns, _, given in run.log.inputs:
        if isinstance(given, Inject):
            later_s = float(dict(given.parameters).get("start_s", 0.0))
            begun_ns[given.number] = at_ns + round(later_s * 1e9)
    return begun_ns


def run_bar(log: Path, run: "RecordedRun", to_ns: int) -> "AbstractContextManager[ShownProgress]":
    """Show how far a run has been gone through, on its way to a time."""
    from hil.cli.framework.progress_bars import bar

    return bar(f"{log.name} runs again", "s simulated", lambda: (run.now_ns / 1e9, to_ns / 1e9))


def control_step(run: "RecordedRun") -> "Interval":
    """Control step of the run's axes. Raises Exit with 2: they have none, or several."""
    steps = {device.axes[name].kind.control_step_ns for device, name in run.runtime.parts.axes.values()} - {0}
    if len(steps) != 1:
        why = "no axis here has control steps of one length" if not steps else "control steps differ here"
        raise fail(f"hil: --every step: {why}; write a time, as --every 100us", 2)
    return steps.pop()
