"""Facade of a core and its axes, with names instead of numbers."""

import math
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction

from hil.core._native import NativeCore
from hil.core.abi import Call, Event, Fault, Law, WalterCall
from hil.core.fields import INDEX, Snapshot
from hil.core.kinds import CLOCK_OUT, CLOCK_OUT_HZ, KINDS, AxisKind, speed_limit_rpm
from hil.vocab.axis_plan import FULL_PARAMETERS, AxisPlan
from hil.vocab.motion import CONTINUOUS_SLOT, MotionEntry, MotionSetup
from hil.vocab.path import PathPiece
from hil.vocab.pins import Pulses
from hil.vocab.time import SimTimeNs

SEED_MASK = (1 << 64) - 1
_RETARGET = Call.retarget
"""Looked up once: to find it in its class takes as long as the call, which each node of a line makes."""


def bucket_edges_ns(bucket: int) -> tuple[int, int]:
    """Bounds of a bucket of ``rt_stats()["wake_latency"]``, the upper one excluded. Eight an octave."""
    if bucket < 8:
        return bucket, bucket + 1
    low, octave = 8 + bucket % 8, bucket // 8 - 1
    return low << octave, (low + 1) << octave


def octaves(histogram: Sequence[int]) -> list[int]:
    """Sum the counts by powers of two: bucket b has values of [2^(b-1), 2^b) ns, bucket 0 has 0."""
    joined = [0] * (len(histogram) // 8 + 3)
    for bucket, count in enumerate(histogram):
        joined[bucket_edges_ns(bucket)[0].bit_length()] += count
    return joined


def entry_of(values: Mapping[str, int]) -> MotionEntry:
    """Make an entry from the numbers that the core holds."""
    flags = ("is_ccw", "is_linear", "is_sync", "is_pulses")
    return MotionEntry(**{name: bool(v) if name in flags else v for name, v in values.items()})  # type: ignore[arg-type]


class CoreAxis:
    """One axis of a core; what a firmware sees is ``hil.vocab.firmware.Axis``.

    Every call acts at the group's present time and needs the caller to own the group.
    """

    def __init__(self, native: NativeCore, axis: int, kind: AxisKind) -> None:
        self._native = native
        self.id = axis
        self.kind = kind
        self.pins = kind.inputs
        """Numbers of the axis's inputs by name."""
        self.nominal_supply_V = native.supply_V(axis)
        """Supply of the full plant as it was opened, 0 for the simple one."""
        self.holding_Nm = 0.0
        """Maximum torque of the motor, without that of its magnets."""
        self.speed_limit_rpm = math.inf
        """Maximum speed of the shaft, whatever drags it."""
        self.is_on_bus = False
        """True if the drive of a CAN bus's node counts by the axis's angle."""
        self.is_in_run = False
        """True while a run goes by the axis's angle."""
        self.set_load_Nm = 0.0
        """Load torque as it was set last, without that of faults."""

    @property
    def motion(self) -> "CoreMotion | None":
        """The same axis as a motion engine; None: it has none."""
        return None

    @property
    def joint(self) -> "CoreJoint | None":
        """The same axis as a joint of an arm; None: it is none."""
        return None

    @property
    def bank(self) -> "CoreBank | None":
        """The same as the pins of a microcontroller; None: it moves a motor."""
        return None

    def get(self, field: str) -> float:
        """A field by its name in ``hil.core.FIELDS``. Raises KeyError for another name."""
        return self._native.get(self.id, INDEX[field])

    def set(self, field: str, value: float) -> None:
        """Set a writable field. Raises KeyError, or AttributeError for one that is read-only."""
        self._native.set(self.id, INDEX[field], value)
        if field == "load_torque_Nm":
            self.set_load_Nm = value

    def output(self, theta_deg: float, effort: int) -> None:
        self._native.output(self.id, theta_deg, effort)

    def vref(self, vref1: int, vref2: int) -> None:
        self._native.vref(self.id, vref1, vref2)

    def loop(self, on: bool) -> None:
        self._native.loop(self.id, on)

    def spi(self, command: int) -> int:
        return self._native.spi(self.id, command)

    def table(self) -> bytes:
        return self._native.table(self.id)

    def write_table(self, packed: bytes) -> None:
        self._native.write_table(self.id, packed)

    def power_up(self) -> None:
        """Cold-start the control law and the driver; the shaft stays where it is."""
        self._native.power_up(self.id)

    def pin(self, name: str, level: int) -> None:
        """Drive an input; of a servo D0 (direction: high is towards smaller counts), D1 (step, rising
        edge), D2 (enable, active low), D3. Raises KeyError for another name."""
        self._native.pin(self.id, self.pins[name], level)

    def fault(self, what: str, value: float) -> None:
        """Begin a fault of ``hil.core.abi.Fault``, or end it (0).

        Raises:
            KeyError: there is no such fault.
            ValueError: this axis cannot have it.
        """
        self._native.fault(self.id, Fault[what], value)

    def supply_V(self) -> float:
        """Supply of the full plant now, 0 for the simple one."""
        return self._native.supply_V(self.id)

    def script_encoder(self, points: Sequence[tuple[int, int]], linear: bool) -> None:
        """Take encoder counts from ``(at_ns, raw)`` points instead of the shaft; none: the shaft again."""
        times = array("q", [at_ns for at_ns, _ in points])
        self._native.script_encoder(self.id, times, array("q", [raw for _, raw in points]), linear)

    def drive(self, rows: Sequence[tuple[int, str, int, int, int]]) -> None:
        """Drive the inputs by a signal source from now on; no rows: none. Rows are (at_ns from now, pin,
        level, steps, duration_ns) as in ``native/types.h``: hil_edges. Raises KeyError for another pin."""
        self._native.drive(
            self.id, [(at_ns, self.pins[pin], level, steps, ns) for at_ns, pin, level, steps, ns in rows]
        )

    def follow(self, path: Sequence[PathPiece], start_ns: int = 0) -> None:
        """Let the set-point follow a path from ``start_ns`` on, or from now, and keep its end; an empty path
        leaves it as it is.

        Raises:
            ValueError: a piece that is not finite, or too long.
        """
        self._native.follow(
            self.id, start_ns, [(p.duration_ns, p.r, p.per_s, p.per_s2, p.per_s3) for p in path]
        )

    def watch(self, slot: int, interval_ns: int | Fraction, capacity: int) -> None:
        """Sample the axis at the multiples of ``interval_ns``, rounded down to whole nanoseconds; 0 ends it.
        There are ``WATCHES`` slots, each with a grid of its own. Up to ``capacity`` samples wait to be taken,
        later ones are lost.

        Raises:
            ValueError: there is no such slot, or the interval is below 1 ns, or 146 years.
        """
        self._native.watch(self.id, slot, *interval_ns.as_integer_ratio(), capacity)

    def take_samples(self, slot: int) -> list[bytes]:
        """The samples since the last call, each in the binary layout (``hil.core.fields.OFFSETS``)."""
        return self._native.take_samples(self.id, slot)

    def lost_samples(self, slot: int) -> int:
        """Number of samples lost for lack of room, since ``watch``."""
        return self._native.lost_samples(self.id, slot)

    def snapshot(self) -> Snapshot:
        return Snapshot(self._native.snapshot(self.id), self.kind.fields)

    def published(self) -> Snapshot:
        """State as of the last release, in real time of the last 20 ms; from any thread, owner or not."""
        return Snapshot(self._native.published(self.id), self.kind.fields)

    def record_edges(self, on: bool, outputs: Iterable[str] | None = None) -> None:
        """Keep the edges of these outputs, or of all, from now on for ``take_edges``, or of none. For virtual
        time."""
        numbers = self.kind.outputs
        names = numbers if outputs is None else outputs
        self._native.record_edges(self.id, sum(1 << numbers[name] for name in names) if on else 0)

    def take_edges(self) -> list[tuple[int, str, int]]:
        """Edges since the last call: (at_ns, output, level)."""
        names = {number: name for name, number in self.kind.outputs.items()}
        return [(at_ns, names[pin], level) for at_ns, pin, level in self._native.take_edges(self.id)]


class CoreMotion(CoreAxis):
    """Axis of a stepper; a firmware sees it as ``hil.vocab.motion.Motion``."""

    @property
    def motion(self) -> "CoreMotion":
        return self

    def loop(self, on: bool) -> None:
        """End all motion where a control loop would be stopped: a stepper has none."""
        if not on:
            self.stop(None)

    def setup(self, setup: MotionSetup) -> None:
        self._native.motion_setup(self.id, {name: int(value) for name, value in vars(setup).items()})

    def entry(self, slot: int) -> MotionEntry:
        return entry_of(self._native.motion_read(self.id, slot))

    def write_entry(self, slot: int, entry: MotionEntry) -> None:
        self._native.motion_write(self.id, slot, {name: int(value) for name, value in vars(entry).items()})

    def enqueue(self, slot: int) -> None:
        self._do(Call.enqueue, slot)

    def run_once(self, slot: int) -> None:
        self._do(Call.once, slot)

    def run_continuous(self) -> None:
        self._do(Call.once, CONTINUOUS_SLOT)

    def retarget(self, rpm: int, cycle_us: int) -> None:
        self._native.motion_do(self.id, _RETARGET, rpm, cycle_us)

    def pulse(self, ccw: bool) -> None:
        self._do(Call.pulse, ccw)

    def stop(self, dec_hundredths: int | None) -> None:
        self._do(Call.stop, -1 if dec_hundredths is None else dec_hundredths)

    def next(self, is_graceful: bool) -> None:
        self._do(Call.next, is_graceful)

    def finish(self) -> None:
        self._do(Call.finish)

    def loop_start(self, slot: int) -> None:
        self._do(Call.loop_bounds, slot, 0)

    def loop_finish(self, slot: int) -> None:
        self._do(Call.loop_bounds, 0, slot)

    def loop_passes(self, passes: int) -> None:
        self._do(Call.loop_passes, passes)

    def loop_array(self, passes: int) -> None:
        self._do(Call.loop_array, passes)

    def xref(self) -> tuple[int, ...]:
        return self._native.motion_xref(self.id)

    def write_xref(self, index: int, slot: int) -> None:
        self._native.motion_xref_write(self.id, index, slot)

    def release_sync(self) -> None:
        self._do(Call.release_sync)

    def gap(self, on: bool) -> None:
        self._do(Call.gap, on)

    def encoder_mode(self, is_throttle: bool) -> None:
        self._do(Call.throttle, is_throttle)

    def report(self, on: bool) -> None:
        self._do(Call.report, on)

    def _do(self, call: int, x: int = 0, y: int = 0) -> None:
        self._native.motion_do(self.id, call, int(x), int(y))


class CoreJoint(CoreAxis):
    """Joint of an arm; a firmware sees it as ``hil.vocab.firmware.ArmJoint``."""

    @property
    def joint(self) -> "CoreJoint":
        return self

    def loop(self, on: bool) -> None:
        """Stop the main loop where a control loop would be stopped."""
        if not on:
            self.do("stop")

    def do(self, call: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> float:
        return self._native.walter_do(self.id, _WALTER_CALLS[call], x, y, z)


_WALTER_CALLS = {name: int(call) for name, call in WalterCall.__members__.items()}


class CoreBank(CoreAxis):
    """Pins of a microcontroller; a firmware sees them as ``hil.vocab.pins.Pins``."""

    @property
    def bank(self) -> "CoreBank":
        return self

    def loop(self, on: bool) -> None:
        """End all pulses where a control loop would be stopped."""
        if not on:
            self._native.bank_pulses(self.id, 0, [])

    def write(self, pin: str, level: int) -> None:
        self._native.bank_write(self.id, self.pins[pin], level)

    def let_go(self, pin: str) -> None:
        self._native.bank_write(self.id, self.pins[pin], -1)

    def read(self, pin: str) -> int:
        return self._native.bank_read(self.id, self.pins[pin])

    def pulse(self, pin: str, rows: Sequence[Pulses]) -> None:
        self._native.bank_pulses(self.id, self.pins[pin], [(r.number, r.period_ns, r.high_ns) for r in rows])

    @property
    def pulses_left(self) -> int:
        return int(self.get("pulses_left"))


_FACES = {
    Law.mechaduino: CoreAxis,
    Law.sac: CoreMotion,
    Law.walter: CoreJoint,
    Law.a3967: CoreAxis,
    Law.pin_bank: CoreBank,
}
_NO_MOTOR = dict.fromkeys(("inertia_kg_m2", "torque_constant_Nm_per_A", "rotor_teeth"), 1.0) | dict.fromkeys(
    ("viscous_Nm_s_per_rad", "start_deg", "load_torque_Nm"), 0.0
)
"""Numbers that the native core wants where nothing turns."""


class Core:
    """Simulated time and axes of one bench. See ``native/hil_core.h``."""

    def __init__(self, max_axes: int) -> None:
        self.native = NativeCore(max_axes)
        self.event_fd = self.native.event_fd

    def open_axis(self, group: int, plan: AxisPlan) -> CoreAxis:
        """Open a cold-started axis.

        Raises:
            ValueError: such a motor is too stiff to be integrated.
        """
        kind = KINDS[plan.law]
        motor = {name: plan.parameters[name] for name in kind.parameters} or _NO_MOTOR
        full = None
        if plan.plant == "full":
            full = {name: plan.parameters[name] for name in FULL_PARAMETERS}
        axis = self.native.axis_open(group, kind.law, motor, full, asdict(plan.load), plan.seed & SEED_MASK)
        made = _FACES[kind.law](self.native, axis, kind)
        made.holding_Nm = kind.holding_Nm(plan.parameters)
        made.speed_limit_rpm = speed_limit_rpm(plan.parameters)
        made.set_load_Nm = motor["load_torque_Nm"]
        return made

    def wire(self, output: tuple[CoreAxis, str], to: tuple[CoreAxis, str]) -> None:
        """Join an output to an input of the same group, each an axis and its pin by name.

        Raises:
            MemoryError: the output's axis has 16 wires already.
        """
        (from_axis, name), (to_axis, input_name) = output, to
        if name == CLOCK_OUT:
            to_axis.set("clock_Hz", CLOCK_OUT_HZ)
            return
        self.native.wire(from_axis.id, from_axis.kind.outputs[name], to_axis.id, to_axis.pins[input_name])

    def take_events(self, group: int) -> list[tuple[SimTimeNs, int, str, float]]:
        """Events from interrupts of this group since the last call, in time's order: the time, the axis's
        number, the kind's name, the value."""
        return [
            (SimTimeNs(at_ns), axis, Event(kind).name, value)
            for at_ns, axis, kind, value in self.native.take_events(group)
        ]
