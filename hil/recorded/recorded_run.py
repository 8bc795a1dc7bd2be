"""A run that was recorded, which goes on the virtual clock to any time of it."""

from collections.abc import Callable
from pathlib import Path

from hil.compose.bundles import Trusts, trusts_nobody
from hil.compose.log_course import Heard, LogCourse
from hil.compose.replay import read_log
from hil.config import BenchConfig, Catalogue
from hil.sim.bench import BenchRuntime
from hil.sim.input_log import InputLog
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused


class RecordedRun:
    """Run of an input log, at time 0, with the bench it was of. ``on_problem``,
    ``on_refused``: as ``LogCourse`` has them.

    Raises:
        InputLogError, ConfigError: as ``LogCourse``.
    """

    def __init__(
        self,
        log: InputLog,
        on_problem: Callable[[int, str], None] | None = None,
        on_refused: Callable[[int, VerbRefused], None] = lambda index, refusal: None,
    ) -> None:
        self.refused: list[tuple[int, VerbRefused]] = []
        """Numbers of the inputs that boards have refused so far, as they did then, and why."""

        def refused(index: int, refusal: VerbRefused) -> None:
            self.refused.append((index, refusal))
            on_refused(index, refusal)

        self._course = LogCourse(log, on_problem, refused)
        self.log = log
        self.runtime: BenchRuntime = self._course.runtime
        self.catalogue: Catalogue = self._course.catalogue
        self.listeners: list[Heard] = self._course.listeners
        """Listeners to what devices send: the device, name of its UART or card, when, and the bytes."""
        self.taken_slots: dict[str, set[int]] = {}
        """Slots of the core in which axes are watched, by address."""

    @property
    def config(self) -> BenchConfig:
        """Configuration of the bench as it is now: a reload may have changed it."""
        return self._course.config

    def next_reload_ns(self) -> SimTimeNs:
        """Time of the next reload; ``FOREVER``: there is none."""
        return self._course.next_reload_ns()

    @property
    def now_ns(self) -> SimTimeNs:
        """Time to which the run has gone."""
        return self.runtime.now_ns

    @property
    def end_ns(self) -> SimTimeNs:
        """Latest time in the log."""
        return self._course.end_ns

    def run_until(self, until_ns: SimTimeNs) -> None:
        """Go on to a time: inputs up to and at it take effect. Never back; past the end the bench goes on by
        itself."""
        self._course.run_until(until_ns)

    def extend(self, first: int) -> None:
        """Take inputs that came to the log since, from this number on: ``LogCourse.extend``."""
        self._course.extend(first)

    def close(self) -> None:
        """Free the bench's memory now instead of with its last reference."""
        self.runtime.stop()


def open_recorded(path: Path, trusts: Trusts = trusts_nobody) -> RecordedRun:
    """Open the run of a recording, a log or a bundle; of one that was cut or damaged, what is whole
    (``log.cut`` says the rest). ``trusts``: as ``read_log`` has it.

    Raises:
        InputLogError: it is none, or of another program; says where.
        ConfigError: its configuration does not fit this program.
        OSError: it cannot be read, or is no regular file.
    """
    return RecordedRun(read_log(path, strict=False, trusts=trusts))
