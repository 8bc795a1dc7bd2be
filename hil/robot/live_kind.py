"""Bench in a process of its own, of twins or of real boards, for keywords."""

import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Any

import serial
from robot.api import SkipExecution, logger

from hil.robot.bench_kind import StartedProgram
from hil.testing import ServedBench, live
from hil.testing.real_boards import RealBoards
from hil.vocab.operation import Operation
from hil.vocab.time import NS_PER_S


class LiveKind:
    """``BenchKind`` in a process of its own, ``served``.

    Raises:
        LiveError: with what ``hil serve`` said, or which real boards are not there.
    """

    def __init__(self, served: AbstractContextManager[ServedBench]) -> None:
        self._stack = ExitStack()
        self._bench = self._stack.enter_context(served)
        self.speed: float = self._bench.info["speed"]
        self._began_s = time.monotonic()
        self._began_ns: int = self._bench.info["sim_ns"]

    @property
    def now_s(self) -> float:
        return self._began_ns / NS_PER_S + (time.monotonic() - self._began_s) * self.speed

    def pass_time(self, seconds: float) -> None:
        time.sleep(seconds / self.speed)

    def open_port(self, port: str, baud: int | None) -> serial.Serial:
        return self._bench.serial(port, baud)

    def ask(self, operation: Operation, target: str, given: Mapping[str, Any]) -> Any:
        if operation.name == "inject":
            return {"number": self._bench.fault(given["fault"], target, **given["parameters"]).number}
        named = {operation.target.argument: target} if target else {}
        return self._bench.desk.do(operation.name, target, **named, **given)

    def start_program(self, words: Sequence[str], mapped: Mapping[str, str], folder: Path) -> StartedProgram:
        return self._bench.program(words, mapped, cwd=folder)

    def packets(self, segment: str) -> list[str]:
        raise SkipExecution(f"kind={self._bench.kind}: packets are not kept; `hil capture` has them")

    def close(self) -> None:
        logger.info(f"hil serve said:\n{self._bench.log}")
        self._stack.close()


def twins(file: Path) -> LiveKind:
    """Serve a configuration in real time."""
    return LiveKind(live(file, capture=False))


def real_boards(file: Path) -> LiveKind:
    """Reach the real boards of a configuration. Raises ConfigError, ValueError: as ``RealBoards``."""
    return LiveKind(RealBoards(file).serve(capture=False))
