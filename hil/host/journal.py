"""Log of the daemon: for a terminal or a file with the level's name, for the journal with its number.

The journal takes ``<3>`` at a line's beginning for its priority (sd-daemon(3)) and has the time and the unit
itself. ``$JOURNAL_STREAM`` has the device and inode of the stream it gave the process.
"""

import logging
import os
import sys
from collections.abc import Mapping
from typing import TextIO

from hil.host.log_writer import LogWriter

STDIN, STDOUT, STDERR = range(3)

_PRIORITIES = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (logging.INFO, 6))
_DEBUG = 7


def is_journal(stream: TextIO, env: Mapping[str, str]) -> bool:
    """True if what is written to this stream goes to the journal."""
    try:
        stat = os.fstat(stream.fileno())
    except (OSError, ValueError):  # no file, or closed
        return False
    return env.get("JOURNAL_STREAM") == f"{stat.st_dev}:{stat.st_ino}"


def prefixed(text: str, level: int) -> str:
    """Prefix each line with the priority of a level of ``logging``."""
    priority = next((number for least, number in _PRIORITIES if level >= least), _DEBUG)
    return "\n".join(f"<{priority}>{line}" for line in text.split("\n"))


class JournalFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return prefixed(super().format(record), record.levelno)


def start_log(stream: TextIO, env: Mapping[str, str]) -> LogWriter:
    """Write the log to this stream from now on. The writer is to be closed at the end."""
    try:
        fd = stream.fileno()
    except (OSError, ValueError):  # no file, or closed
        fd = None
    writer = LogWriter(fd)
    writer.setFormatter(
        JournalFormatter() if is_journal(stream, env) else logging.Formatter("%(levelname)s %(message)s")
    )
    logging.basicConfig(level=logging.INFO, handlers=[writer])
    return writer


def give_streams() -> None:
    """Open standard streams that were closed on /dev/null: nothing else gets their numbers, and writes to
    them do not fail."""
    if None not in (sys.stdin, sys.stdout, sys.stderr):
        return
    while (fd := os.open(os.devnull, os.O_RDWR)) <= STDERR:
        os.set_inheritable(fd, True)
    os.close(fd)
    sys.stdin = sys.stdin or open(STDIN, closefd=False)  # noqa: SIM115 - for good
    sys.stdout = sys.stdout or open(STDOUT, "w", closefd=False)  # noqa: SIM115 - for good
    sys.stderr = sys.stderr or open(STDERR, "w", closefd=False)  # noqa: SIM115 - for good


def say(text: str, stream: TextIO) -> None:
    """Write a line. A stream that takes none, full or without a reader, is /dev/null from then on, so that
    what is left in its buffer does no harm at the exit."""
    try:
        print(text, file=stream, flush=True)
    except OSError:
        null = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        os.dup2(null, stream.fileno())
        os.close(null)
