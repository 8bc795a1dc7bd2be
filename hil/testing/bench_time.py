"""Passing of a bench's simulated time, with its ports, recordings and the program beside it."""

import json
from collections.abc import Callable, Iterable
from contextlib import suppress

from hil.config import BenchConfig, Catalogue
from hil.sim.bench import BenchRuntime
from hil.sim.input_reading import decode
from hil.telemetry import Recording, Sampler, Subscription
from hil.telemetry.recording import own_units
from hil.testing.doors.bench_doors import BenchDoors
from hil.testing.program_beside import ProgramBeside
from hil.testing.seeds.late_arrivals import LateArrivals
from hil.testing.serial_ports.line_ends import LineEnd
from hil.testing.serial_ports.ports_of_bench import SerialPorts
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.vocab.verbs import VerbRefused


class BenchTime:
    """Time of a bench in memory: what has to keep up with it does."""

    def __init__(
        self, runtime: BenchRuntime, config: BenchConfig, catalogue: Catalogue, arrivals: LateArrivals
    ) -> None:
        self._runtime, self._arrivals = runtime, arrivals
        self.serials = SerialPorts(
            runtime, config, catalogue, self._advance_until_heard, self._passed, self._stop_ns
        )
        self.sampler = Sampler(runtime)
        self.doors = BenchDoors(runtime, config, catalogue, self.run_until, self._stop_ns)
        self._recordings: list[tuple[Subscription, Recording]] = []
        self._program: ProgramBeside | None = None

    def now_ns(self) -> SimTimeNs:
        """Simulated time since the bench's start."""
        return self._runtime.now_ns

    def run_until(self, until_ns: SimTimeNs) -> None:
        """Let time pass, with the program that runs here."""
        self.run_beside(until_ns)
        self._pass(until_ns)

    def run_beside(self, until_ns: SimTimeNs) -> None:
        """Let time pass to ``until_ns``, or to the end of the program that runs here."""
        program = self._program
        while program and program.is_running:
            lines, now_ns = program.run_until(min(until_ns, self._arrivals.due_ns))
            with self._arrivals.paused():  # the program has not heard of what comes at the time of its inputs
                self.play(lines)
            program.note_told()
            self._pass(now_ns)
            if now_ns >= until_ns:
                break

    def begin_program(self, make: Callable[[], ProgramBeside]) -> ProgramBeside:
        """Have a program beside the test, in place of one that has ended."""
        self._end_program()
        self._program = make()
        return self._program

    @property
    def has_program(self) -> bool:
        """True while a program runs here."""
        return self._program is not None and self._program.is_running

    def close(self) -> None:
        """End the program that runs here, and close the doors."""
        self._end_program()
        self.doors.close()

    def _end_program(self) -> None:
        if self._program:
            self._program.close()

    def record(self, axis: str, signals: tuple[str, ...], interval_ns: int) -> Recording:
        """Begin a recording of signals of an axis."""
        subscription = self.sampler.subscribe(axis, signals, interval_ns)
        recording = Recording(signals, units=own_units(self._runtime.parts.axis(axis).kind, signals))
        self._recordings.append((subscription, recording))
        return recording

    def play(self, lines: Iterable[str]) -> None:
        """Let inputs, as lines of an input log, take effect at their times."""
        for line in lines:
            logged = decode(json.loads(line))
            if logged.at_ns > self.now_ns():
                self._pass(logged.at_ns)
            with suppress(VerbRefused):  # it was refused where it came from, too
                self._runtime.apply_input(logged.device, logged.input, logged.at_ns)

    def _pass(self, until_ns: SimTimeNs) -> None:
        while (stop_ns := self._stop_ns()) < until_ns:
            self._advance_to(stop_ns)
        self._advance_to(until_ns)

    def _stop_ns(self) -> SimTimeNs:
        """Time by which samples have to be fetched, or at which something happens at a port or a door."""
        due_ns = min(self.serials.due_ns, self._arrivals.due_ns, self.doors.due_ns)
        slice_ns = self.sampler.period_ns
        return min(due_ns, SimTimeNs(self.now_ns() + slice_ns)) if slice_ns else due_ns

    def _advance_until_heard(self, limit_ns: SimTimeNs, ends: list[LineEnd]) -> None:
        """Let time pass until one of these lines is heard; beside a program, for a millisecond at most."""
        if self.has_program:
            self.run_until(SimTimeNs(min(limit_ns, self.now_ns() + NS_PER_MS)))
        else:
            self._runtime.advance_until_heard(limit_ns, ends)

    def _advance_to(self, until_ns: SimTimeNs) -> None:
        self._runtime.advance(until_ns)
        self._passed(until_ns)

    def _passed(self, now_ns: SimTimeNs) -> None:
        self._arrivals.passed(now_ns)
        self.serials.passed(now_ns)
        self.doors.passed(now_ns)
        if self._recordings:
            self.sampler.poll()
        for subscription, recording in self._recordings:
            recording.rows += subscription.drain()
            recording.lost = subscription.lost
