"""Levels of pins and lines of a recorded run: each edge at its exact time.

A line is drawn with its bits: a board's UART as it sends and is sent to, a wire as all hear it. A port on
USB has no line: bytes take no time there. They can be drawn as a line of some speed would have them.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, cast

from hil.core import CoreAxis
from hil.recorded.recorded_run import RecordedRun
from hil.sim.bench import BenchRuntime
from hil.sim.input_log import logged_port
from hil.sim.inputs import Bytes
from hil.sim.twin import Twin
from hil.sim.uart import DeviceUart
from hil.vocab.line_format import LineFormat
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.character_edges import character_edges
from hil.wire.serial_line import character_ns

UNKNOWN = -1
"""Level that nobody knows."""
Edge = tuple[int, str, int]
"""Time, name of the signal, level."""
SLICE_NS = 100 * NS_PER_MS
"""Simulated time between two looks: pulses at 200 kHz are 40,000 edges then."""
LATE_NS = 500 * NS_PER_MS
"""Time by which an edge may be told late at the most: a frame of CAN at 10 kbit/s takes 16 ms."""


class DrawnWire(Protocol):
    """Wire that can be drawn: its level at each time, 1 idle or recessive, 0, or -1 where nobody knows it."""

    def record_levels(self, on: bool) -> None:
        """Keep what is on the wire from now on for ``take_levels``, or nothing. For virtual time."""

    def take_levels(self, until_ns: int) -> list[tuple[int, int]]:
        """Edges since the last call that are decided, up to a time that has come: (at_ns, level). Some may
        come later than others that are later, by the length of what is on the wire at the most."""


class SignalSource(Protocol):
    """Source of some signals."""

    names: list[str]

    def listen(self) -> None:
        """Listen from the run's present on, a little before the window: what is on a line as that begins is
        drawn from there."""

    def begin(self) -> dict[str, int]:
        """Begin at the run's present; answers the levels then, as far as edges do not tell them."""

    def edges(self, until_ns: int) -> Iterable[Edge]:
        """Take what is known by now of the edges since the last call."""

    def exchange(self) -> dict[str, int]:
        """Go on with what a reload has put in its place; answers the levels then, of all that is new."""


class PinSource:
    """Inputs and outputs of an axis. Pins that can be both are one signal each."""

    def __init__(self, run: RecordedRun, address: str, axis: CoreAxis) -> None:
        self._run, self._address = run, address
        self._axis, kind = axis, axis.kind
        self._has_inputs = kind.inputs != kind.outputs
        # Of several names of one pin the last says what it is for: D1 is step.
        self._inputs = {number: f"{address}.{name}" for name, number in kind.inputs.items()}
        self._outputs = {name: f"{address}.{name}" for name in kind.outputs}
        self.names = [*(self._inputs.values() if self._has_inputs else ()), *self._outputs.values()]

    def listen(self) -> None:
        """Do nothing: levels are asked for as the window begins."""

    def begin(self) -> dict[str, int]:
        axis, levels = self._axis, dict[str, int]()
        if self._has_inputs:
            for pin, number in axis.pins.items():
                told = axis.kind.level_field(pin)
                levels[self._inputs[number]] = int(axis.get(told)) if told else UNKNOWN
            axis.record_input_edges(True)
        if self._outputs:
            axis.record_edges(True)
            levels |= {self._outputs[name]: level for name, level in axis.output_levels().items()}
        return levels

    def edges(self, until_ns: int) -> Iterator[Edge]:
        if self._axis is not self._present:  # it ended with a reload
            return
        if self._has_inputs:
            for at_ns, number, level in self._axis.take_input_edges():
                yield at_ns, self._inputs[number], level
        if self._outputs:
            for at_ns, name, level in self._axis.take_edges():
                yield at_ns, self._outputs[name], level

    @property
    def _present(self) -> CoreAxis | None:
        of = self._run.runtime.parts.axes.get(self._address)
        return of[0].axes[of[1]] if of else None

    def exchange(self) -> dict[str, int]:
        axis = self._present
        if axis is self._axis:
            return {}
        if axis is None or axis.kind is not self._axis.kind:
            return dict.fromkeys(self.names, UNKNOWN)
        self._axis = axis
        return self.begin()


class UartSource:
    """Lines of a board's UART, ``rx`` towards the board."""

    def __init__(self, run: RecordedRun, name: str, device: str, part: str) -> None:
        self.names = [f"{name}.rx", f"{name}.tx"]
        self._run, self._device, self._part = run, device, part
        self._uart = run.runtime.devices[device].uarts[part]
        self._edges: list[Edge] = []

    def listen(self) -> None:
        self._uart.rx_watchers.append(self._received)
        self._uart.listeners.append(self._sent)

    def exchange(self) -> dict[str, int]:
        device = self._run.runtime.devices.get(self._device)
        uart = device.uarts.get(self._part) if device else None
        if uart is None or uart is self._uart:
            return {}
        self._uart = uart
        self.listen()
        return self.begin()

    def _received(self, start_ns: SimTimeNs, data: bytes, baud: int, line_format: LineFormat) -> None:
        self._draw(self.names[0], start_ns, data, baud, line_format)

    def _sent(self, at_ns: SimTimeNs, data: bytes) -> None:
        if self._uart.baud:
            self._draw(self.names[1], at_ns, data, self._uart.baud, self._uart.sent_format)

    def _draw(self, name: str, start_ns: int, data: bytes, baud: int, line_format: LineFormat) -> None:
        edges = character_edges(start_ns, data, baud, line_format)
        self._edges += [(at_ns, name, level) for at_ns, level in edges]

    def begin(self) -> dict[str, int]:
        return dict.fromkeys(self.names, 1)

    def edges(self, until_ns: int) -> list[Edge]:
        taken, self._edges = self._edges, []
        return taken


class UsbSource:
    """Bytes of a port on USB, drawn as a line of this speed would have them, one behind the other."""

    def __init__(self, run: RecordedRun, name: str, device: Twin, uart: str, baud: int) -> None:
        self.names = [f"{name}.rx", f"{name}.tx"]
        self._run, self._device, self._part, self._baud = run, device, uart, baud
        self._edges: list[Edge] = []
        self._free_ns = dict.fromkeys(self.names, 0)
        self._inputs: Iterator[tuple[SimTimeNs, bytes]] = iter(())
        self._next: tuple[SimTimeNs, bytes] | None = None

    def listen(self) -> None:
        port, since_ns = logged_port(self._device, self._part), self._run.now_ns
        self._inputs = (
            (each.at_ns, each.input.data)
            for each in self._run.log.inputs
            if each.device == self._device.name
            and isinstance(each.input, Bytes)
            and each.input.port == port
            and each.at_ns >= since_ns
        )
        self._next = next(self._inputs, None)
        self._run.listeners.append(self._sent)

    def _sent(self, device: Twin, part: str, at_ns: int, data: bytes) -> None:
        if (device.name, part) == (self._device.name, self._part):
            self._draw(self.names[1], at_ns, data)

    def _draw(self, name: str, at_ns: int, data: bytes) -> None:
        start_ns = max(at_ns, self._free_ns[name])
        self._free_ns[name] = start_ns + character_ns(len(data), self._baud)
        edges = character_edges(start_ns, data, self._baud)
        self._edges += [(at_ns, name, level) for at_ns, level in edges]

    def begin(self) -> dict[str, int]:
        return dict.fromkeys(self.names, 1)

    def edges(self, until_ns: int) -> list[Edge]:
        while self._next and self._next[0] <= until_ns:
            self._draw(self.names[0], *self._next)
            self._next = next(self._inputs, None)
        taken, self._edges = self._edges, []
        return taken

    def exchange(self) -> dict[str, int]:
        return {}


class WireSource:
    """Level of a wire. What is on it does not end with a reload."""

    def __init__(self, name: str, wire: DrawnWire) -> None:
        self.names = [name]
        self._wire = wire

    def listen(self) -> None:
        self._wire.record_levels(True)

    def begin(self) -> dict[str, int]:
        return {self.names[0]: 1}

    def edges(self, until_ns: int) -> Iterator[Edge]:
        name = self.names[0]
        return ((at_ns, name, level) for at_ns, level in self._wire.take_levels(until_ns))

    def exchange(self) -> dict[str, int]:
        return {}


def drawn_wires(runtime: BenchRuntime) -> dict[str, Any]:
    """Wires whose bus tells its levels."""
    return {name: wire for name, wire in runtime.wires.items() if hasattr(wire, "take_levels")}


def usb_ports(runtime: BenchRuntime) -> list[str]:
    """Ports at which bytes take no time, of boards that are on no wire there."""
    return [name for name, _, uart in _uarts(runtime) if not uart.baud]


def _uarts(runtime: BenchRuntime) -> Iterator[tuple[str, tuple[Twin, str], DeviceUart]]:
    for name, device in runtime.devices.items():
        for part, uart in device.uarts.items():
            if uart.station is None:
                yield device.uarts.label(name, part), (device, part), uart


def signal_sources(run: RecordedRun, usb_baud: int = 0) -> list[SignalSource]:
    """Make the sources of all signals of a run. ``usb_baud``: speed at which ports
    on USB are drawn; 0: they are not."""
    runtime = run.runtime
    sources: list[SignalSource] = []
    for address, (device, name) in runtime.parts.axes.items():
        sources.append(PinSource(run, address, device.axes[name]))
    for port, (device, part), uart in _uarts(runtime):
        if uart.baud:
            sources.append(UartSource(run, port, device.name, part))
        elif usb_baud:
            sources.append(UsbSource(run, port, device, part, usb_baud))
    sources += [WireSource(name, cast(DrawnWire, wire)) for name, wire in drawn_wires(runtime).items()]
    return [source for source in sources if source.names]


class SignalCourse:
    """Signals of a run from a time to another, in the order of time."""

    def __init__(
        self,
        run: RecordedRun,
        sources: Iterable[SignalSource],
        names: Iterable[str],
        from_ns: SimTimeNs,
        to_ns: SimTimeNs,
    ) -> None:
        self._run, self._from_ns, self._to_ns = run, from_ns, to_ns
        self._wanted = {*names}
        self._sources = [each for each in sources if self._wanted & {*each.names}]
        if from_ns > LATE_NS:  # at time 0 boards have not run yet, and may send something then
            run.run_until(SimTimeNs(from_ns - LATE_NS))
        for source in self._sources:
            source.listen()
        run.run_until(from_ns)
        for source in self._sources:
            source.exchange()
        self.levels = {name: level for each in self._sources for name, level in each.begin().items()}
        """Levels at the beginning."""
        self._waiting = [edge for each in self._sources for edge in each.edges(from_ns)]
        for at_ns, name, level in sorted(self._waiting):
            if at_ns <= from_ns:
                self.levels[name] = level
        self.levels = {name: self.levels[name] for name in names}

    def edges(self, told: Callable[[int], object] = lambda now_ns: None) -> Iterator[Edge]:
        """Go on to the end; what changes nothing is left out. ``told``: called with the time reached."""
        levels, now_ns = self.levels, self._run.now_ns
        waiting = [edge for edge in self._waiting if edge[0] > self._from_ns]
        while now_ns < self._to_ns:
            until_ns, reload_ns = SimTimeNs(min(now_ns + SLICE_NS, self._to_ns)), self._run.next_reload_ns()
            is_reload = now_ns < reload_ns <= until_ns
            now_ns = SimTimeNs(reload_ns - 1 if is_reload else until_ns)
            self._run.run_until(now_ns)
            waiting += [edge for source in self._sources for edge in source.edges(now_ns)]
            if is_reload:
                now_ns = reload_ns
                self._run.run_until(now_ns)
                for source in self._sources:
                    waiting += [(now_ns, name, level) for name, level in source.exchange().items()]
            decided_ns = now_ns if now_ns == self._to_ns else now_ns - LATE_NS
            waiting.sort(key=_time)  # stable: edges of one time stay in the order in which they came
            end = next((at for at, edge in enumerate(waiting) if edge[0] > decided_ns), len(waiting))
            for edge in waiting[:end]:
                _, name, level = edge
                if name in levels and levels[name] != level and edge[0] > self._from_ns:
                    levels[name] = level
                    yield edge
            del waiting[:end]
            told(now_ns)


def _time(edge: Edge) -> int:
    return edge[0]
