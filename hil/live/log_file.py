"""The file of ``hil serve --log``, whose troubles must not become the boards'."""

import logging
from io import TextIOWrapper
from pathlib import Path

from hil.host.new_file import begin_file

_log = logging.getLogger("hil")


class LogFile:
    """Text to a file. After an error nothing more is written, and the daemon's log says so, once: what
    is there up to then can still be replayed."""

    def __init__(self, path: Path) -> None:
        """Raises OSError: the file cannot be made."""
        self._path = path
        self._file = TextIOWrapper(begin_file(path), encoding="utf-8")
        self._ended = False

    def write(self, text: str) -> None:
        if not self._ended:
            try:
                self._file.write(text)
            except OSError as error:
                self._end(error)

    def flush(self) -> None:
        if not self._ended:
            try:
                self._file.flush()
            except OSError as error:
                self._end(error)

    def close(self) -> None:
        self.flush()
        try:
            self._file.close()
        except OSError as error:  # what was left in its buffer
            if not self._ended:
                self._end(error)

    def _end(self, error: OSError) -> None:
        self._ended = True
        _log.error("log %s: %s; nothing more is written to it", self._path, error.strerror)
