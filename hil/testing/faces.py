"""Faces of a bench for tests: ports, taps, axes, pins, boards and faults."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, Literal

from hil.core import Snapshot
from hil.core.axis_kind import ANGLE
from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.sim.inputs import Bytes, Pin, PulseTrain, Reset, ScriptEncoder, SetField
from hil.sim.load_limit import motor_notes
from hil.sim.segment_tap import Tap
from hil.sim.settable import setting_problem
from hil.sim.twin import Twin
from hil.sim.uart import DeviceUart
from hil.telemetry import Recording, check_signals
from hil.testing.face_inputs import carry_out, give, instead_of_field, instead_of_pyserial, set_field
from hil.testing.given import NoSuchName, checked_bytes
from hil.testing.known_names import FixedNames, KnownNames
from hil.vocab.address import no_input, no_part, pin_of
from hil.vocab.near_words import meant
from hil.vocab.time import SimTimeNs, ms
from hil.wire.serial_line import character_ends_ns, character_ns
from hil.wire.step_dir import Edges

Record = Callable[[str, tuple[str, ...], int], Recording]
"""Begins a recording of signals of the axis at an address at every multiple of an interval in nanoseconds."""

TX_ENABLE = "TxEn"
"""Output that switches a board's RS485 driver on, high while any of its ports sends; boards with two serial
interfaces have it."""


class PortFace(KnownNames):
    """Port of a device, seen by a client that reads everything at once."""

    _what = "a port of the kit"

    def __init__(self, runtime: BenchRuntime, device: Twin, uart: str) -> None:
        self._runtime = runtime
        self._device = device
        self._uart = device.uarts.short(uart)
        self._unread: list[tuple[SimTimeNs, bytes]] = []
        self.timeline: list[tuple[SimTimeNs, bytes]] = []
        """Pieces that the device has sent: (simulated time, bytes); with a baud, the time at which the first
        bit is on the line."""
        device.uarts[uart].listeners.append(self.sent)

    def _instead_of(self, name: str) -> str:
        return instead_of_pyserial(self._device.uarts.label(self._device.name, self._uart), name)

    def write(self, data: bytes, client_baud: int | None = None) -> None:
        """Send bytes to the device, now. ``client_baud``: as a client that chose that baud."""
        __tracebackhide__ = True
        give(self._runtime, self._device, Bytes(checked_bytes(data), client_baud, self._uart))

    def read(self) -> bytes:
        """Read everything the device has sent since the last call."""
        data = b"".join(data for _, data in self._unread)
        self._unread.clear()
        return data

    def read_timed(self) -> list[tuple[SimTimeNs, bytes]]:
        """Read as ``read``, with the time of each piece; pieces of one time are joined."""
        joined: list[tuple[SimTimeNs, bytes]] = []
        for at_ns, data in self._unread:
            if joined and joined[-1][0] == at_ns:
                joined[-1] = (at_ns, joined[-1][1] + data)
            else:
                joined.append((at_ns, data))
        self._unread.clear()
        return joined

    def read_complete(self) -> list[tuple[SimTimeNs, bytes]]:
        """Read as ``read_timed``, with the times at which the last bit of each piece has come."""
        baud = self._device.uarts[self._uart].baud
        return [
            (SimTimeNs(at_ns + (character_ns(len(data), baud) if baud else 0)), data)
            for at_ns, data in self.read_timed()
        ]

    def read_characters(self) -> list[tuple[SimTimeNs, bytes]]:
        """Read as ``read_complete``, each character by itself; of a port without a baud, each piece."""
        baud = self._device.uarts[self._uart].baud
        if not baud:
            return self.read_timed()
        return [
            (SimTimeNs(end_ns), bytes([byte]))
            for at_ns, data in self.read_timed()
            for end_ns, byte in zip(character_ends_ns(at_ns, len(data), baud), data, strict=True)
        ]

    @property
    def line_free_ns(self) -> SimTimeNs:
        """Time at which the last byte that the device has sent so far is on the line; without a baud 0."""
        return SimTimeNs(self._device.uarts[self._uart].tx.free_ns)

    def sent(self, at_ns: SimTimeNs, data: bytes) -> None:
        self._unread.append((at_ns, data))
        self.timeline.append((at_ns, data))


class TapFace:
    """Tap on a segment, seen by the program that has it open."""

    def __init__(self, runtime: BenchRuntime, tap: ClientTap) -> None:
        self._runtime = runtime
        self._tap = tap

    def write(self, data: bytes) -> None:
        """Send bytes on the wire, now, or when what was written before has gone out."""
        __tracebackhide__ = True
        give(self._runtime, self._tap, Bytes(checked_bytes(data)))

    def read(self) -> bytes:
        """Read what was complete on the wire since the last call."""
        return self._tap.drain(self._runtime.now_ns)

    def read_timed(self) -> list[tuple[SimTimeNs, int]]:
        """Read as ``read``: the time at which each character was complete, and the character."""
        assert isinstance(self._tap, Tap)
        heard = [(SimTimeNs(at_ns), byte) for at_ns, byte in self._tap.heard if at_ns <= self._runtime.now_ns]
        self.read()
        return heard

    @property
    def next_ns(self) -> SimTimeNs:
        """Time at which the next character is complete, of those that are on the wire already; ``FOREVER``:
        none is."""
        assert isinstance(self._tap, Tap)
        return self._tap.next_ns


class FaultFace:
    """Fault that was injected; as a context it is cleared at the end."""

    def __init__(self, number: int, runtime: BenchRuntime) -> None:
        self.number = number
        self._runtime = runtime

    @property
    def is_active(self) -> bool:
        """True until the fault has ended, also before it begins."""
        return self.number in self._runtime.faults.active

    def clear(self) -> None:
        """End the fault; nothing if it has ended."""
        if self.is_active:
            self._runtime.clear_fault(self.number)

    def __enter__(self) -> "FaultFace":
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()


class AxisFace(FixedNames):
    """Axis of a device: its state, and the world around its shaft."""

    _what = "an axis of the kit"

    def __init__(self, runtime: BenchRuntime, device: Twin, name: str, record: Record) -> None:
        self._runtime = runtime
        self._device = device
        self._axis = device.axes[name]
        self._part = device.axes.short(name)
        self._record = record

    def _instead_of(self, name: str) -> str:
        return instead_of_field(self._device.axes.label(self._device.name, self._part), self._axis, name)

    def snapshot(self) -> Snapshot:
        """State now; its fields are ``hil.core.FIELDS``."""
        return self._axis.snapshot()

    def record(self, *signals: str, interval_ms: float = 1.0) -> Recording:
        """Fill a recording from now on with samples at every multiple of ``interval_ms``; ``signals`` are
        fields of the axis, by default a servo's set-point, angle and effort, a stepper's speed and angles.

        Raises:
            ValueError: there is no such signal, or the interval is under 0.05 ms.
        """
        kind, address = self._axis.kind, self._device.axes.label(self._device.name, self._part)
        names = check_signals(signals or kind.default_signals, kind)
        return self._record(address, names, ms(interval_ms))

    def do(self, verb: str, *unnamed: object, **parameters: float | str) -> dict[str, Any]:
        """Carry out a verb of the board's table (``hil axis NAME`` lists it), now; answers its result, and
        ``effective_at_ns``. Typing, power and pins have faces of their own. Parameters have names.

        Raises:
            VerbRefused: it was not carried out; ``code`` and text say why.
        """
        __tracebackhide__ = True
        return carry_out(self._runtime, self._device, self._part, verb, parameters, unnamed)

    def zero(self) -> None:
        """Let the shaft's angle, ``position_deg``, be 0 from now on where the shaft is, as `hil zero` does.
        Nothing turns, and the board knows nothing of it.

        Raises:
            ValueError: a run has the axis, a stepper moves, or the masters of a CAN bus count by its angle.
        """
        if problem := setting_problem(self._runtime.faults, self._device, ANGLE, 0.0, self._part):
            raise ValueError(problem)
        give(self._runtime, self._device, SetField(ANGLE, 0.0), self._part)

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
        give(self._runtime, self._device, ScriptEncoder(timed, interp == "linear"), self._part)

    @property
    def load_torque_Nm(self) -> float:
        """External torque on the shaft with that of faults, positive towards larger counts. Set it at any
        time, without that of faults, up to ten times what the motor holds.

        Raises:
            ValueError: more, alone or with the ``shaft_load`` that pushes the same way; or not a number.
        """
        return self._axis.get("load_torque_Nm")

    @load_torque_Nm.setter
    def load_torque_Nm(self, torque_Nm: float) -> None:
        self.set("load_torque_Nm", torque_Nm)

    def set(self, field: str, value: float) -> None:
        """Set a field from outside, as `hil set` does: one of the world around the board, as a temperature
        of its own fields that is an input. Raises ValueError: it cannot be set, or not to this."""
        set_field(self._runtime, self._device, self._part, field, value)


class Outputs:
    """Edges of a device's outputs, kept from the bench's start; those of the board as a whole are with its
    first axis. ``axis``: the axis's name, empty if the board has none."""

    def __init__(self, runtime: BenchRuntime, device: Twin, axis: str) -> None:
        self._runtime = runtime
        at = device.axes.get(axis)
        self._axis = at if at and at.kind.outputs else None
        self._edges: list[tuple[SimTimeNs, str, int]] = []
        self._busy: list[tuple[SimTimeNs, SimTimeNs]] = []
        self.names = [*at.kind.outputs] if at else []
        if self._axis:
            self._axis.record_edges(True)
        if len(device.uarts) > 1 and axis == device.axes.first:
            self.names.append(TX_ENABLE)
            for uart in device.uarts.values():
                uart.listeners.append(partial(self._sends, uart))

    def edges(self, output: str) -> list[tuple[SimTimeNs, int]]:
        """Edges of an output so far: (simulated time, level)."""
        if output == TX_ENABLE:
            return self._transmissions()
        if self._axis:
            self._edges += [(SimTimeNs(at), name, level) for at, name, level in self._axis.take_edges()]
        return [(at_ns, level) for at_ns, name, level in self._edges if name == output]

    def _transmissions(self) -> list[tuple[SimTimeNs, int]]:
        edges: list[tuple[SimTimeNs, int]] = []
        for start_ns, end_ns in sorted(self._busy):
            if edges and start_ns <= edges[-1][0]:
                edges[-1] = (max(end_ns, edges[-1][0]), 0)
            else:
                edges += [(start_ns, 1), (end_ns, 0)]
        return [edge for edge in edges if edge[0] <= self._runtime.now_ns]

    def _sends(self, uart: DeviceUart, at_ns: SimTimeNs, data: bytes) -> None:
        if uart.baud:
            self._busy.append((at_ns, SimTimeNs(at_ns + character_ns(len(data), uart.baud))))


class PinFace:
    """Pin of an axis of a board: an input that can be driven, or an output, whose edges are all kept."""

    def __init__(self, runtime: BenchRuntime, device: Twin, axis: str, outputs: Outputs, name: str) -> None:
        self._runtime = runtime
        self._device = device
        self._part = device.axes.short(axis)
        self._outputs = outputs
        self._name = name.replace(" ", "_")
        self._inputs = device.axes[axis].pins if device.axes else {}
        pins = [*dict.fromkeys((*self._inputs, *outputs.names))]
        __tracebackhide__ = True
        if self._name not in pins:
            address = device.axes.label(device.name, axis)
            raise NoSuchName(f"{address} has no pin {name!r}; {meant(name, pins)}")

    def set(self, level: int) -> None:
        """Drive an input, now."""
        if self._name not in self._inputs:
            why = no_input(self._device.axes.label(self._device.name, self._part), self._name, self._inputs)
            raise ValueError("; ".join(why))
        give(self._runtime, self._device, Pin(self._name, level), self._part)

    def edges(self) -> list[tuple[SimTimeNs, int]]:
        """Edges of the output so far: (simulated time, level)."""
        return self._outputs.edges(self._name)


class DeviceFace:
    """Board from outside: what an operator's hand or a fault can do to it."""

    def __init__(self, runtime: BenchRuntime, device: Twin) -> None:
        self._runtime = runtime
        self._device = device
        self._outputs = {axis: Outputs(runtime, device, axis) for axis in device.axes or [""]}
        self._pins: dict[str, PinFace] = {}

    def do(self, verb: str, *unnamed: object, **parameters: float | str) -> dict[str, Any]:
        """Carry out a verb of the board, as an axis's face does; for a board without axes, too.

        Raises:
            VerbRefused: it was not carried out; ``code`` and text say why.
        """
        __tracebackhide__ = True
        return carry_out(self._runtime, self._device, "", verb, parameters, unnamed)

    @property
    def failed(self) -> str | None:
        """Reason why the device has stopped, or None."""
        return self._device.failed

    @property
    def notes(self) -> Mapping[str, str]:
        """Operator notes of its firmware, keyed by topic, and of its motors, as ``motor``; ``hil status``
        shows them."""
        motors = {name: axis for name, axis in self._device.axes.items() if axis.kind.has_motor}
        with self._runtime.present(self._device):
            said = {name: "; ".join(motor_notes(at.snapshot().as_dict(), at)) for name, at in motors.items()}
        own = {self._device.axes.label("motor", name): text for name, text in said.items() if text}
        return {**self._device.notes, **own}

    @property
    def nvm(self) -> Mapping[str, bytes]:
        """Sections of the board's non-volatile memory."""
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
        give(self._runtime, self._device, SetField(name, value))

    def pin(self, name: str, level: int | None = None) -> "PinFace":
        """Pin of the board, of another axis than the first as in ``elbow.step``. With a level, drives that
        input: of a Mechaduino D0 (direction), D1 (step), D2 (enable, active low), D3; of a SAC sync, Estop,
        RST (active low), EnA, EnB.

        Raises:
            KeyError: the board has no such pin.
        """
        __tracebackhide__ = True
        if name not in self._pins:
            axis, pin_name = pin_of(name)
            axis = axis or self._device.axes.first
            if axis not in self._outputs:
                raise NoSuchName(no_part(self._device.name, "axis", axis, self._device.axes))
            outputs = self._outputs[axis]
            self._pins[name] = PinFace(self._runtime, self._device, axis, outputs, pin_name)
        pin = self._pins[name]
        if level is not None:
            pin.set(level)
        return pin

    def drive(self, train: Sequence[Edges]) -> None:
        """Play a pulse train (``hil.wire.step_dir``) on the step/dir inputs from now on, instead of the one
        before; an empty one ends it.

        Raises:
            ValueError: the board has no such inputs, or there can be no such train.
        """
        give(self._runtime, self._device, PulseTrain(tuple(train)))

    def reset(self) -> None:
        """Switch the power off and on; the shaft stays where it is."""
        give(self._runtime, self._device, Reset())
