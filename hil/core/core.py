"""Facade of a core, with names instead of numbers."""

from collections.abc import Sequence
from functools import partial
from math import nan

from hil.core._native import NativeCore
from hil.core.abi import Event
from hil.core.axis_kind import CLOCK_OUT, CLOCK_OUT_HZ, LOAD, speed_limit_rpm
from hil.core.core_axis import CoreAxis
from hil.core.followed_speed import followed_speed
from hil.core.kinds import kind_of
from hil.vocab.axis_plan import FULL_PARAMETERS, AxisPlan
from hil.vocab.time import SimTimeNs

SEED_MASK = (1 << 64) - 1


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
        kind = kind_of(plan.law, plan.processor, plan.fields)
        motor = {name: plan.parameters[name] for name in kind.parameters} or _NO_MOTOR
        motor |= {name: plan.parameters.get(name, nan) for name in kind.optional_parameters}
        full = None
        if plan.plant == "full":
            full = {name: plan.parameters[name] for name in FULL_PARAMETERS}
        axis = self.native.axis_open(group, kind.law, motor, full, vars(plan.load), plan.seed & SEED_MASK)
        made: CoreAxis = kind.make(self.native, axis, kind)
        made.holding_Nm = kind.holding_Nm(plan.parameters)
        made.speed_limit_rpm = speed_limit_rpm(plan.parameters)
        made.find_followed = partial(followed_speed, plan)
        made.set_load_Nm = motor[LOAD]
        if plan.fields:
            self.native.cells(axis, [kind.fields[own.name] for own in plan.fields])
            for own in plan.fields:
                made.set(own.name, own.start)
        if plan.processor and made.processor:
            made.processor.set_up(plan.processor)
        return made

    def wire(self, output: tuple[CoreAxis, str], to: tuple[CoreAxis, str]) -> None:
        """Join an output to an input of the same group, each an axis and its pin by name.

        Raises:
            MemoryError: the output's axis has 16 wires already.
        """
        (from_axis, name), (to_axis, input_name) = output, to
        if name == CLOCK_OUT:
            to_axis.set(to_axis.kind.clock_field, CLOCK_OUT_HZ)
            return
        self.native.wire(from_axis.id, from_axis.kind.outputs[name], to_axis.id, to_axis.pins[input_name])

    def take_events(self, group: int) -> list[tuple[SimTimeNs, int, str, float]]:
        """Events from interrupts of this group since the last call, in time's order: the time, the axis's
        number, the kind's name, the value."""
        return [
            (SimTimeNs(at_ns), axis, Event(kind).name, value)
            for at_ns, axis, kind, value in self.native.take_events(group)
        ]
