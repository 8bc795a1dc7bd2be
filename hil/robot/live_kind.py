"""Bench in a process of its own, for keywords."""

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import serial
from robot.api import SkipExecution, logger

from hil.robot.bench_kind import StartedProgram, at_folder
from hil.testing import live
from hil.vocab.operation import Operation
from hil.vocab.time import NS_PER_S

USUAL_BAUD = 115_200


class LiveKind:
    """``BenchKind`` in a process of its own. Raises LiveError: with what ``hil serve`` said."""

    def __init__(self, file: Path) -> None:
        self._folder = file.parent
        self._stack = ExitStack()
        self._bench = self._stack.enter_context(live(file, capture=False))
        self.speed: float = self._bench.info["speed"]
        self._began_s = time.monotonic()
        self._began_ns: int = self._bench.info["sim_ns"]

    @property
    def now_s(self) -> float:
        return self._began_ns / NS_PER_S + (time.monotonic() - self._began_s) * self.speed

    def pass_time(self, seconds: float) -> None:
        time.sleep(seconds / self.speed)

    def open_port(self, port: str, baud: int | None) -> serial.Serial:
        url = self._bench.port(port)
        return serial.serial_for_url(url, baud or self._bench.info["bauds"][port] or USUAL_BAUD)

    def ask(self, operation: Operation, target: str, given: Mapping[str, Any]) -> Any:
        named = {operation.target.argument: target} if target else {}
        return self._bench.ask(operation.name, **named, **given)

    def start_program(
        self, program: str, arguments: Sequence[str], mapped: Mapping[str, str]
    ) -> StartedProgram:
        return self._bench.program([at_folder(self._folder, program), *arguments], mapped, cwd=self._folder)

    def packets(self, segment: str) -> list[str]:
        raise SkipExecution("kind=live: packets are not kept; `hil capture` has them")

    def close(self) -> None:
        logger.info(f"hil serve said:\n{self._bench.log}")
        self._stack.close()
