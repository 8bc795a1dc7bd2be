"""A program that a test runs at a bench in real time, in a process of its own."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hil.host.python_program import find_program, is_python
from hil.testing.program_beside import NO_WORDS, USUAL_LIMIT_MS, ProgramRunsOn
from hil.testing.program_output import ProgramOutput

END_S = 5.0
"""Maximum time for a program to end in after SIGTERM."""
MS_PER_S = 1000


class ServedProgram:
    """Program beside a bench in real time, made by ``ServedBench.program``.

    Its words that are names of ``ports``, or of ``mapped``, are given to it as the paths of those ports: a
    path that stands in the program itself cannot be mapped here. ``speed``: of the bench; ``options``: of
    ``subprocess.Popen``.
    """

    def __init__(
        self,
        ports: Mapping[str, str],
        words: Sequence[str | os.PathLike[str]],
        mapped: Mapping[str, str],
        speed: float,
        options: Mapping[str, Any],
    ) -> None:
        self._speed = speed
        paths = {**ports, **{name: ports[port] for name, port in mapped.items()}}
        command = [paths.get(word, word) for word in _command([os.fspath(word) for word in words])]
        self._output = ProgramOutput()
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=self._output.out, stderr=self._output.err, **options
        )

    @property
    def returncode(self) -> int | None:
        """Its exit code once it has ended."""
        return self._process.poll()

    @property
    def is_running(self) -> bool:
        """True until it has ended."""
        return self.returncode is None

    @property
    def stdout(self) -> str:
        """Its output so far."""
        return self._output.stdout

    @property
    def stderr(self) -> str:
        """Its error output so far."""
        return self._output.stderr

    def sections(self) -> Iterator[tuple[str, str]]:
        """Title and text for the report of a test that fails: what it has said."""
        state = "runs" if self.is_running else f"ended with {self.returncode}"
        yield f"program ({state})", "\n".join(filter(None, (self.stdout.rstrip(), self.stderr.rstrip())))

    def wait(self, timeout_ms: float = USUAL_LIMIT_MS) -> int:
        """Wait for its end, for at most so much simulated time; answers its exit code.

        Raises:
            ProgramRunsOn: it has not ended in this time.
        """
        __tracebackhide__ = True
        end_s = time.monotonic() + timeout_ms / MS_PER_S / self._speed
        try:
            return self._process.wait(max(end_s - time.monotonic(), 0))
        except subprocess.TimeoutExpired:
            raise ProgramRunsOn(f"the program has not ended within {timeout_ms:g} ms") from None

    def close(self) -> None:
        """End it, if it runs. What it has said stays."""
        if self.is_running:
            self._process.terminate()
            try:
                self._process.wait(END_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._output.close()


def _command(words: list[str]) -> list[str]:
    """Command line: a Python program is run by this Python, another one as it is."""
    if not words:
        raise ValueError(NO_WORDS)
    if words[0] == "-m":
        return [sys.executable, *words]
    if is_python(words[0]):
        return [sys.executable, *words[1:]]
    path = find_program(words[0])
    return [sys.executable, path, *words[1:]] if path.endswith(".py") else [path, *words[1:]]
