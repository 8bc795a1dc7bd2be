"""Recording of a bench's run: in its state directory, in a file that the operator names, or none."""

import logging
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil.compose.log_summary import summarise
from hil.compose.recordings_folder import (
    BYTES_OF_MB,
    HUNG,
    RECORDINGS,
    RecordingsFolder,
    recordings_in,
    run_name,
)
from hil.host.new_file import begin_file
from hil.live.apply.bench_plan import BenchPlan
from hil.live.guard import BREADCRUMB
from hil.live.log_file import LogFile
from hil.live.refusals import StartError
from hil.sim.input_log import InputLogWriter
from hil.sim.log_checks import STOPPED
from hil.sim.reloads import Reloaded

_log = logging.getLogger("hil")


@dataclass
class RunRecording:
    """Recording of the run. ``file``: None, nothing is recorded; ``problem``: reason why, where it was
    wanted; ``before``: recording of the run before, which did not end in order, with how it ended;
    ``forked_from``: recording that the bench goes on from, and when; empty: none."""

    file: LogFile | None = None
    problem: str = ""
    before: tuple[Path, str] | None = None
    forked_from: str = ""

    @property
    def writer(self) -> InputLogWriter | None:
        """Receiver of the bench's records."""
        return self.file.writer if self.file else None

    def reload(self, reload: Reloaded) -> None:
        """Write down that the bench is reloaded."""
        if self.writer:
            self.writer.add(reload)

    def report(self) -> dict[str, Any]:
        """Report for `hil status`."""
        problem = self.file.problem if self.file else self.problem
        path, how = self.before or (None, None)
        return {
            "forked_from": self.forked_from or None,
            "path": str(self.file.path.absolute()) if self.file else None,
            "problem": problem or None,
            "before": {"path": str(path), "end": how, "show": replay_words(path)} if path else None,
        }


def begin_recording(
    stack: AsyncExitStack,
    plan: BenchPlan,
    state: Path,
    log: Path | None,
    *,
    is_wanted: bool,
    forked_from: str = "",
) -> RunRecording:
    """Begin the recording of a bench, which ``stack`` ends: in ``log``, or in the bench's state directory if
    ``is_wanted``.

    Raises:
        StartError: ``log`` cannot be made.
    """
    before = _before(state)
    if before:
        path, how = before
        _log.warning("the run before %s; to see its end: %s", how, replay_words(path))
    keep = plan.config.recordings
    if log is None and not (is_wanted and keep.keep_runs):
        return RunRecording(before=before, forked_from=forked_from)
    if log:
        try:
            file = LogFile(log, begin_file(log), plan, forked_from=forked_from)
        except OSError as error:
            raise StartError(f"log {log}: {error.strerror}") from error
    else:
        room_bytes = keep.keep_MB * BYTES_OF_MB
        folder = RecordingsFolder(state / RECORDINGS, keep.keep_runs, room_bytes)
        try:
            file = LogFile(*folder.begin(), plan, room_bytes, folder.tidy, forked_from)
        except OSError as error:
            problem = f"{folder.path}: {error.strerror or error}"
            _log.error("this run is not recorded: %s", problem)
            return RunRecording(problem=problem, before=before, forked_from=forked_from)
    stack.callback(file.end, STOPPED)
    return RunRecording(file, before=before, forked_from=forked_from)


def replay_words(path: Path) -> str:
    """Command that opens the end of a recording."""
    return f"hil replay {path} --until -5s --serve"


def _before(state: Path) -> tuple[Path, str] | None:
    """Recording of the run before, if that did not end in order, and how it ended."""
    found = recordings_in(state / RECORDINGS)
    if not found:
        return None
    with suppress(OSError):
        last = summarise(found[-1])
        if last.why or last.written:
            return None
        hung = ""
        with suppress(OSError, UnicodeDecodeError):
            hung = (state / BREADCRUMB).read_text()
            found[-1].with_name(run_name(found[-1]) + HUNG).write_text(hung)
        return found[-1], f"ended in the firmware of {hung}, which hung" if hung else "was killed"
    return None
