"""A program that a test runs on the simulated time of its bench, in a process of its own."""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from hil.host.python_program import find_python_program, is_python
from hil.sim.inputs import Logged
from hil.testing.given import GivenConfig, as_json, path_of
from hil.testing.input_lines import as_lines
from hil.testing.kept_inputs import KeptInputs
from hil.testing.program_output import ProgramOutput
from hil.vocab.time import NS_PER_MS, SimTimeNs

USUAL_LIMIT_MS = 600_000
NO_WORDS = "a program is a list of words: the file of a Python program, and what it is given"
END_S = 10.0
"""Maximum wall time for a process to end in, after its program has."""


class ProgramRunsOn(Exception):
    """Error of a program that has not ended in time: ``str(error)`` says what it waits for."""


class ProgramBeside:
    """Program on a bench in memory, made by ``Bench.program``, which goes on as far as the test lets time
    pass. ``given`` to ``now_ns``: of the bench; ``run_until``: lets time pass there, up to the
    program's end."""

    def __init__(
        self,
        given: GivenConfig,
        seed: int,
        arrival_window_ms: float,
        inputs: KeptInputs,
        now_ns: Callable[[], SimTimeNs],
        run_until: Callable[[SimTimeNs], None],
        words: Sequence[str | os.PathLike[str]],
        mapped: Mapping[str, str],
        options: Mapping[str, Any],
    ) -> None:
        self._inputs, self._now_ns, self._run_until = inputs, now_ns, run_until
        self.returncode: int | None = None
        """Its exit code once it has ended."""
        self.waits = ""
        """Waits of its threads when it stopped last, for people."""
        program = _program([os.fspath(word) for word in words])
        ours, theirs = socket.socketpair()
        self._output = ProgramOutput()
        with theirs:
            self._process = subprocess.Popen(
                _command(program, mapped, theirs.fileno()),
                stdin=subprocess.DEVNULL,
                stdout=self._output.out,
                stderr=self._output.err,
                pass_fds=[theirs.fileno()],
                **options,
            )
        self._connection = ours
        self._from, self._to = ours.makefile("r"), ours.makefile("w")
        first = {
            "config": _given(given),
            "seed": seed,
            "arrival_window_ms": arrival_window_ms,
            "inputs": as_lines(inputs.inputs),
            "now_ns": now_ns(),
        }
        self._say(first)
        self._told = len(inputs.records)
        self._hear()

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
        """Title and text for the report of a test that fails: what it waits for, and what it has said."""
        state = "runs" if self.returncode is None else f"ended with {self.returncode}"
        text = "\n".join(
            each.rstrip() for each in (self.waits if self.is_running else "", self.stdout, self.stderr)
        )
        yield f"program ({state})", text.strip()

    def wait(self, timeout_ms: float = USUAL_LIMIT_MS) -> int:
        """Let simulated time pass until it ends; answers its exit code.

        Raises:
            ProgramRunsOn: it has not ended in this time.
        """
        __tracebackhide__ = True
        self._run_until(SimTimeNs(self._now_ns() + round(timeout_ms * NS_PER_MS)))
        if self.returncode is None:
            raise ProgramRunsOn(f"the program has not ended within {timeout_ms:g} ms:\n{self.waits}")
        return self.returncode

    def run_until(self, until_ns: SimTimeNs) -> tuple[list[str], SimTimeNs]:
        """Let the program go on to a time; answers the inputs that it made, and how far it has come."""
        records = self._inputs.records
        made = [each for each in records[self._told :] if isinstance(each, Logged)]
        self._say({"until_ns": until_ns, "inputs": as_lines(made)})
        return self._hear()

    def note_told(self) -> None:
        """Note that the bench has taken what the program did."""
        self._told = len(self._inputs.records)

    def close(self) -> None:
        """End it, if it runs. What it has said stays."""
        if self.is_running:
            self._process.kill()
            self._end()
        for each in (self._from, self._to, self._connection, self._output):
            each.close()

    def _say(self, what: Mapping[str, Any]) -> None:
        self._to.write(json.dumps(what) + "\n")
        self._to.flush()

    def _hear(self) -> tuple[list[str], SimTimeNs]:
        line = self._from.readline()
        if not line:
            self._end()
            return [], self._now_ns()
        said = json.loads(line)
        self.waits = said["waits"]
        if said["ended"] is not None:
            self._end()
        return said["inputs"], SimTimeNs(said["now_ns"])

    def _end(self) -> None:
        try:
            self.returncode = self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self.returncode = self._process.wait()


def _program(words: list[str]) -> list[str]:
    """Words behind ``hil virtual BENCH``."""
    if words and is_python(words[0]):
        words = words[1:]
    is_module = words[:1] == ["-m"]
    words = words[1:] if is_module else words
    if not words:
        raise ValueError(NO_WORDS)
    if is_module:
        return ["--module", "--", "-", *words]
    return ["--", "-", find_python_program(words[0]), *words[1:]]


def _command(program: list[str], mapped: Mapping[str, str], fd: int) -> list[str]:
    maps = [word for name, port in mapped.items() for word in ("--map", f"{name}={port}")]
    module = "hil.testing.owned_time.program"
    return [sys.executable, "-m", module, "--beside", str(fd), *maps, *program]


def _given(config: GivenConfig) -> str:
    """Configuration as another process can read it: a path, or text."""
    if path := path_of(config):
        return str(path.absolute())
    return as_json(config) if isinstance(config, Mapping) else str(config)
