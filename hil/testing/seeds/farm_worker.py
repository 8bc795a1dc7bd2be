"""Seeds at a worker of a farm: pytest in a process of its own, whose reports come back line by line.

This module is imported at workers, with the version of hil that is there.
"""

import json
import platform
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from distributed import Event, WorkerPlugin

from hil import __version__
from hil.testing.seeds.sent_sources import folder_of, unpacked

LOOK_S = 0.5
"""Time between two looks at whether the run has ended early."""
_LAST_LINES = 30


def versions() -> dict[str, str]:
    """Versions that have to be the same at a worker as where pytest was started."""
    import pytest

    python = ".".join(platform.python_version_tuple()[:2])
    return {"hil": __version__, "Python": python, "pytest": pytest.__version__}


class SentProject(WorkerPlugin):
    """Project that each worker unpacks, also one that comes later. As an input of the tasks it would keep
    them where it is: one worker had all the work."""

    idempotent = True

    def __init__(self, packed: bytes) -> None:
        self._packed = packed

    def setup(self, worker: object) -> None:
        """Unpack it here."""
        unpacked(self._packed)


def carry_out(mark: str, arguments: Sequence[str], pieces: Sequence[str], stop_name: str) -> list[Any]:
    """Run some pieces of a run; answers their reports: a task. ``mark``: of the project; ``arguments``: of
    pytest; ``stop_name``: of the event that ends the run early."""
    stop = Event(stop_name)
    folder = folder_of(mark)
    left, told = list(pieces), list[Any]()
    while left and not stop.is_set():
        ran = _run(folder, arguments, left, stop.is_set)
        told += [each for each in ran.reports if each["nodeid"] != ran.died_in]
        if not ran.problem:
            break
        # A process that died in a test is followed by one for those behind it.
        died = [ran.died_in] if ran.died_in else left
        told += [{"crashed": ran.problem, "nodeid": piece} for piece in died]
        done = {each["nodeid"] for each in told}
        left = [piece for piece in left if piece not in done]
    return told


class _Ran(NamedTuple):
    """Reports of one process. ``problem``: how it died, if it did; ``died_in``: the piece, if one ran."""

    reports: list[Any]
    problem: str = ""
    died_in: str = ""


def _run(folder: Path, arguments: Sequence[str], pieces: Sequence[str], is_over: Callable[[], bool]) -> _Ran:
    command = [sys.executable, "-m", "hil.testing.seeds.farm_process"]
    lines, said = list[Any](), deque[str](maxlen=_LAST_LINES)
    with subprocess.Popen(
        command, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin
        readers = [
            threading.Thread(target=lambda: lines.extend(map(json.loads, process.stdout or ())), daemon=True),
            threading.Thread(target=lambda: said.extend(process.stderr or ()), daemon=True),
        ]
        for reader in readers:
            reader.start()
        try:
            # If this worker is killed, the pipe ends, and the process with it.
            process.stdin.write(json.dumps([[*arguments], [*pieces]]) + "\n")
            process.stdin.flush()
            while process.poll() is None:
                try:
                    process.wait(LOOK_S)
                except subprocess.TimeoutExpired:
                    if is_over():
                        process.kill()
        except BaseException:
            process.kill()
            raise
        for reader in readers:
            reader.join()
    reports = [each for each in lines if "nodeid" in each]
    if (lines and lines[-1] == {"end": True}) or is_over():
        return _Ran(reports)
    began = [each["began"] for each in lines if "began" in each]
    ended = [each["ended"] for each in lines if "ended" in each]
    died_in = began[-1] if began[len(ended) :] else ""
    text = "".join(said).strip() or "it said nothing"
    return _Ran(reports, f"the process that ran it ended with {process.returncode}:\n{text}", died_in)
