"""Kind of a bench, as keywords work at it, and refusals as failures of a test."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import serial
from robot.api import Failure, SkipExecution
from robot.libraries.BuiltIn import BuiltIn, RobotNotRunningError

from hil.config import ConfigError
from hil.testing import LiveError, NoPythonProgram, UnsupportedHere
from hil.vocab.operation import Operation
from hil.vocab.verbs import VerbRefused


class StartedProgram(Protocol):
    """Program that runs at a bench, or has ended."""

    @property
    def stdout(self) -> str:
        """Its output so far."""

    @property
    def stderr(self) -> str:
        """Its error output so far."""

    @property
    def returncode(self) -> int | None:
        """Its exit code once it has ended."""

    @property
    def is_running(self) -> bool:
        """True until it has ended."""

    def wait(self, timeout_ms: float) -> int:
        """Wait for its end. Raises ProgramRunsOn: it has not ended in this simulated time."""


class BenchKind(Protocol):
    """Bench of one test, in simulated or in real time."""

    @property
    def now_s(self) -> float:
        """Simulated time since the bench's start."""

    @property
    def speed(self) -> float:
        """Simulated seconds in one second of ``open_port``'s time-outs."""

    def pass_time(self, seconds: float) -> None:
        """Let simulated time pass."""

    def open_port(self, port: str, baud: int | None) -> serial.Serial:
        """Open a port or a tap by its address. ``baud``: None for the line's own."""

    def ask(self, operation: Operation, target: str, given: Mapping[str, Any]) -> Any:
        """Carry out an operation; answers its result."""

    def start_program(self, words: Sequence[str], mapped: Mapping[str, str], folder: Path) -> StartedProgram:
        """Start a program in ``folder``: its path or name, and what it is given. It opens ports of the bench
        by their names or those of ``mapped``."""

    def packets(self, segment: str) -> list[str]:
        """Packets on a segment since the last call, as text."""

    def close(self) -> None:
        """End the bench."""


class AtBench:
    """Keywords that work at the bench of a test, which begins when one first needs it."""

    @cached_property
    def _kind(self) -> BenchKind:
        raise NotImplementedError


@contextmanager
def refusals() -> Iterator[None]:
    """Let what is refused fail a test with the sentence that says why, without the name of a class; what the
    kind of bench cannot do skips it."""
    try:
        yield
    except UnsupportedHere as error:
        raise SkipExecution(str(error)) from None
    except (
        ConfigError,
        KeyError,
        LiveError,
        NoPythonProgram,
        OSError,
        ValueError,
        VerbRefused,
    ) as error:
        raise Failure(str(error)) from None


def suite_folder() -> Path:
    """Folder of the suite that runs, in which relative paths begin."""
    try:
        source = Path(BuiltIn().get_variable_value("${SUITE SOURCE}") or "")
    except RobotNotRunningError:
        return Path()
    return source if source.is_dir() else source.parent
