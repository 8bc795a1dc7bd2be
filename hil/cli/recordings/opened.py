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

    from hil.host.paths import state_bases
    from hil.recorded.recording_names import NoSuchRecording, found_recording

    try:
        return found_recording(str(log), state_bases(state_dir, os.environ))
    except NoSuchRecording as error:
        raise fail(f"hil: {error}", 2) from None


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
        return parse_time(text, run.end_ns)
    except NoSuchTime as error:
        raise fail(f"hil: {option}: {error}", 2) from None


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
