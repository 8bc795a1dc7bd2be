"""A bench in memory, on the virtual clock."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hil.compose import bench_runtime, find_catalogue, start_memories
from hil.compose.replay import MemoryOptions
from hil.sim.bench import VIRTUAL, BenchHooks, BenchRuntime, Store
from hil.sim.reloads import Memories
from hil.testing.addressed_pin import AddressedPin
from hil.testing.bench_dialogue import talk_at
from hil.testing.bench_time import BenchTime
from hil.testing.config_reading import read_config
from hil.testing.faces import AxisFace, DeviceFace, FaultFace, PortFace, TapFace
from hil.testing.given import GivenConfig, NamedThings, NoSuchName, checked_ms, no_such
from hil.testing.kept_inputs import KeptInputs
from hil.testing.memory_store import MEMORY_STORE
from hil.testing.program_beside import ProgramBeside
from hil.testing.seeds.bench_chance import BenchChance, FaultKey
from hil.testing.seeds.late_arrivals import LateArrivals
from hil.testing.serial_ports.open_benches import add_open, forget_closed
from hil.testing.serial_ports.ports_of_bench import SerialPorts
from hil.testing.waiting import WITHIN_MS, wait_until
from hil.testing.wire_faces import WireFaces
from hil.vocab.address import address_of, no_part
from hil.vocab.axis import AxisNow
from hil.vocab.dialogue import Dialogue, Result
from hil.vocab.segment import SegmentView
from hil.vocab.time import NS_PER_MS, SimTimeNs

if TYPE_CHECKING:
    from hil.runs import Execution, Progress
    from hil.testing.kit_runs import KitRuns

START_MS, START_STEP_MS = 30_000, 10


class Bench:
    """Bench with all devices of a configuration, on the virtual clock, with memory in place of ports and
    files.

    ``config`` is a path, YAML text or a dict. The kit's own port stands in for each kind that it names.
    ``seed``: of all chance; 0 leaves each fault its own. ``arrival_window_ms``: bytes that are written arrive
    at a time within so many milliseconds, by chance. ``leaves_out``: True for faults that are not injected.
    ``memories``: those of the boards at the start, by name; None: as the configuration says. ``store`` and
    ``around``: as ``hil.compose.bench_runtime`` takes them. Nothing runs until ``run``; the same
    configuration, seed and calls give the same bytes.

    Long because all that a test asks of a bench stands here, one short method each.

    Raises:
        ConfigError: with every problem of the configuration, or its file cannot be read.
        TypeError: ``config`` is no path, no text and no dict.
        ValueError: a device is a real board.
    """

    kind = "virtual"

    def __init__(
        self,
        config: GivenConfig,
        seed: int = 0,
        *,
        arrival_window_ms: float = 0.0,
        leaves_out: Callable[[FaultKey], bool] = lambda key: False,
        store: Store = MEMORY_STORE,
        around: BenchHooks = VIRTUAL,
        memories: Memories | None = None,
    ) -> None:
        __tracebackhide__ = True
        self._given, self._is_closed = config, False
        self._faults = BenchChance(seed, leaves_out)
        given, folder = read_config(config)
        self.config = self._faults.config(given)
        if self.config.real:
            names = ", ".join(self.config.real)
            raise ValueError(f"real boards (at:) know no simulated time: {names}; leave them out")
        self.seed = seed
        self.chance = self._faults.random
        """Random numbers of this seed, for the test."""
        self.arrivals = LateArrivals(arrival_window_ms, self._faults.stream("arrivals"))
        catalogue = find_catalogue({"memory": MemoryOptions}, self.config.profile_path)
        if memories is None:
            memories = start_memories(self.config, catalogue, folder)
        self.inputs = KeptInputs(self.config, memories, around.log)
        """Inputs so far, of which an input log can be written."""
        hooks = replace(around, log=self.inputs, hold=self.arrivals.hold)
        self._runtime = bench_runtime(self.config, catalogue, memories, store, hooks)
        runtime, devices = self._runtime, self._runtime.devices
        self.arrivals.begin(runtime)
        self._time = BenchTime(runtime, self.config, catalogue, self.arrivals)
        self._serials = self._time.serials
        self._ports = {
            device.uarts.label(name, uart): PortFace(runtime, device, uart)
            for name, device in devices.items()
            for uart in device.uarts
        }
        self._axes = {
            address: AxisFace(runtime, device, axis, self._time.record)
            for address, (device, axis) in runtime.parts.axes.items()
        }
        self._devices = {name: DeviceFace(runtime, device) for name, device in devices.items()}
        self._wires = WireFaces(self, runtime, catalogue.wire_kinds)
        self._taps = {name: self._wires.tap(name, tap) for name, tap in runtime.taps.items()}
        add_open(self._serials)
        for fault in self.config.faults:
            self.fault(fault.fault, fault.target, **(fault.model_extra or {}))
        self.more_sections: list[Callable[[], Iterable[tuple[str, str]]]] = []
        """Functions that answer more titles and texts for the report of a test that fails."""

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
        if isinstance(words, str):
            raise TypeError(f"program({words!r}): give a list of words, as {words.split()}")
        if self._time.has_program:
            raise ValueError("another program runs on this bench; wait for its end, or close it")
        for port in (map or {}).values():
            NamedThings("port", self._serials.terminals)[port]
        self.start()
        time = self._time
        begun = time.begin_program(
            lambda: ProgramBeside(
                self._given,
                self.seed,
                self.arrivals.window_ms,
                self.inputs,
                time.now_ns,
                time.run_beside,
                words,
                map or {},
                options,
            )
        )
        self.more_sections.append(begun.sections)
        return begun

    def run(self, ms: float) -> None:
        """Let ``ms`` milliseconds of simulated time pass. Raises ValueError: they are less than 0."""
        __tracebackhide__ = True
        self._check_open()
        self._time.run_until(SimTimeNs(self.now_ns + round(checked_ms("run", ms) * NS_PER_MS)))

    def run_until(self, ms: float) -> None:
        """Run until the simulated time is ``ms`` milliseconds. Raises ValueError: it is later than that."""
        __tracebackhide__ = True
        self._check_open()
        until_ns = round(checked_ms("run_until", ms) * NS_PER_MS)
        if until_ns < self.now_ns:
            now_ms = f"{self.now_ns / NS_PER_MS:.15g}"
            what = f"run_until(ms={ms:.15g}): it is {now_ms} ms already, and time does not go back"
            raise ValueError(f"{what}; give {now_ms} or more, or use run(ms=...)")
        self._time.run_until(SimTimeNs(until_ns))

    def wait_until(
        self, condition: Callable[[], object] | str, of_axis: str = "", /, *, within_ms: float = WITHIN_MS
    ) -> int:
        """Let simulated time pass until a condition holds, which is looked at each millisecond; answers the
        time then. A condition is a function, as in ``wait_until(lambda: b"SAC>" in port.read())``, or on
        fields of an axis as `hil wait` takes it: ``wait_until("m1", "position_deg > 89", within_ms=2000)``.

        Raises:
            NotInTime: it does not hold within ``within_ms``, with the fields as they are then.
            ValueError: there are no such fields, or there is no such condition.
            KeyError: there is no such axis.
        """
        __tracebackhide__ = True
        return wait_until(self, condition, of_axis, within_ms)

    def port(self, name: str, uart: str = "") -> PortFace:
        """Port at an address, as in ``m1`` or ``s1.network``; ``uart``: name of the device's UART.

        Raises:
            KeyError: there is no such UART.
        """
        __tracebackhide__ = True
        if not isinstance(name, str):
            raise TypeError(f"{name!r} is no name of a port; write it as text, as in b.port('m1')")
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
        fault, is_left_out = self._faults.fault(kind, target, parameters)
        if is_left_out:
            self._runtime.faults.check(fault, with_others=True)
        return FaultFace(0 if is_left_out else self._runtime.inject(fault), self._runtime)

    def segment(self, name: str) -> SegmentView:
        """Segment by its name, read-only. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("segment", self._runtime.segments)[name]

    def wire(self, key: str, name: str) -> Any:
        """Face that a bus has for tests of its wire ``name``, which is under ``key`` in the configuration.
        Raises KeyError: there is none."""
        __tracebackhide__ = True
        return self._wires.wire(key, name)

    def can(self, name: str = "can0") -> Any:
        """CAN bus by its name, a ``CanBusFace``, with a node of the test's own on it from the first call on.
        Raises KeyError: there is none."""
        __tracebackhide__ = True
        return self.wire("can", name)

    canbus = can
    """The same, by its older name."""

    def capture(self, file: Path | str) -> AbstractContextManager[object]:
        """Capture the traffic of all ports and wires into a file, as pcapng, for a ``with`` block; its times
        are simulated."""
        from hil.testing.failures.bench_capture import BenchCapture

        return BenchCapture(self.inputs, self._runtime, Path(file))

    def modbus(self, **options: Any) -> Any:
        """Connect pymodbus's ``ModbusTcpClient``, whose ``options`` these are, to the bench's Modbus bridge:
        requests and time-outs take simulated time.

        Raises:
            KeyError: the configuration has no Modbus bridge.
            ValueError: the bench is closed.
        """
        __tracebackhide__ = True
        return self._time.doors.door("modbus").client(options)

    def modbus_async(self, **options: Any) -> Any:
        """Make pymodbus's ``AsyncModbusTcpClient`` as ``modbus`` does, not yet connected. From now on
        simulated time passes while all tasks of the event loop wait that runs now."""
        __tracebackhide__ = True
        return self._time.doors.door("modbus").async_client(options)

    def zenoh(self) -> Any:
        """Open a session at the bench's zenoh bridge, with the calls of zenoh's ``Session``: waiting for
        replies and samples lets simulated time pass. Raises KeyError: the configuration has none."""
        __tracebackhide__ = True
        return self._time.doors.door("zenoh").session()

    def axis(self, name: str) -> AxisFace:
        """Axis at an address, as in ``m1`` or ``arm.elbow``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("axis", self._axes)[self._runtime.parts.axis_address(name) or name]

    def device(self, name: str) -> DeviceFace:
        """Twin by its name. Raises KeyError: there is none."""
        __tracebackhide__ = True
        return NamedThings("device", self._devices)[name]

    def pin(self, name: str) -> AddressedPin:
        """Pin at an address, as in ``u1.D6`` or ``arm.elbow.step``: its ``edges`` so far, its ``level``, and
        ``set``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        device, _, pin = name.partition(".")
        return AddressedPin(self.device(device).pin(pin), self._runtime.devices[device], pin)

    @cached_property
    def _runs(self) -> "KitRuns":
        from hil.testing.kit_runs import KitRuns  # most tests have none

        return KitRuns(self._runtime, self._time.sampler, self._time.run_until)

    @property
    def run_axes(self) -> Mapping[str, AxisNow]:
        """Axes as a run would begin with them now."""
        return self._runs.axes

    def execute(self, run: Mapping[str, object] | str) -> "Execution":
        """Check and plan a multi-axis run (``hil.runs``) now; drive it with ``perform``.

        Raises:
            ConfigError: it cannot be done, with all problems.
        """
        return self._runs.execute(run)

    def perform(self, run: "Mapping[str, object] | str | Execution") -> "Progress":
        """Carry out a run to its end, in simulated time.

        Raises:
            ConfigError: it cannot be done, with all problems.
        """
        return self._runs.perform(run)

    def talk(self, name: str, dialogue: Dialogue[Result], uart: str = "") -> Result:
        """Carry out a dialogue at a device's port, in simulated time; answers its result."""
        return talk_at(self.port(name, uart), dialogue, self._time.now_ns, self._time.run_until)

    def _check_open(self) -> None:
        __tracebackhide__ = True
        if self._is_closed:
            remedy = "use it inside of its `with`, or of the test that made it"
            raise ValueError(f"the bench {self.config.bench} is closed, and its time has ended; {remedy}")

    def close(self) -> None:
        """Free the bench's memory now instead of with its last reference."""
        self._is_closed = True
        forget_closed(self._serials)
        self._time.close()
        self._runtime.stop()

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def play(self, lines: Iterable[str]) -> None:
        """Let inputs, as lines of an input log, take effect at their times."""
        self._time.play(lines)
