"""Input log of a file that is perhaps still being written, read as far as it is there."""

from pathlib import Path

from hil.compose.log_lines import LogLines
from hil.sim.input_log import InputLog
from hil.sim.inputs import InputLogError
from hil.sim.log_reading import LogReading
from hil.vocab.time import SimTimeNs


class GrowingLog:
    """Log of a file so far. A copy of the process reads on by itself.

    Raises:
        InputLogError: the file is no input log, or of another program.
        OSError: it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._lines = LogLines(path)
        self._more = LogReading(str(path))
        self._damage = ""
        self.log: InputLog = self._read()
        """Log as read so far; its lists grow, and lose what damage in them leaves out."""

    def fileno(self) -> int:
        return self._lines.fileno()

    @property
    def problem(self) -> str:
        """Reason why nothing comes behind the last time, though the run went on; empty: there is none."""
        return self.log.damage or (self.log.cut if self.log.why else "")

    @property
    def is_growing(self) -> bool:
        """True if more may come."""
        return not (self.log.why or self._damage)

    @property
    def last_ns(self) -> SimTimeNs:
        """Time up to which the log describes the run."""
        return SimTimeNs(self.log.end_ns)

    def read_on(self) -> int:
        """Read what was written since; answers how many inputs there were before, or are still there."""
        before = len(self.log.inputs)
        if self.is_growing:
            self.log = self._read()
        return min(before, len(self.log.inputs))

    def _read(self) -> InputLog:
        try:
            for line in self._lines.more():
                self._more.add(line)
        except InputLogError as error:
            self._damage = str(error)
        return self._more.log(self._damage)
