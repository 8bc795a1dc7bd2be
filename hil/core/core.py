"""A core and its axes, with names instead of numbers."""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Literal

from hil.core._native import NativeCore
from hil.core.fields import INDEX, Snapshot
from hil.vocab.firmware import CoreEvent
from hil.vocab.time import SimTimeNs

EVENT_KINDS = {1: "step_response", 2: "enable"}
"""Names of ``hil_event_kind`` in ``native/hil_core.h``."""

PINS = {"D0": 0, "D1": 1, "D2": 2, "D3": 3, "dir": 0, "step": 1, "enable": 2}
"""Inputs of an axis: the board's names, and what the step/dir interface uses them for."""


LAWS = ("mechaduino",)
"""Control laws that a profile can name."""

AXIS_PARAMETERS = (
    "inertia_kg_m2",
    "viscous_Nm_s_per_rad",
    "torque_constant_Nm_per_A",
    "sense_resistor_ohm",
    "start_deg",
    "load_torque_Nm",
    "rotor_teeth",
)
"""What a profile has to say about its motor, driver and load."""

SEED_MASK = (1 << 64) - 1

FULL_PARAMETERS = (
    "phase_resistance_ohm",
    "phase_inductance_H",
    "supply_V",
    "detent_torque_Nm",
    "coulomb_torque_Nm",
    "full_step_error_pct",
    "encoder_eccentricity_deg",
    "encoder_nonlinearity_deg",
    "encoder_noise_counts",
)
"""What it has to say besides for the full plant."""


def bucket_edges_ns(bucket: int) -> tuple[int, int]:
    """What a bucket of ``rt_stats()["wake_latency"]`` counts: from, up to and without. Eight an octave."""
    if bucket < 8:
        return bucket, bucket + 1
    low, octave = 8 + bucket % 8, bucket // 8 - 1
    return low << octave, (low + 1) << octave


def octaves(histogram: Sequence[int]) -> list[int]:
    """The same counts by powers of two: bucket b has values of [2^(b-1), 2^b) ns, bucket 0 has 0."""
    joined = [0] * (len(histogram) // 8 + 3)
    for bucket, count in enumerate(histogram):
        joined[bucket_edges_ns(bucket)[0].bit_length()] += count
    return joined


@dataclass(frozen=True)
class Load:
    """What the shaft of a full plant turns; the parts add up. ``native/hil_core.h``: hil_load."""

    inertia_kg_m2: float = 0.0
    torque_Nm: float = 0.0
    stiffness_Nm_per_rad: float = 0.0
    pendulum_Nm: float = 0.0
    """Weight times length."""
    centre_deg: float = 0.0
    """Where spring and pendulum rest."""
    min_deg: float = 0.0
    max_deg: float = 0.0
    end_stops: bool = False
    """Whether min_deg and max_deg mean anything."""


@dataclass(frozen=True)
class AxisPlan:
    """What an axis is opened with: the plant, its numbers by ``AXIS_PARAMETERS`` and
    ``FULL_PARAMETERS``, its load, and where its randomness starts."""

    parameters: Mapping[str, float]
    plant: Literal["simple", "full"] = "simple"
    load: Load = Load()
    seed: int = 0


class CoreAxis:
    """One axis of a core; what a firmware sees is ``hil.vocab.firmware.Axis``.

    Every call acts at the group's present time and needs the caller to own the group.
    """

    def __init__(self, native: NativeCore, axis: int) -> None:
        self._native = native
        self.id = axis

    def get(self, field: str) -> float:
        """A field by its name in ``hil.core.FIELDS``. Raises KeyError for another name."""
        return self._native.get(self.id, INDEX[field])

    def set(self, field: str, value: float) -> None:
        """Set a writable field. Raises KeyError, or AttributeError for one that is read-only."""
        self._native.set(self.id, INDEX[field], value)

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
        """Drive an input: D0 (direction: high is towards smaller counts), D1 (step, rising edge),
        D2 (enable, active low), D3. Raises KeyError for another name."""
        self._native.pin(self.id, PINS[name], level)

    def script_encoder(self, points: Sequence[tuple[int, int]], linear: bool) -> None:
        """Encoder counts from ``(at_ns, raw)`` points instead of the shaft; none: the shaft again."""
        times = array("q", [at_ns for at_ns, _ in points])
        self._native.script_encoder(self.id, times, array("q", [raw for _, raw in points]), linear)

    def drive(self, rows: Sequence[tuple[int, str, int, int, int]]) -> None:
        """A signal source on the inputs from now on; no rows: none. Rows are (at_ns from now, pin, level,
        steps, duration_ns) as in ``native/hil_core.h``: hil_edges. Raises KeyError for another pin."""
        self._native.drive(
            self.id, [(at_ns, PINS[pin], level, steps, ns) for at_ns, pin, level, steps, ns in rows]
        )

    def watch(self, interval_ns: int, capacity: int) -> None:
        """Sample the axis at every multiple of ``interval_ns``; 0 ends it. Up to ``capacity`` samples
        wait to be taken, later ones are lost."""
        self._native.watch(self.id, interval_ns, capacity)

    def take_samples(self) -> list[Snapshot]:
        """The samples since the last call."""
        return [Snapshot(values) for values in self._native.take_samples(self.id)]

    def lost_samples(self) -> int:
        """How many samples found no room since ``watch``."""
        return self._native.lost_samples(self.id)

    def snapshot(self) -> Snapshot:
        """The state now."""
        return Snapshot(self._native.snapshot(self.id))

    def published(self) -> Snapshot:
        """The state as of the last wake or release; any thread, owner or not."""
        return Snapshot(self._native.published(self.id))


class Core:
    """Simulated time and axes of one bench. See ``native/hil_core.h``."""

    def __init__(self, max_axes: int) -> None:
        self.native = NativeCore(max_axes)
        self.event_fd = self.native.event_fd

    def open_axis(self, group: int, plan: AxisPlan) -> CoreAxis:
        """A cold-started axis.

        Raises:
            ValueError: such a motor is too stiff to be integrated.
        """
        motor = {name: plan.parameters[name] for name in AXIS_PARAMETERS}
        full = None
        if plan.plant == "full":
            full = {name: plan.parameters[name] for name in FULL_PARAMETERS}
        axis = self.native.axis_open(group, motor, full, asdict(plan.load), plan.seed & SEED_MASK)
        return CoreAxis(self.native, axis)

    def take_events(self, group: int) -> list[CoreEvent]:
        """What interrupts of this group did since the last call, in time's order."""
        return [
            CoreEvent(SimTimeNs(at_ns), axis, EVENT_KINDS[kind], value)
            for at_ns, axis, kind, value in self.native.take_events(group)
        ]
