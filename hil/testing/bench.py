"""A bench in memory, on the virtual clock."""

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from hil.compose import bench_runtime, find_catalogue, read_text, start_memories
from hil.compose.replay import MemoryOptions
from hil.config import BenchConfig, from_dict, parse
from hil.runs import (
    Execution,
    Progress,
    RunTextError,
    Soon,
    TwinAxes,
    all_problems,
    parse_run,
    plan_run,
    run_from_data,
)
from hil.sim.bench import VIRTUAL, BenchHooks, BenchRuntime, Store
from hil.sim.given_fault import fault_refusal
from hil.sim.input_reading import decode
from hil.sim.twin import Twin
from hil.telemetry import Recording, Sampler, Subscription
from hil.testing.faces import AxisFace, DeviceFace, FaultFace, PortFace, TapFace
from hil.testing.given import GivenConfig, NamedThings, NoSuchName, no_such, path_of, unreadable
from hil.testing.kept_inputs import KeptInputs
from hil.testing.program_beside import ProgramBeside
from hil.testing.serial_ports.open_benches import add_open, forget_closed
from hil.testing.serial_ports.ports_of_bench import SerialPorts
from hil.testing.wire_faces import WireFaces
from hil.vocab.address import address_of, no_part
from hil.vocab.axis import AxisNow
from hil.vocab.dialogue import Dialogue, Heard, Listen, Result, Send
from hil.vocab.segment import SegmentView
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.vocab.verbs import VerbRefused

RUN_LEAD_NS = 1_000_000
"""Time between a run's phrases: in virtual time nothing needs longer."""
START_MS, START_STEP_MS = 30_000, 10
LISTEN_SLICE_NS = 10 * NS_PER_MS
"""Time that a dialogue that listens lets pass between two looks at the port."""


class MemoryStore:
    """Store that writes at once: flash takes no time in the reference data."""

    def commit(
        self, device: Twin, sections: Mapping[str, bytes], answered: Callable[[bool], bool]
    ) -> bool | None:
        return True


MEMORY_STORE = MemoryStore()


class Bench:
    """Bench with all devices of a configuration, on the virtual clock, with memory in place of ports and
    files.

    ``config`` is a path, YAML text or a dict. The kit's own port stands in for each kind that it names.
    ``store`` and ``around``: as ``hil.compose.bench_runtime`` takes them. Nothing runs until ``run``; the
    same configuration, seed and calls give the same bytes.

    Long because all that a test asks of a bench stands here, one short method each.

    Raises:
        ConfigError: with every problem of the configuration, or its file cannot be read.
        TypeError: ``config`` is no path, no text and no dict.
        ValueError: a device is a real board.
    """

    def __init__(
        self,
        config: GivenConfig,
        seed: int = 0,
        *,
        store: Store = MEMORY_STORE,
        around: BenchHooks = VIRTUAL,
    ) -> None:
        __tracebackhide__ = True
        self._given = config
        self.config, folder = read_config(config)
        if self.config.real:
            names = ", ".join(self.config.real)
            raise ValueError(f"real boards (at:) know no simulated time: {names}; leave them out")
        self.seed = seed
        catalogue = find_catalogue({"memory": MemoryOptions}, self.config.profile_path)
        memories = start_memories(self.config, catalogue, folder)
        self.inputs = KeptInputs(self.config, memories, around.log)
        """Inputs so far, of which an input log can be written."""
        hooks = replace(around, log=self.inputs)
        self._runtime = bench_runtime(self.config, catalogue, memories, store, hooks)
        runtime, devices = self._runtime, self._runtime.devices
        self._ports = {
            device.uarts.label(name, uart): PortFace(runtime, device, uart)
            for name, device in devices.items()
            for uart in device.uarts
        }
        self._axes = {
            address: AxisFace(runtime, device, axis, self._record)
            for address, (device, axis) in runtime.parts.axes.items()
        }
        self._devices = {name: DeviceFace(runtime, device) for name, device in devices.items()}
        self._wires = WireFaces(self, runtime, catalogue.wire_kinds)
        self._taps = {name: self._wires.tap(name, tap) for name, tap in runtime.taps.items()}
        self._serials = SerialPorts(runtime, self.config, catalogue, self._passed, self._stop_ns)
        add_open(self._serials)
        self._sampler = Sampler(runtime)
        self._run_axes = TwinAxes(runtime, self._sampler)
        for fault in self.config.faults:
            self.fault(fault.fault, fault.target, **(fault.model_extra or {}))
        self._recordings: list[tuple[Subscription, Recording]] = []
        self.more_sections: list[Callable[[], Iterable[tuple[str, str]]]] = []
        """Functions that answer more titles and texts for the report of a test that fails."""
        self._program: ProgramBeside | None = None

    @property
    def now_ns(self) -> SimTimeNs:
        """Simulated time since the bench's start."""
        return self._runtime.now_ns

    @property
    def runtime(self) -> BenchRuntime:
        """Devices and wires behind the faces, for what drives them itself."""
        return self._runtime

    @property
    def serial_ports(self) -> SerialPorts:
        """Ports as programs open them."""
        return self._serials

    def start(self) -> list[str]:
        """Let simulated time pass until all boards answer; answers the names of those that do not within
        half a minute."""
        for _ in range(START_MS // START_STEP_MS):
            late = [name for name, device in self._runtime.devices.items() if not device.is_ready]
            if not late:
                return []
            self.run(START_STEP_MS)
        return late

    def program(
        self,
        words: Sequence[str | os.PathLike[str]],
        map: Mapping[str, str] | None = None,
        **options: Any,
    ) -> ProgramBeside:
        """Run a Python program on this bench's time, in a process of its own. It begins when the boards
        answer, and goes on as far as the test lets time pass, by ``run`` or by the program's ``wait``.

        ``words``: its file or its name on ``PATH``, or ``-m`` and a module, and what it is given; ``map``:
        names of ports by further names that it opens; ``options``: of ``subprocess.Popen``, as ``cwd``.

        Raises:
            NoPythonProgram: there is none of this name.
            KeyError: there is no such port.
            ValueError: another program runs here.
        """
        __tracebackhide__ = True
        if self._program and self._program.is_running:
            raise ValueError("another program runs on this bench; wait for its end, or close it")
        for port in (map or {}).values():
            NamedThings("port", self._serials.terminals)[port]
        self.start()
        if self._program:
            self._program.close()
        self._program = ProgramBeside(
            self._given, self.inputs, lambda: self.now_ns, self._run_beside, words, map or {}, options
        )
        self.more_sections.append(self._program.sections)
        return self._program

    def run(self, ms: float) -> None:
        """Let ``ms`` milliseconds of simulated time pass."""
        self._advance(SimTimeNs(self.now_ns + round(ms * NS_PER_MS)))

    def run_until(self, ms: float) -> None:
        """Run until the simulated time is ``ms`` milliseconds; never back."""
        self._advance(SimTimeNs(round(ms * NS_PER_MS)))

    def port(self, name: str, uart: str = "") -> PortFace:
        """Port at an address, as in ``m1`` or ``s1.network``; ``uart``: name of the device's UART.

        Raises:
            KeyError: there is no such UART.
        """
        __tracebackhide__ = True
        device, part = address_of(name)
        if device not in self._runtime.devices:
            raise no_such("device", device, self._runtime.devices)
        uarts = self._runtime.devices[device].uarts
        if (uart or part) not in uarts:
            raise NoSuchName(no_part(device, "serial interface", uart or part, uarts))
        return self._ports[uarts.label(device, uart or part)]

    def serial(self, name: str, baudrate: int | None = None, **options: Any) -> Any:
        """Open a port or a tap as pyserial's ``Serial``, whose ``options`` these are: reading lets simulated
        time pass, up to the time-out, and no further than the bytes. ``baudrate``: the line's own by default.

        Raises:
            KeyError: there is no such port.
            serial.SerialException: as at a real port.
        """
        __tracebackhide__ = True
        return self._serials.open(name, baudrate, options)

    def tap(self, name: str) -> TapFace:
        """Tap by its name, as in ``bus0.master``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("tap", self._taps)[name]

    def fault(self, kind: str, target: str, **parameters: float | str) -> FaultFace:
        """Make something go wrong (``hil.vocab.faults`` has the kinds), until it is cleared.

        Raises:
            FaultRefused: there is no such kind or target, or a parameter does not do.
        """
        self._runtime.faults.place(target)
        number = self._runtime.inject(fault_refusal(kind, target, parameters))
        return FaultFace(number, self._runtime)

    def segment(self, name: str) -> SegmentView:
        """Segment by its name, read-only. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("segment", self._runtime.segments)[name]

    def wire(self, key: str, name: str) -> Any:
        """Face that a bus has for tests of its wire ``name``, which is under ``key`` in the configuration.
        Raises KeyError: there is none."""
        __tracebackhide__ = True
        return self._wires.wire(key, name)

    def canbus(self, name: str = "can0") -> Any:
        """CAN bus by its name, a ``CanBusFace``, with a node of the test's own on it from the first call on.
        Raises KeyError: there is none."""
        __tracebackhide__ = True
        return self.wire("can", name)

    def axis(self, name: str) -> AxisFace:
        """Axis at an address, as in ``m1`` or ``arm.elbow``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("axis", self._axes)[self._runtime.parts.axis_address(name) or name]

    def device(self, name: str) -> DeviceFace:
        """Twin by its name. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("device", self._devices)[name]

    @property
    def run_axes(self) -> Mapping[str, AxisNow]:
        """Axes as a run would begin with them now."""
        return self._run_axes.axes()

    def execute(self, run: Mapping[str, object] | str) -> Execution:
        """Check and plan a multi-axis run (``hil.runs``) now; drive it with ``perform``.

        Raises:
            ConfigError: it cannot be done, with all problems.
        """
        axes = self._run_axes.axes()
        try:
            document = parse_run(run, "<run>") if isinstance(run, str) else run_from_data(run)
        except RunTextError as error:
            raise all_problems(error, axes) from None
        return Execution(plan_run(*document, axes), self._run_axes, Soon(self._run_axes, RUN_LEAD_NS))

    def perform(self, run: Mapping[str, object] | str | Execution) -> Progress:
        """Carry out a run to its end, in simulated time.

        Raises:
            ConfigError: it cannot be done, with all problems.
        """
        execution = run if isinstance(run, Execution) else self.execute(run)
        for until_ns in execution.run():
            self._advance(SimTimeNs(until_ns))
        return execution.progress

    def talk(self, name: str, dialogue: Dialogue[Result], uart: str = "") -> Result:
        """Carry out a dialogue at a device's port, in simulated time; answers its result."""
        port = self.port(name, uart)
        heard: list[tuple[SimTimeNs, bytes]] = []
        answer: Heard | None = None
        try:
            while True:
                step = dialogue.send(answer)
                answer = None
                if isinstance(step, Send):
                    port.write(step.data)
                elif isinstance(step, Listen):
                    end_ns = self.now_ns + step.timeout_ns
                    while (not heard or heard[0][0] > self.now_ns) and self.now_ns < end_ns:
                        next_ns = heard[0][0] if heard else self.now_ns + LISTEN_SLICE_NS
                        self._advance(SimTimeNs(min(next_ns, end_ns)))
                        heard += port.read_complete()
                    is_there = heard and heard[0][0] <= self.now_ns
                    answer = Heard(*heard.pop(0)) if is_there else Heard(self.now_ns, b"")
        except StopIteration as done:
            result: Result = done.value
            return result

    def close(self) -> None:
        """Free the bench's memory now instead of with its last reference."""
        forget_closed(self._serials)
        if self._program:
            self._program.close()
        self._runtime.stop()

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _record(self, axis: str, signals: tuple[str, ...], interval_ns: int) -> Recording:
        subscription = self._sampler.subscribe(axis, signals, interval_ns)
        recording = Recording(signals)
        self._recordings.append((subscription, recording))
        return recording

    def play(self, lines: Iterable[str]) -> None:
        """Let inputs, as lines of an input log, take effect at their times."""
        for line in lines:
            logged = decode(json.loads(line))
            if logged.at_ns > self.now_ns:
                self._pass(logged.at_ns)
            with suppress(VerbRefused):  # it was refused where it came from, too
                self._runtime.apply_input(logged.device, logged.input, logged.at_ns)

    def _advance(self, until_ns: SimTimeNs) -> None:
        if self._program and self._program.is_running:
            self._run_beside(until_ns)
        self._pass(until_ns)

    def _run_beside(self, until_ns: SimTimeNs) -> None:
        """Let time pass to ``until_ns``, or to the end of the program that runs here."""
        program = self._program
        if program and program.is_running:
            lines, now_ns = program.run_until(until_ns)
            self.play(lines)
            program.note_told()
            self._pass(now_ns)

    def _pass(self, until_ns: SimTimeNs) -> None:
        while (stop_ns := self._stop_ns()) < until_ns:
            self._advance_to(stop_ns)
        self._advance_to(until_ns)

    def _stop_ns(self) -> SimTimeNs:
        """Time by which samples have to be fetched, or at which something happens at a port."""
        due_ns, slice_ns = self._serials.due_ns, self._sampler.period_ns
        return min(due_ns, SimTimeNs(self.now_ns + slice_ns)) if slice_ns else due_ns

    def _advance_to(self, until_ns: SimTimeNs) -> None:
        self._runtime.advance(until_ns)
        self._passed(until_ns)

    def _passed(self, now_ns: SimTimeNs) -> None:
        self._serials.passed(now_ns)
        if self._recordings:
            self._sampler.poll()
        for subscription, recording in self._recordings:
            recording.rows += subscription.drain()
            recording.lost = subscription.lost


def read_config(config: GivenConfig) -> tuple[BenchConfig, Path]:
    """Read a configuration from a path, YAML text or a dict; answers it with the folder its files are looked
    up from.

    Raises:
        ConfigError: with every problem, or the file cannot be read.
        TypeError: it is no path, no text and no dict.
    """
    __tracebackhide__ = True
    path = path_of(config)
    catalogue = find_catalogue({"memory": MemoryOptions})
    if path:
        try:
            text = read_text(path)
        except (OSError, ValueError) as error:
            raise unreadable(path, error) from None
        return parse(text, str(path), catalogue), path.parent
    if isinstance(config, Mapping):
        return from_dict(config, catalogue), Path()
    return parse(str(config), "<text>", catalogue), Path()
