"""Output of a program that a test runs, in files without names."""

import os
import tempfile
from typing import Any


class ProgramOutput:
    """Output and error output of a program, which it writes to ``out`` and ``err``."""

    def __init__(self) -> None:
        self.out, self.err = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115 - until close
        self._said: tuple[str, str] | None = None

    @property
    def stdout(self) -> str:
        """Its output so far."""
        return self._said[0] if self._said else _text(self.out)

    @property
    def stderr(self) -> str:
        """Its error output so far."""
        return self._said[1] if self._said else _text(self.err)

    def close(self) -> None:
        """Keep the texts, and close the files."""
        self._said = self.stdout, self.stderr
        self.out.close()
        self.err.close()


def _text(file: Any) -> str:
    """Text in a file that another process writes."""
    data: bytes = os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0)
    return data.decode(errors="replace")
