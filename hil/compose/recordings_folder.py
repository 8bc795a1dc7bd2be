"""Folder of a bench's recordings: ``recordings`` in its state directory, one file for each run."""

import fcntl
import os
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import BinaryIO

from hil.host.paths import make_folder
from hil.host.regular_file import open_regular

RECORDINGS = "recordings"
ENDING = ".hil.gz"
HUNG = ".hung"
"""Ending of the file beside a recording whose run ended in a firmware that hung; it has the device's name."""
BYTES_OF_MB = 1_000_000


def run_name(path: Path) -> str:
    """Name of a recording: that of its file without its ending."""
    return path.name.removesuffix(ENDING)


def recordings_in(folder: Path) -> list[Path]:
    """Recordings in a folder, by the dates in their names, the oldest first; none where there is no such
    folder, or it may not be read."""
    try:
        found = [path for path in folder.iterdir() if path.name.endswith(ENDING)]
    except OSError:
        return []
    return sorted(found, key=_order)


def _order(path: Path) -> tuple[str, int, str]:
    date, _, number = run_name(path).partition("_")
    return date, int(number) if number.isdecimal() else 1, number


def is_written(file: BinaryIO) -> bool:
    """True if another program has the file open to write: each locks its recording."""
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # a file system without locks
        return False
    fcntl.flock(file.fileno(), fcntl.LOCK_UN)
    return False


@dataclass(frozen=True)
class RecordingsFolder:
    """Recordings of one bench: how many runs are kept, and in how many bytes together."""

    path: Path
    keep_runs: int
    keep_bytes: int

    def begin(self) -> tuple[Path, BinaryIO]:
        """Begin a recording, locked as long as it is open, and remove those that are too many.

        Raises:
            OSError: the folder or the file cannot be made.
        """
        make_folder(self.path)
        self.tidy(0)
        date = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%SZ")
        for number in count(1):  # of one second, or of a clock that was set back
            path = self.path / f"{date}{f'_{number}' if number > 1 else ''}{ENDING}"
            with suppress(FileExistsError):
                flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
                file = open(os.open(path, flags, 0o600), "wb", buffering=0)  # noqa: SIM115 - the caller's
                with suppress(OSError):
                    fcntl.flock(file.fileno(), fcntl.LOCK_EX)
                return path, file
        raise AssertionError

    def tidy(self, own_bytes: int) -> None:
        """Remove the oldest recordings that are too many beside the one that grows, or have no room there;
        none that a program writes. What cannot be removed stays."""
        left_bytes, left_runs = self.keep_bytes - own_bytes, self.keep_runs - 1
        for path in reversed(recordings_in(self.path)):
            with suppress(OSError), open_regular(path) as file:
                if is_written(file):
                    continue
                left_runs -= 1
                left_bytes -= os.fstat(file.fileno()).st_size
                if left_runs < 0 or left_bytes < 0:
                    path.unlink()
                    path.with_name(run_name(path) + HUNG).unlink(missing_ok=True)
