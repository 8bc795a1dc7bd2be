"""List of recordings, for `hil recordings`: each with how it ended, without going through it."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hil.compose.log_summary import LogSummary, summarise
from hil.compose.recordings_folder import HUNG, run_name
from hil.recorded.recording_names import bench_of
from hil.sim.log_checks import FULL, STOPPED, UNWRITABLE

RUNNING, KILLED, HUNG_END, UNREADABLE = "running", "killed", "hung", "unreadable"
END_WORDS = {
    RUNNING: "it goes on",
    STOPPED: "the bench was stopped",
    KILLED: "the daemon was killed, or ended by itself",
    HUNG_END: "a firmware hung, and the watchdog ended the daemon",
    FULL: "its room (`recordings.keep_MB`) was used, and the bench went on",
    UNWRITABLE: "the disk was full or failed, and the bench went on",
    UNREADABLE: "its beginning is damaged",
}
"""Ends of recordings, with their meaning."""


@dataclass(frozen=True)
class ListedRecording:
    """Recording in a list. ``end``: one of ``END_WORDS``; ``hung``: the device whose firmware hung."""

    summary: LogSummary
    end: str
    hung: str = ""

    @property
    def bench(self) -> str:
        return self.summary.bench or bench_of(self.summary.path)

    @property
    def begun(self) -> datetime | None:
        """Date of time 0, by its header or by its name."""
        if self.summary.begun:
            return self.summary.begun
        with suppress(ValueError):
            return datetime.strptime(run_name(self.summary.path)[:20], "%Y-%m-%dT%H-%M-%SZ").replace(
                tzinfo=UTC
            )
        return None

    def as_dict(self) -> dict[str, Any]:
        """Recording for JSON."""
        summary = self.summary
        return {
            "name": f"{bench_of(summary.path)}/{run_name(summary.path)}",
            "bench": self.bench,
            "begun": self.begun.isoformat() if self.begun else None,
            "length_ns": summary.end_ns,
            "speed": summary.speed,
            "end": self.end,
            "hung": self.hung or None,
            "faults": None if summary.faults is None else dict(summary.faults),
            "inputs": summary.inputs,
            "bytes": summary.size,
            "path": str(summary.path),
            "problem": summary.problem or None,
        }


def listed_recordings(paths: Iterable[Path]) -> list[ListedRecording]:
    """List recordings; one that is removed meanwhile is left out."""
    found = []
    for path in paths:
        try:
            summary = summarise(path)
        except OSError as error:
            if not path.exists():
                continue
            summary = LogSummary(path, 0, written=False, problem=error.strerror or str(error))
        found.append(_listed(summary))
    return found


def _listed(summary: LogSummary) -> ListedRecording:
    if summary.problem:
        return ListedRecording(summary, UNREADABLE)
    if summary.written:
        return ListedRecording(summary, RUNNING)
    if summary.why:
        return ListedRecording(summary, summary.why)
    with suppress(OSError, UnicodeDecodeError):
        hung = summary.path.with_name(run_name(summary.path) + HUNG).read_text()
        return ListedRecording(summary, HUNG_END, hung)
    return ListedRecording(summary, KILLED)
