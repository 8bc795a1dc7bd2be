"""A bench in memory, on the virtual clock."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

from hil.compose import bench_runtime, find_catalogue, start_sections
from hil.compose.replay import MemoryOptions
from hil.config import BenchConfig, from_dict, parse
from hil.core import CoreMotion, Snapshot
from hil.core.core import OUTPUTS
from hil.session.bench import BenchRuntime
from hil.session.device import Device
from hil.session.inputs import Bytes, Drive, Input, Pin, Reset, ScriptEncoder, SetField
from hil.session.tap import Tap
from hil.telemetry import DEFAULT_SIGNALS, Recording, Sampler, Subscription, check_signals
from hil.vocab.dialogue import Dialogue, Heard, Listen, Result, Send
from hil.vocab.faults import fault_refusal
from hil.vocab.firmware import MAIN
from hil.vocab.segment import Segment
from hil.vocab.time import NS_PER_MS, SimTimeNs, ms
from hil.wire.serial_line import character_ns
from hil.wire.step_dir import Edges

TX_ENABLE = "TxEn"
"""The output that switches a board's RS485 driver on; boards with two serial interfaces have it."""
LISTEN_SLICE_NS = 10 * NS_PER_MS
"""How far a dialogue that listens lets time pass between two looks at the port."""
MOST_LOAD_NM = 1e6
"""As the configuration has it: with much more the shaft's numbers would run out of range."""


class MemoryStore:
    """Memory that is written at once: flash takes no time in the reference data."""

    def commit(self, device: Device, sections: Mapping[str, bytes]) -> None:
        device.commit_done(True)


class PortFace:
    """A device's port, seen by a client that reads everything at once."""

    def __init__(self, bench: "Bench", device: Device, uart: str) -> None:
        self._bench = bench
        self._device = device
        self._uart = uart
        self._unread: list[tuple[SimTimeNs, bytes]] = []
        self.timeline: list[tuple[SimTimeNs, bytes]] = []
        """All that the device has sent: (simulated time, bytes); with a baud, the time at which the
        first bit is on the line."""

    def write(self, data: bytes, client_baud: int | None = None) -> None:
        """Send bytes to the device, now. ``client_baud``: as a client that chose that baud."""
        self._bench.give(self._device, Bytes(bytes(data), client_baud, self._uart))

    def read(self) -> bytes:
        """Everything the device has sent since the last call."""
        data = b"".join(data for _, data in self._unread)
        self._unread.clear()
        return data

    def read_timed(self) -> list[tuple[SimTimeNs, bytes]]:
        """As ``read``, with the time of each piece; pieces of one time are joined."""
        joined: list[tuple[SimTimeNs, bytes]] = []
        for at_ns, data in self._unread:
            if joined and joined[-1][0] == at_ns:
                joined[-1] = (at_ns, joined[-1][1] + data)
            else:
                joined.append((at_ns, data))
        self._unread.clear()
        return joined

    def read_complete(self) -> list[tuple[SimTimeNs, bytes]]:
        """As ``read_timed``, with the times at which the last bit of each piece has come."""
        baud = self._device.uarts[self._uart].baud
        return [
            (SimTimeNs(at_ns + (character_ns(len(data), baud) if baud else 0)), data)
            for at_ns, data in self.read_timed()
        ]

    @property
    def line_free_ns(self) -> SimTimeNs:
        """When the last byte that the device has sent so far is on the line; without a baud 0."""
        return SimTimeNs(self._device.uarts[self._uart].tx_free_ns)

    def sent(self, at_ns: SimTimeNs, data: bytes) -> None:
        """The device sends; called by the bench."""
        self._unread.append((at_ns, data))
        self.timeline.append((at_ns, data))


class TapFace:
    """A tap on a segment, seen by the program that has it open."""

    def __init__(self, bench: "Bench", tap: Tap) -> None:
        self._bench = bench
        self._tap = tap

    def write(self, data: bytes) -> None:
        """Send bytes on the wire, now, or when what was written before has gone out."""
        self._bench.give_tap(self._tap, Bytes(bytes(data)))

    def read(self) -> bytes:
        """What was complete on the wire since the last call."""
        return self._tap.take(self._bench.now_ns)

    def read_timed(self) -> list[tuple[SimTimeNs, int]]:
        """As ``read``: when each character was complete, and the character."""
        heard = [(SimTimeNs(at_ns), byte) for at_ns, byte in self._tap.heard if at_ns <= self._bench.now_ns]
        self.read()
        return heard


class FaultFace:
    """A fault that was injected; as a context it is cleared at the end."""

    def __init__(self, number: int, runtime: BenchRuntime) -> None:
        self.number = number
        self._runtime = runtime

    @property
    def is_active(self) -> bool:
        """Whether it has not ended yet; also true before it begins."""
        return self.number in self._runtime.faults.active

    def clear(self) -> None:
        """Take it away; nothing if it has ended."""
        if self.is_active:
            self._runtime.clear_fault(self.number)

    def __enter__(self) -> "FaultFace":
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()


class AxisFace:
    """A device's axis: its state, and the world around its shaft."""

    def __init__(self, bench: "Bench", device: Device) -> None:
        self._bench = bench
        self._device = device

    def snapshot(self) -> Snapshot:
        """The state now; its fields are ``hil.core.FIELDS``."""
        return self._device.axis.snapshot()

    def record(self, *signals: str, interval_ms: float = 1.0) -> Recording:
        """Fill a recording from now on with samples at every multiple of ``interval_ms``; ``signals`` are
        fields of the axis, by default a servo's set-point, angle and effort, a stepper's speed and angles.

        Raises:
            ValueError: there is no such signal, or the interval is under 0.05 ms.
        """
        kind = self._device.axis.kind
        names = check_signals(signals or DEFAULT_SIGNALS[kind], kind)
        return self._bench.record(self._device, names, ms(interval_ms))

    def script_encoder(
        self, points: Sequence[tuple[float, float]], interp: Literal["hold", "linear"] = "hold"
    ) -> None:
        """Take the encoder away from the shaft: counts from ``(t_ms, raw)`` points, ascending times
        since the bench's start. Between points the count is held or interpolated and rounded down; it is
        taken modulo 16,384, and held before the first and after the last. No points: the shaft again.

        Raises:
            ValueError: times that do not ascend, or another ``interp``.
        """
        if interp not in ("hold", "linear"):
            raise ValueError(f'interp is "hold" or "linear", not {interp!r}')
        timed = tuple((int(ms(t_ms)), int(raw // 1)) for t_ms, raw in points)
        if any(later[0] <= earlier[0] for earlier, later in pairwise(timed)):
            raise ValueError("times of the encoder's script have to ascend")
        self._bench.give(self._device, ScriptEncoder(timed, interp == "linear"))

    @property
    def load_torque_Nm(self) -> float:
        """External torque on the shaft, positive towards larger counts; set it at any time, up to 1e6 Nm.

        Raises:
            ValueError: more, or not a number.
        """
        return self._device.axis.get("load_torque_Nm")

    @load_torque_Nm.setter
    def load_torque_Nm(self, torque_Nm: float) -> None:
        if not abs(torque_Nm) <= MOST_LOAD_NM:
            raise ValueError(f"a load of {torque_Nm} Nm; write at most {MOST_LOAD_NM:g} either way")
        self._bench.give(self._device, SetField("load_torque_Nm", float(torque_Nm)))


class PinFace:
    """One pin of a board: an input that can be driven, or an output whose edges are kept from the bench's
    start."""

    def __init__(self, bench: "Bench", device: Device, name: str) -> None:
        self._bench = bench
        self._device = device
        self._name = name.replace(" ", "_")
        outputs = [*OUTPUTS] if isinstance(device.axis, CoreMotion) else []
        outputs += [TX_ENABLE] if device.network else []
        if self._name not in device.axis.pins and self._name not in outputs:
            raise KeyError(
                f"{device.name} has no pin {name!r}; it has {', '.join([*device.axis.pins, *outputs])}"
            )

    def set(self, level: int) -> None:
        """Drive an input, now."""
        if self._name not in self._device.axis.pins:
            raise ValueError(f"{self._name} of {self._device.name} is an output")
        self._bench.give(self._device, Pin(self._name, level))

    def edges(self) -> list[tuple[SimTimeNs, int]]:
        """All edges of an output so far: (simulated time, level)."""
        if self._name == TX_ENABLE:
            return self._bench.transmissions(self._device)
        return [
            (at_ns, level) for at_ns, name, level in self._bench.edges(self._device) if name == self._name
        ]


class DeviceFace:
    """The board itself, from outside: what an operator's hand or a fault can do to it."""

    def __init__(self, bench: "Bench", device: Device) -> None:
        self._bench = bench
        self._device = device
        self._pins: dict[str, PinFace] = {}

    @property
    def failed(self) -> str | None:
        """Why the device has stopped, or None."""
        return self._device.failed

    @property
    def notes(self) -> Mapping[str, str]:
        """What its firmware has an operator know, by what it is about; ``hil status`` shows it."""
        return self._device.notes

    @property
    def nvm(self) -> Mapping[str, bytes]:
        """Sections of its non-volatile memory."""
        return self._device.nvm

    def set_register(self, name: Literal["diaagc", "errfl"], value: int) -> None:
        """Set a register of the encoder, 0 to 0x7FFF (bit 14 is the frame's error flag).

        Raises:
            ValueError: there is no such register, or the value does not fit.
        """
        if name not in ("diaagc", "errfl"):
            raise ValueError(f'registers are "diaagc" and "errfl", not {name!r}')
        if not 0 <= value <= 0x7FFF:
            raise ValueError(f"{value:#x} does not fit a register's 15 bits")
        self._bench.give(self._device, SetField(name, value))

    def pin(self, name: str, level: int | None = None) -> "PinFace":
        """A pin of the board. With a level, drives that input: of a Mechaduino D0 (direction), D1 (step), D2
        (enable, active low), D3; of a SAC sync, Estop, RST (active low), EnA, EnB.

        Raises:
            KeyError: the board has no such pin.
        """
        pin = self._pins.setdefault(name, PinFace(self._bench, self._device, name))
        if level is not None:
            pin.set(level)
        return pin

    def drive(self, train: Sequence[Edges]) -> None:
        """Play a pulse train (``hil.wire.step_dir``) on the step/dir inputs from now on, instead of the one
        before; an empty one ends it."""
        self._bench.give(self._device, Drive(tuple(train)))

    def reset(self) -> None:
        """Switch the power off and on; the shaft stays where it is."""
        self._bench.give(self._device, Reset())


class Bench:
    """All devices of a configuration, on the virtual clock, with memory in place of ports and files.

    ``config`` is a path, YAML text or a dict. Whatever kind of port it names, the kit's own stands in.
    Nothing runs until ``run``; the same configuration, seed and calls give the same bytes.

    Raises:
        ConfigError: with every problem of the configuration.
        ValueError: a device is a real board.
    """

    def __init__(self, config: str | Path | Mapping[str, Any], seed: int = 0) -> None:
        self.config, folder = read_config(config)
        if self.config.real:
            names = ", ".join(self.config.real)
            raise ValueError(f"real boards (at:) know no simulated time: {names}; leave them out")
        self.seed = seed
        self._now_ns = SimTimeNs(0)
        memories = {name: start_sections(device, {}, folder) for name, device in self.config.devices.items()}
        self._runtime = bench_runtime(
            self.config, find_catalogue({"memory": MemoryOptions}), memories, MemoryStore()
        )
        devices = self._runtime.devices
        self._ports = {
            (name, uart): PortFace(self, device, uart)
            for name, device in devices.items()
            for uart in device.uarts
        }
        self._axes = {name: AxisFace(self, device) for name, device in devices.items()}
        self._devices = {name: DeviceFace(self, device) for name, device in devices.items()}
        self._taps = {name: TapFace(self, tap) for name, tap in self._runtime.taps.items()}
        self._sampler = Sampler(self._runtime)
        self._edges: dict[str, list[tuple[SimTimeNs, str, int]]] = {name: [] for name in devices}
        for device in devices.values():
            if isinstance(device.axis, CoreMotion):
                device.axis.record_edges(True)
        for fault in self.config.faults:
            self.fault(fault.fault, fault.target, **(fault.model_extra or {}))
        self._recordings: list[tuple[Subscription, Recording]] = []
        self._busy: dict[str, list[tuple[SimTimeNs, SimTimeNs]]] = {name: [] for name in devices}
        self._runtime.listeners.append(self._sent)

    @property
    def now_ns(self) -> SimTimeNs:
        """Simulated time since the bench's start."""
        return self._now_ns

    def run(self, ms: float) -> None:
        """Let ``ms`` milliseconds of simulated time pass."""
        self._advance(SimTimeNs(self._now_ns + round(ms * NS_PER_MS)))

    def run_until(self, ms: float) -> None:
        """Run until the simulated time is ``ms`` milliseconds; never back."""
        self._advance(SimTimeNs(round(ms * NS_PER_MS)))

    def port(self, name: str, uart: str = MAIN) -> PortFace:
        """The port of a device: at its first serial interface, or at ``"network"``."""
        return self._ports[name, uart]

    def tap(self, name: str) -> TapFace:
        """A tap, as in ``bus0.master``."""
        return self._taps[name]

    def fault(self, kind: str, target: str, **parameters: float | str) -> FaultFace:
        """Make something go wrong (``hil.vocab.faults`` has the kinds), until it is cleared.

        Raises:
            FaultRefused: there is no such kind or target, or a parameter does not do.
        """
        number = self._runtime.inject(fault_refusal(kind, target, parameters))
        return FaultFace(number, self._runtime)

    def segment(self, name: str) -> Segment:
        """A segment, with its counters settled to now."""
        segment = self._runtime.segments[name]
        segment.settle(self._now_ns)
        return segment

    def axis(self, name: str) -> AxisFace:
        """The axis of a device."""
        return self._axes[name]

    def device(self, name: str) -> DeviceFace:
        """A device."""
        return self._devices[name]

    def give_tap(self, tap: Tap, given: Input) -> None:
        """What ``TapFace.write`` calls."""
        self._runtime.give_tap(tap, given)

    def give(self, device: Device, given: Input) -> None:
        """An input takes effect now; what the faces call."""
        self._runtime.give(device, given)

    def talk(self, name: str, dialogue: Dialogue[Result], uart: str = MAIN) -> Result:
        """Carry out a dialogue at a device's port, in simulated time; its result."""
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
                    end_ns = self._now_ns + step.timeout_ns
                    while (not heard or heard[0][0] > self._now_ns) and self._now_ns < end_ns:
                        next_ns = heard[0][0] if heard else self._now_ns + LISTEN_SLICE_NS
                        self._advance(SimTimeNs(min(next_ns, end_ns)))
                        heard += port.read_complete()
                    is_there = heard and heard[0][0] <= self._now_ns
                    answer = Heard(*heard.pop(0)) if is_there else Heard(self._now_ns, b"")
        except StopIteration as done:
            result: Result = done.value
            return result

    def close(self) -> None:
        """Free the bench's memory now instead of with its last reference."""
        self._runtime.stop()

    def __enter__(self) -> "Bench":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def edges(self, device: Device) -> list[tuple[SimTimeNs, str, int]]:
        """What ``PinFace.edges`` calls: (simulated time, output, level)."""
        kept = self._edges[device.name]
        assert isinstance(device.axis, CoreMotion)
        kept += [(SimTimeNs(at_ns), name, level) for at_ns, name, level in device.axis.take_edges()]
        return kept

    def transmissions(self, device: Device) -> list[tuple[SimTimeNs, int]]:
        """What ``PinFace.edges`` calls for TxEn: high while any of the device's ports sends."""
        edges: list[tuple[SimTimeNs, int]] = []
        for start_ns, end_ns in sorted(self._busy[device.name]):
            if edges and start_ns <= edges[-1][0]:
                edges[-1] = (max(end_ns, edges[-1][0]), 0)
            else:
                edges += [(start_ns, 1), (end_ns, 0)]
        return [edge for edge in edges if edge[0] <= self._now_ns]

    def _sent(self, device: Device, uart: str, at_ns: SimTimeNs, data: bytes) -> None:
        self._ports[device.name, uart].sent(at_ns, data)
        if device.network and (baud := device.uarts[uart].baud):
            end_ns = SimTimeNs(at_ns + character_ns(len(data), baud))
            self._busy[device.name].append((at_ns, end_ns))

    def record(self, device: Device, signals: tuple[str, ...], interval_ns: int) -> Recording:
        """What ``AxisFace.record`` calls."""
        subscription = self._sampler.subscribe(device.name, signals, interval_ns)
        recording = Recording(signals)
        self._recordings.append((subscription, recording))
        return recording

    def _advance(self, until_ns: SimTimeNs) -> None:
        while (slice_ns := self._sampler.period_ns) and self._now_ns + slice_ns < until_ns:
            self._advance_to(SimTimeNs(self._now_ns + slice_ns))
        self._advance_to(until_ns)

    def _advance_to(self, until_ns: SimTimeNs) -> None:
        self._runtime.advance(until_ns)
        self._now_ns = max(self._now_ns, until_ns)
        if self._recordings:
            self._sampler.poll()
        for subscription, recording in self._recordings:
            recording.rows += subscription.take()
            recording.lost = subscription.lost


def read_config(config: str | Path | Mapping[str, Any]) -> tuple[BenchConfig, Path]:
    """A configuration from a path, YAML text or a dict, and the folder its files are looked up from.

    Raises:
        ConfigError: with every problem.
        FileNotFoundError: there is no such file.
    """
    catalogue = find_catalogue({"memory": MemoryOptions})
    if isinstance(config, Mapping):
        return from_dict(config, catalogue), Path()
    if isinstance(config, str) and ("\n" in config or ":" in config):
        return parse(config, "<text>", catalogue), Path()
    path = Path(config)
    return parse(path.read_text(), str(path), catalogue), path.parent
