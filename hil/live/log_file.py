"""The input log of a bench that runs, as a file, whose troubles must not become the boards'."""

import asyncio
import logging
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

from hil import __version__
from hil.compose.simulated_config import as_simulated
from hil.config.port_kinds import port_kinds
from hil.host.packed_text import PackedText
from hil.live.apply.bench_plan import BenchPlan
from hil.live.core_thread import WallClock
from hil.sim.input_log import InputLogWriter
from hil.sim.log_checks import FULL, UNWRITABLE

_log = logging.getLogger("hil")

FLUSH_S = 0.2
BATCH = 256
"""Number of records of the log that are written at once, in some 0.5 ms."""
SILENT_S = 10.0
"""Time after which a log without lines says how far the run has come: the end of a killed one is known so
well."""
TIDY_BYTES = 1_000_000
"""Growth after which older recordings may have to go."""


def wall_text(wall_ns: int) -> str:
    """Format a date for a log: UTC, in microseconds."""
    seconds, rest_ns = divmod(wall_ns, 1_000_000_000)
    at = datetime.fromtimestamp(seconds, UTC).replace(tzinfo=None, microsecond=rest_ns // 1000)
    return at.isoformat(timespec="microseconds") + "Z"


class LogFile:
    """Log file, which has each text within ``FLUSH_S``. It may end before the bench does; then the daemon's
    log says so, once, and ``problem``: what is there up to then can still be replayed.

    ``forked_from``: as ``InputLog`` has it; ``room_bytes``: maximum length; ``tidy``: called with the length
    now and then, to make room beside it, in a thread."""

    def __init__(
        self,
        path: Path,
        file: BinaryIO,
        plan: BenchPlan,
        room_bytes: int | None = None,
        tidy: Callable[[int], object] | None = None,
        forked_from: str = "",
    ) -> None:
        self.path = path
        self.problem = ""
        """Reason why it ended before the bench, for people."""
        self._text = PackedText(file, is_packed=path.suffix == ".gz")
        self._loop = asyncio.get_running_loop()
        self._room_bytes, self._tidy = room_bytes, tidy
        self._tidy_at = TIDY_BYTES
        self._clock: WallClock | None = None
        memories = {name: plan.sections(name, held.content.sections) for name, held in plan.memories.items()}
        config = as_simulated(plan.config)
        program = f"hil {__version__}"
        about: dict[str, object] = {"ports": port_kinds(plan.config)}
        if forked_from:
            about["forked_from"] = forked_from
        writes = self._write_soon, self._times
        self.writer = InputLogWriter(self, program, config, memories, *writes, about)
        """Receiver of the bench's records, which wait until clients have what they were sent."""
        self._marks = [self.writer.checks.mark()]
        """Totals at the last flush, and after each text since then."""
        self._is_over = self._is_writing = False
        self._silent_since_s = self._loop.time()
        self._timer = self._loop.call_later(FLUSH_S, self._flush_again)

    def start(self, clock: WallClock) -> None:
        """Begin to write, as the bench's time begins."""
        self._clock = clock
        self.writer.begin(wall_text(clock.epoch_ns))
        self._flush()

    def write(self, text: str, /) -> None:
        """Write a text of the log; its writer's sink."""
        self._text.write(text)
        self._marks.append(self.writer.checks.mark())

    def write_past(self, epoch_ns: int) -> None:
        """Write what the bench has gone through before its time begins. ``epoch_ns``: wall's time of
        simulated time 0."""
        self.writer.begin(wall_text(epoch_ns))
        self.writer.write_waiting()
        self._flush()

    def end(self, why: str, problem: str = "") -> None:
        """End the log here; nothing more is written to it. ``problem``: reason for people, if the bench
        goes on."""
        if self._is_over:
            return
        self.writer.end(why)
        self.problem = problem
        self._flush()
        self._close()
        if self._clock is None and self._room_bytes is not None:  # there was no run
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()
        if self.problem == problem != "":
            _log.warning("recording %s: %s", self.path, problem)

    def _times(self) -> tuple[int, str]:
        now_ns = self._clock.times_ns()[0] if self._clock else 0
        return now_ns, wall_text(time.time_ns())

    def _write_soon(self, waiting: int) -> None:
        if waiting >= BATCH and not self._is_writing:
            self._is_writing = True
            self._loop.call_soon(self._write_batch)

    def _write_batch(self) -> None:
        self._is_writing = False
        if self._clock and not self._is_over:
            self._write_soon(self.writer.write_waiting(BATCH))

    def _flush_again(self) -> None:
        if self._clock:
            self.writer.write_waiting()
            self._check()
            self._flush()
            self._look_at_room()
        if not self._is_over:
            self._timer = self._loop.call_later(FLUSH_S, self._flush_again)

    def _check(self) -> None:
        checks, now_s = self.writer.checks, self._loop.time()
        if checks.lines != self._marks[0].lines:
            self._silent_since_s = now_s
        if now_s - self._silent_since_s >= SILENT_S:
            self._silent_since_s = now_s
            checks.check()
        else:
            checks.check_if_due()

    def _flush(self) -> None:
        written = self._text.flush()
        del self._marks[:written]
        if self._text.problem:
            self._give_up(self._text.problem)

    def _give_up(self, error: OSError) -> None:
        """End the log after an error, with a last word where the room of what was not written takes it."""
        if self._is_over:
            return
        self.problem = f"{error.strerror or error}; nothing more is written to it"
        _log.error("log %s: %s", self.path, self.problem)
        self.writer.drop()
        self.writer.checks.back_to(self._marks[0])
        self.writer.checks.end(UNWRITABLE)
        self._text.flush()
        self._close()

    def _close(self) -> None:
        self._is_over = True
        self._timer.cancel()
        try:
            self._text.close()
        except OSError as error:
            if not self.problem:
                self.problem = error.strerror or str(error)
                _log.error("log %s: %s", self.path, self.problem)

    def _look_at_room(self) -> None:
        length = self._text.length
        if self._is_over or self._room_bytes is None:
            return
        if length >= self._room_bytes:
            self.end(FULL, f"its room of {self._room_bytes / 1e6:g} MB is used; the bench goes on without it")
        elif self._tidy and length >= self._tidy_at:
            self._tidy_at = length + TIDY_BYTES
            self._loop.run_in_executor(None, self._tidy, length)
