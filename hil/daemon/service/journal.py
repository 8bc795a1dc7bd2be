"""The daemon's log: for a terminal or a file with the level's name, for the journal with its number.

The journal takes ``<3>`` at a line's beginning for its priority (sd-daemon(3)) and has the time and the unit
itself. ``$JOURNAL_STREAM`` has the device and inode of the stream it gave the process.
"""

import logging
import os
from collections.abc import Mapping
from typing import TextIO

_PRIORITIES = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (logging.INFO, 6))
_DEBUG = 7


def is_journal(stream: TextIO, env: Mapping[str, str]) -> bool:
    """Whether what is written to this stream goes to the journal."""
    try:
        stat = os.fstat(stream.fileno())
    except (OSError, ValueError):  # no file, or closed
        return False
    return env.get("JOURNAL_STREAM") == f"{stat.st_dev}:{stat.st_ino}"


def prefixed(text: str, level: int) -> str:
    """Each line with the priority of a level of ``logging``."""
    priority = next((number for least, number in _PRIORITIES if level >= least), _DEBUG)
    return "\n".join(f"<{priority}>{line}" for line in text.split("\n"))


class JournalFormatter(logging.Formatter):
    """Messages with priorities, in each of their lines."""

    def format(self, record: logging.LogRecord) -> str:
        return prefixed(super().format(record), record.levelno)


def start_log(stream: TextIO, env: Mapping[str, str]) -> None:
    """Write the log to this stream from now on."""
    handler = logging.StreamHandler(stream)
    handler.setFormatter(
        JournalFormatter() if is_journal(stream, env) else logging.Formatter("%(levelname)s %(message)s")
    )
    logging.basicConfig(level=logging.INFO, handlers=[handler])
