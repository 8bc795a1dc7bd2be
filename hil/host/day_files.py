"""Lines in files, one for each day of UTC, whose troubles must not become a bench's."""

import asyncio
import logging
import os
import time
from contextlib import suppress
from pathlib import Path

from hil.host.paths import make_folder
from hil.host.regular_file import open_regular

ENDING = ".jsonl"
SOON_S = 0.2
"""Time in which a line is in its file."""
MOST_WAITING = 10_000
"""Maximum number of lines that wait for a disk; more are dropped and counted."""
_END_BYTES = 128 * 1024
"""Bytes at a file's end in which its last line is looked for."""
_TIDY_BYTES = 1_000_000
"""Growth after which older days may have to go."""
_NS = 1_000_000_000

log = logging.getLogger("hil")


def day_files_in(folder: Path) -> list[Path]:
    """Files of days in a folder, the oldest first; none where there is no such folder, or it may not be
    read."""
    try:
        return sorted(path for path in folder.iterdir() if path.name.endswith(ENDING))
    except OSError:
        return []


def last_line(folder: Path) -> str:
    """Last whole line of the latest file; empty: there is none that can be read."""
    for path in reversed(day_files_in(folder)):
        with suppress(OSError), open_regular(path) as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - _END_BYTES))
            *whole, _ = file.read(_END_BYTES).split(b"\n")
            if whole:
                return whole[-1].decode(errors="replace")
    return ""


class DayFiles:
    """Files of the latest ``keep_days`` days with lines, in at most ``keep_bytes`` together: older ones are
    removed. They are written in a thread. Of lines for which there is no room the log says so once;
    ``problem``: why the latest were not written, for people."""

    def __init__(self, folder: Path, keep_days: int, keep_bytes: int) -> None:
        self.folder = folder
        self._keep_days, self._keep_bytes = keep_days, keep_bytes
        self._waiting: list[tuple[str, bytes]] = []
        self._dropped = 0
        self._day = ""
        self._writing: asyncio.Future[None] | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._is_closed = False
        self.problem = ""

    def keep(self, line: str, wall_ns: int) -> None:
        """Write a line soon."""
        if len(self._waiting) >= MOST_WAITING:
            self._dropped += 1
            return
        day = time.strftime("%Y-%m-%d", time.gmtime(wall_ns // _NS))
        self._waiting.append((day, line.encode() + b"\n"))
        if self._timer is None and self._writing is None and not self._is_closed:
            self._timer = asyncio.get_running_loop().call_later(SOON_S, self._begin)

    def _begin(self) -> None:
        self._timer = None
        waiting, self._waiting = self._waiting, []
        loop = asyncio.get_running_loop()
        self._writing = loop.run_in_executor(None, self._write, waiting, self._dropped)
        self._dropped = 0
        self._writing.add_done_callback(self._written)

    def _written(self, _: object) -> None:
        self._writing = None
        if self._waiting and not self._is_closed:
            self._timer = asyncio.get_running_loop().call_later(SOON_S, self._begin)

    async def close(self) -> None:
        """Write what waits."""
        self._is_closed = True
        if self._timer:
            self._timer.cancel()
        if self._writing:
            await self._writing
        if self._waiting:
            self._begin()
            assert self._writing
            await self._writing

    def _write(self, lines: list[tuple[str, bytes]], dropped: int) -> None:
        """Write lines, in a thread. What one error leaves out is lost, the next lines are tried again."""
        problem = f"{dropped} lines were dropped: the disk is too slow" if dropped else ""
        for day in dict.fromkeys(day for day, _ in lines):
            data = b"".join(line for of, line in lines if of == day)
            try:
                self._write_day(self.folder / f"{day}{ENDING}", data, is_new=day != self._day)
                self._day = day
            except OSError as error:
                problem = f"{error.strerror or error}; lines are lost until there is room"
        if problem and not self.problem:
            log.error("%s: %s", self.folder, problem)
        elif self.problem and not problem:
            log.info("%s: lines are written again", self.folder)
        self.problem = problem

    def _write_day(self, path: Path, data: bytes, *, is_new: bool) -> None:
        if is_new:
            make_folder(self.folder)
        flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK
        with open(os.open(path, flags, 0o600), "r+b", buffering=0) as file:
            length = os.fstat(file.fileno()).st_size
            if is_new or length // _TIDY_BYTES != (length + len(data)) // _TIDY_BYTES:
                self._tidy(path, len(data))
            if is_new and length and os.pread(file.fileno(), 1, length - 1) != b"\n":
                data = b"\n" + data  # the last line of a bench that was killed
            if length + len(data) > self._keep_bytes:
                raise OSError(f"{path.name} has all the room of {self._keep_bytes / 1e6:g} MB")
            try:
                left = memoryview(data)
                while left:
                    left = left[os.write(file.fileno(), left) :]
            except OSError:
                with suppress(OSError):
                    os.ftruncate(file.fileno(), length)  # no halves of lines
                raise

    def _tidy(self, present: Path, more: int) -> None:
        """Remove days that are too many, or have no room beside the others."""
        days = {path: path.stat().st_size for path in day_files_in(self.folder)}
        for path in [path for path in days if path != present]:
            if len(days) <= self._keep_days and sum(days.values()) + more <= self._keep_bytes:
                break
            path.unlink()
            del days[path]
