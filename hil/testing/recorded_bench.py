"""A bench in memory as a recording has it, at a time of it, from where a test goes on."""

import os
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from hil.compose.bundles import trusts_all, trusts_nobody
from hil.compose.log_course import in_time
from hil.compose.log_lines import read_log
from hil.recorded.log_beginning import before_reload
from hil.recorded.log_changes import changed
from hil.recorded.recorded_run import RecordedRun
from hil.sim.bench import VIRTUAL
from hil.sim.firmware_guard import LoggedStops
from hil.sim.input_check import input_problem
from hil.sim.input_log import InputLog
from hil.sim.inputs import CommitDone, InputLogError, Logged, Stopped
from hil.sim.twin import Twin
from hil.testing.bench import Bench
from hil.testing.unsupported import UnsupportedHere
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.vocab.verbs import VerbRefused


class _LogStore:
    """Store whose answers are those of a log while it is followed, and durable at once else."""

    def __init__(self, log: InputLog) -> None:
        self.is_followed = False
        self.waiting: set[str] = set()
        """Devices that wait for an answer, which is an input of the log."""
        self._answers: dict[str, deque[CommitDone]] = {}
        for logged in log.inputs:
            if isinstance(logged.input, CommitDone):
                self._answers.setdefault(logged.device, deque()).append(logged.input)

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        if not self.is_followed:
            return True
        answers = self._answers.get(device.name)
        done = answers.popleft() if answers else None
        if done and done.at_once:
            return done.durable
        self.waiting.add(device.name)
        return None

    def takes(self, logged: Logged) -> bool:
        """True if an input is none of a memory, or answers a device that waits."""
        if not isinstance(logged.input, CommitDone):
            return True
        is_answer = not logged.input.at_once and logged.device in self.waiting
        self.waiting.discard(logged.device)
        return is_answer


class RecordedBench(Bench):
    """Bench of a recording, as it was at a time of it; from there on the test goes on alone, or with what
    came next (``follow``).

    ``path``: a log or a bundle; ``until_ms``: None: its end. ``settings``, ``faults`` and ``without`` change
    the run from its start, as `hil replay` takes them: ``settings=["m1.pKp=10"]``. ``trust``: True lets code
    of boards run that are in the bundle. All that a bench in memory has it has too, but ``program``.

    Raises:
        InputLogError: it is no recording, or of another program; says where.
        ConfigError: its configuration does not fit this program.
        ChangeRefused: a change names nothing, or its value cannot be.
        ValueError: it has no such time.
        OSError: it cannot be read.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        until_ms: float | None = None,
        *,
        settings: Sequence[str] = (),
        faults: Sequence[str] = (),
        without: Sequence[str] = (),
        trust: bool = False,
    ) -> None:
        __tracebackhide__ = True
        log = read_log(Path(path), strict=False, trusts=trusts_all if trust else trusts_nobody)
        log = before_reload(log)
        with closing(RecordedRun(log)) as run:
            self.end_ms = run.end_ns / NS_PER_MS
            """Time of the recording's end, or of the bench's first reload."""
            log = changed(run, settings, faults, without).log
        self._log, self._is_changed = log, bool(settings or faults or without)
        self._left = deque(in_time(log.inputs))
        """Numbers of inputs to come."""
        self._stops = LoggedStops({})
        self._store = _LogStore(log)
        super().__init__(
            _simulated(log.config),
            store=self._store,
            around=replace(VIRTUAL, guard=self._stops),
            memories=log.memories,
        )
        try:
            self.follow(until_ms)
        except BaseException:
            self.close()
            raise
        for port in self._ports.values():
            port.read()  # what comes from here on is new

    def follow(self, until_ms: float | None = None) -> None:
        """Go on with the recording's inputs to a time, by default its end. What a test gave before may make
        the boards answer otherwise.

        Raises:
            ValueError: the recording has no such time.
        """
        __tracebackhide__ = True
        until_ms = self.end_ms if until_ms is None else until_ms
        if not self.now_ns / NS_PER_MS <= until_ms <= self.end_ms:
            first = f"{self.now_ns / NS_PER_MS:g}"
            raise ValueError(
                f"until_ms: write {first} to {self.end_ms:g}, where the recording ends, not {until_ms!r}"
            )
        until_ns = SimTimeNs(round(until_ms * NS_PER_MS))
        if self._log.reloads and (at_ns := self._log.reloads[0].reload.at_ns) <= until_ns:
            raise ValueError(f"until_ms: the bench was reloaded at {at_ns / NS_PER_MS:g} ms; write less")
        due: list[int] = []
        while self._left and self._log.inputs[self._left[0]].at_ns <= until_ns:
            due.append(self._left.popleft())
        inputs = [self._log.inputs[index] for index in due]
        stops = ((each.device, each.input) for each in inputs if isinstance(each.input, Stopped))
        self._stops.left = {(device, stopped.turn): stopped for device, stopped in stops}
        self._store.is_followed = True
        for index, each in zip(due, inputs, strict=True):
            self._time.run_until(max(each.at_ns, self.now_ns))
            if not isinstance(each.input, Stopped) and self._store.takes(each):
                self._give(index, each)
        self._time.run_until(until_ns)
        self._store.is_followed = False
        self._stops.left = {}
        for device in self._store.waiting:
            self.arrivals.arrive(self._answers_ns(device), device, CommitDone(durable=True))
        self._store.waiting.clear()

    def _give(self, index: int, logged: Logged) -> None:
        """Let an input take effect, if the bench as it was changed has what it is for."""
        if problem := input_problem(self.runtime, logged.device, logged.input):
            if not self._is_changed:
                raise InputLogError(f"{self._log.where(index)}: {problem}")
            return
        with suppress(VerbRefused):  # it was refused then, too
            self.runtime.apply_input(logged.device, logged.input, logged.at_ns)

    def _answers_ns(self, device: str) -> SimTimeNs:
        """Time at which a memory that a device waits for answered."""
        for logged in (self._log.inputs[index] for index in self._left):
            if logged.device == device and isinstance(logged.input, CommitDone):
                return logged.at_ns
        return self.now_ns

    def program(self, *words: Any, **options: Any) -> Any:
        """Refuse a program beside the test: it would be at the bench's beginning."""
        raise UnsupportedHere("recorded", "program: it begins with the bench")


def _simulated(config: Mapping[str, Any]) -> dict[str, Any]:
    """Configuration of a log without what its inputs say, and without real boards."""
    twins = {name: device for name, device in config["devices"].items() if not device.get("at")}
    return {**config, "devices": twins, "faults": []}
