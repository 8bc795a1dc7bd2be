"""Writes the daemon's log and what it says at the start from a thread of its own: a reader that does not
read, as a paused pager, must not stop the bench."""

import logging
import os
import queue
import select
import threading
import time
from contextlib import suppress

from hil.vocab.shown_text import printable_lines

MOST = 4096
"""Maximum number of messages that wait for the reader; more are dropped and counted."""
END_S = 1.0
"""Time for writing what still waits when the bench ends."""


class LogWriter(logging.Handler):
    """Writer of messages to ``log_fd``, in the order in which they come; None: nowhere. Errors are no reason
    to end a bench: what cannot be written is dropped. Not through Python's streams, whose locks a thread that
    waits would keep at the exit."""

    def __init__(self, log_fd: int | None) -> None:
        super().__init__()
        self._log_fd = log_fd
        self._queue: queue.Queue[tuple[int, str] | None] = queue.Queue(MOST)
        self._dropped = 0
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._is_closed = False
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        if self._log_fd is None:
            return
        try:
            text = self.format(record)
        except Exception:  # a message whose arguments do not fit it
            self.handleError(record)
            return
        if self._dropped and not self._queue.full():
            self._tell_dropped()
        if not self.write(self._log_fd, text + "\n"):
            self._dropped += 1

    def _tell_dropped(self) -> None:
        what = f"{self._dropped} messages were dropped here, because nobody read the log"
        record = logging.makeLogRecord({"msg": what, "levelno": logging.WARNING, "levelname": "WARNING"})
        if self._log_fd is not None and self.write(self._log_fd, self.format(record) + "\n"):
            self._dropped = 0

    def write(self, fd: int, text: str) -> bool:
        """Write a text to a file when its turn comes; answers whether there was room for it."""
        if self._is_closed:
            if not self._thread.is_alive():  # all before it are written
                _write(fd, printable_lines(text))
            return True
        try:
            self._queue.put_nowait((fd, printable_lines(text)))
        except queue.Full:
            return False
        return True

    def _run(self) -> None:
        while item := self._queue.get():
            _write(*item)

    def close(self) -> None:
        """Write what waits, for at most ``END_S``, whether or not anybody reads. Safe to call twice."""
        if not self._is_closed:
            deadline_s = time.monotonic() + END_S
            if self._dropped:
                self._tell_dropped()
            with suppress(queue.Full):
                self._queue.put(None, timeout=END_S)
            self._thread.join(max(deadline_s - time.monotonic(), 0))
            self._is_closed = True
        super().close()


def _write(fd: int, text: str) -> None:
    data = text.encode(errors="backslashreplace")
    try:
        while data:
            try:
                data = data[os.write(fd, data) :]
            except BlockingIOError:  # another program with this file made it non-blocking
                select.select([], [fd], [])
    except OSError:
        pass  # full, or the reader has gone
