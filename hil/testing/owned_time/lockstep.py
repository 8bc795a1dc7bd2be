"""A program beside a test: both have the bench, and tell each other what they did to it.

The program's process has a bench of its own, made of the same configuration and the same inputs. It goes as
far as the test lets time pass, and answers with the inputs that its program made meanwhile; the test's bench
takes them at their times, and is the same again.
"""

import json
import os
from collections.abc import Callable
from typing import IO

from hil.sim.inputs import Logged
from hil.testing.bench import Bench
from hil.testing.input_lines import as_lines
from hil.vocab.time import SimTimeNs


class Lockstep:
    """The program's side, of a bench that has had the test's inputs so far."""

    def __init__(self, from_test: IO[str], to_test: IO[str], bench: Bench) -> None:
        self._bench = bench
        self._from_test, self._to_test = from_test, to_test
        self._told = len(bench.inputs.records)
        self.waits: Callable[[], str] = str
        """Answers what the program's threads wait for, for people."""

    def synchronize(self) -> SimTimeNs:
        """Tell the test what was done, and do what it did; answers until when time may pass."""
        self._tell(None)
        line = self._from_test.readline()
        if not line:
            os._exit(1)  # the test has ended
        said = json.loads(line)
        self._bench.play(said["inputs"])
        self._told = len(self._bench.inputs.records)
        return SimTimeNs(said["until_ns"])

    def ended(self, code: int) -> None:
        """Tell the test that the program has ended."""
        self._tell(code)

    def _tell(self, code: int | None) -> None:
        records = self._bench.inputs.records[self._told :]
        inputs = as_lines([each for each in records if isinstance(each, Logged)])
        said = {"now_ns": self._bench.now_ns, "inputs": inputs, "waits": self.waits(), "ended": code}
        self._to_test.write(json.dumps(said) + "\n")
        self._to_test.flush()
