"""The file of ``hil serve --log``, whose troubles must not become the boards'."""

import asyncio
import logging
from collections.abc import Callable
from io import TextIOWrapper
from pathlib import Path

from hil import __version__
from hil.compose.simulated_config import as_simulated
from hil.host.new_file import begin_file
from hil.live.apply.bench_plan import BenchPlan
from hil.live.refusals import StartError
from hil.sim.input_log import InputLogWriter

_log = logging.getLogger("hil")

FLUSH_S = 0.2
BATCH = 256
"""Number of records of the log that are written at once, in some 0.5 ms."""


class LogFile:
    """Log file, which has each text within ``FLUSH_S``. After an error nothing more is written, and the
    daemon's log says so, once: what is there up to then can still be replayed."""

    def __init__(self, path: Path, loop: asyncio.AbstractEventLoop) -> None:
        """Make the file. Raises StartError: it cannot be made."""
        self._path = path
        try:
            self._file = TextIOWrapper(begin_file(path), encoding="utf-8")
        except OSError as error:
            raise StartError(f"log {path}: {error.strerror}") from error
        self._ended = False
        self._loop = loop
        self._log: InputLogWriter | None = None
        self._is_writing = False
        self._timer = loop.call_later(FLUSH_S, self._flush_again)

    def begin(self, plan: BenchPlan) -> InputLogWriter:
        """Begin the log of a bench. Its records wait until clients have what they were sent."""
        memories = {name: plan.sections(name, held.content.sections) for name, held in plan.memories.items()}
        config = as_simulated(plan.config)
        self._log = InputLogWriter(self, f"hil {__version__}", config, memories, self._write_soon)
        return self._log

    def _write_soon(self, waiting: int) -> None:
        if waiting >= BATCH and not self._is_writing:
            self._is_writing = True
            self._loop.call_soon(self._write_batch)

    def _write_batch(self) -> None:
        self._is_writing = False
        if self._log and not self._timer.cancelled():
            self._write_soon(self._log.write_waiting(BATCH))

    def write(self, text: str) -> None:
        if not self._ended:
            self._try(self._file.write, text)

    def flush(self) -> None:
        if not self._ended:
            self._try(self._file.flush)

    def _flush_again(self) -> None:
        if self._log:
            self._log.write_waiting()
        self.flush()
        self._timer = self._loop.call_later(FLUSH_S, self._flush_again)

    def close(self) -> None:
        self._timer.cancel()
        self.flush()
        self._try(self._file.close)  # writes what was left in its buffer

    def _try(self, call: Callable[..., object], *arguments: str) -> None:
        try:
            call(*arguments)
        except OSError as error:
            if not self._ended:
                self._ended = True
                _log.error("log %s: %s; nothing more is written to it", self._path, error.strerror)
