"""State of an axis does not depend on how the way to a time was cut, nor on who looked on the way: random
commands at random times, once in one piece between two of them, once in many and with watchers of all kinds.
``HIL_CUT_SEEDS``: how many series."""

import os
from array import array
from collections.abc import Callable
from random import Random
from typing import Any

import pytest

from hil.core import KINDS, Core, CoreAxis
from hil.core.abi import TABLE_LEN, Law
from hil.core.kinds.pin_bank.kind import CoreBank
from hil.core.kinds.sac.core_motion import CoreMotion
from hil.vocab.axis_plan import AxisPlan, Load
from hil.vocab.firmware import Pulses
from hil.vocab.motion import CONTINUOUS_SLOT, ONE_SHOT_SLOT, MotionEntry, MotionSetup
from hil.vocab.path import PathPiece

SEEDS = int(os.environ.get("HIL_CUT_SEEDS", "60"))
COMMANDS = 40
HORIZON_NS = 1 << 62
IDENTITY = array("f", [i * 360 / TABLE_LEN for i in range(TABLE_LEN)]).tobytes()
MOTOR = {
    "inertia_kg_m2": 5.7e-6,
    "viscous_Nm_s_per_rad": 1e-4,
    "torque_constant_Nm_per_A": 0.2,
    "load_torque_Nm": 0.0,
    "rotor_teeth": 50.0,
    "sense_resistor_ohm": 0.15,
    "phase_current_A": 1.5,
    "ambient_degC": 25.0,
    "fast_decay_pct": 39.0,
    "phase_resistance_ohm": 1.65,
    "phase_inductance_H": 0.0032,
    "supply_V": 12.0,
    "detent_torque_Nm": 0.01,
    "coulomb_torque_Nm": 0.005,
    "full_step_error_pct": 5.0,
    "encoder_eccentricity_deg": 0.3,
    "encoder_nonlinearity_deg": 0.1,
    "encoder_noise_counts": 0.7,
}
LOADS = (
    Load(),
    Load(torque_Nm=0.02),
    Load(stiffness_Nm_per_rad=0.01, centre_deg=30.0),
    Load(pendulum_Nm=0.05),
    Load(min_deg=-40.0, max_deg=40.0, end_stops=True),
)
FAULTS = (
    *(
        ("jam", 1),
        ("jam", 0),
        ("open_a", 1),
        ("open_a", 0),
        ("open_b", 1),
        ("open_b", 0),
        ("slip_counts", 50),
    ),
    *(("noise_counts", 2), ("noise_counts", 0), ("noise_seed", 5), ("shift_rev", 0.01), ("load_Nm", 0.05)),
    *(("load_Nm", 0), ("freeze", 1), ("freeze", 0), ("open_line", 1), ("open_line", 0), ("supply_V", 7)),
)
SET = (
    *(
        ("r", 0),
        ("r", 90),
        ("pKp", 15),
        ("pKi", 0.5),
        ("vKp", 0.05),
        ("vLPF", 100),
        ("PA", 1.8),
        ("uMAX", 150),
    ),
    *(("print_yw", 1), ("print_yw", 0), ("diaagc", 384), ("errfl", 5), ("load_torque_Nm", 0.1)),
)
CUTS_NS = (1, 499, 500, 29_999, 30_000, 30_001, 153_854, 153_856)
"""Lengths of steps, pulses and control steps, and next to them."""

Do = Callable[[Any], object]


def a_servos(random: Random) -> Do:
    piece = PathPiece(random.randrange(1, 20_000_000), 0.0, random.uniform(-90, 90), 0.0, 0.0)
    steps = random.choice((0, 1, 50))
    row = (random.randrange(40_000), "step" if steps else "enable", 0, steps, steps * 10_000)
    theta, effort, on = random.uniform(0, 360), random.randrange(200), random.random() < 0.8
    field, value = random.choice(SET)
    mode = ord(random.choice("xvth"))
    return random.choice(
        (
            lambda axis: axis.loop(on),
            lambda axis: axis.set("mode", mode),
            lambda axis: axis.set(field, value),
            lambda axis: axis.output(theta, effort),
            lambda axis: axis.vref(effort, effort // 2),
            lambda axis: axis.spi(0xFFFF),
            lambda axis: axis.follow([piece]),
            lambda axis: axis.drive([row]),
            lambda axis: axis.script_encoder([(0, 0), (50_000_000, effort * 50)], linear=on),
            lambda axis: axis.script_encoder([], linear=False),
        )
    )


def a_steppers(random: Random) -> Do:
    steps, rpm, cycle_us = (
        random.choice((0, 1, 5, 200)),
        random.choice((1, 60, 600)),
        random.choice((100, 5000)),
    )
    ramps = [random.choice((0, 500, 99_900)) for _ in range(2)]
    ccw, linear, sync, by_pulse = (random.random() < 0.3 for _ in range(4))
    entry = MotionEntry(
        steps, ccw, rpm, cycle_us, *ramps, linear, 0, sync, random.choice((0, 0, 333)), by_pulse
    )
    pulse_us, ops, pins = random.choice((1, 30, 200)), random.randrange(64), random.randrange(8)
    setup = MotionSetup(200, 10, random.randint(0, 5), pulse_us, 8, 0, not linear, 1_000_000, ccw, ops, pins)
    slot, passes = random.choice((CONTINUOUS_SLOT, 3, ONE_SHOT_SLOT)), random.randrange(3)
    row = (random.randrange(40_000), random.choice(("EnA", "EnB", "sync", "Estop")), int(ccw), 0, 0)

    def moves(axis: CoreMotion) -> None:
        axis.write_entry(slot or 1, entry)
        axis.enqueue(slot or 1)

    def cuts_in(axis: CoreMotion) -> None:
        axis.write_entry(slot, entry)
        axis.run_once(slot)

    def loops(axis: CoreMotion) -> None:
        axis.loop_passes(passes)
        axis.loop_start(2)
        axis.loop_finish(3)

    return random.choice(
        (
            *[lambda axis: axis.pulse(ccw)] * 5,
            *[moves] * 3,
            cuts_in,
            loops,
            lambda axis: axis.retarget(rpm, cycle_us),
            lambda axis: axis.stop(None if ccw else ramps[0]),
            lambda axis: axis.next(ccw),
            lambda axis: axis.finish(),
            lambda axis: axis.release_sync(),
            lambda axis: axis.gap(ccw),
            lambda axis: axis.encoder_mode(ccw),
            lambda axis: axis.report(not ccw),
            lambda axis: axis.setup(setup),
            lambda axis: axis.set("clock_Hz", -1 if ccw else 7e5 * passes),
            lambda axis: axis.drive([row]),
        )
    )


def a_drivers(random: Random) -> Do:
    steps = random.choice((0, 0, 1, 50))
    pin = "step" if steps else random.choice(("dir", "MS1", "MS2", "sleep", "reset", "enable"))
    step_ns = random.choice((1000, 10_000, 900_000))
    row = (random.randrange(40_000), pin, random.randrange(2), steps, steps * step_ns)
    return lambda axis: axis.drive([row])


def a_banks(random: Random) -> Do:
    pin, level = random.choice(("D2", "D6", "A5")), random.randrange(2)
    count, period_ns = random.randrange(30), random.randrange(1001, 300_000)
    rows = [Pulses(count, period_ns, 1000), Pulses(count // 2, 2 * period_ns, 1000)][random.randrange(3) :]

    def pulses(axis: CoreBank) -> None:
        axis.pulse(pin, rows)

    return random.choice(
        (
            *[pulses] * 2,
            lambda axis: axis.write(pin, level),
            lambda axis: axis.let_go(pin),
            lambda axis: axis.loop(False),
        )
    )


def an_encoders(random: Random) -> Do:
    gaps_ns = [random.choice((0, 100, 500, 30_000)) for _ in range(random.choice((3, 40)))]
    rows = [
        (
            sum(gaps_ns[: i + 1]),
            random.choice(("CLK", "CLK", "CLK", "MOSI", "CSn")),
            random.randrange(2),
            0,
            0,
        )
        for i in range(len(gaps_ns))
    ]
    return lambda axis: axis.drive(rows)


def anybodys(random: Random, axis: CoreAxis) -> Do:
    pin, level = random.choice([*axis.pins]), random.randrange(2)
    what, value = random.choice(FAULTS)
    load_Nm = random.choice((0.0, 0.01, -0.1, 0.4))

    def fails(axis: CoreAxis) -> None:
        if what != "supply_V" or axis.supply_V():
            axis.fault(what, value)

    return random.choice(
        (
            lambda axis: axis.pin(pin, level),
            fails,
            lambda axis: axis.set("load_torque_Nm", load_Nm),
            lambda axis: axis.power_up(),
        )
    )


COMMANDS_OF: dict[str, Callable[[Random], Do]] = {
    "mechaduino": a_servos,
    "sac": a_steppers,
    "a3967": a_drivers,
    "pin_bank": a_banks,
    "as5047d": an_encoders,
}


class Group:
    """Some axes of chance, wired to each other. What ``shown`` has is all that can be seen; the edges of
    the first with outputs are recorded from the start where ``random`` says so."""

    def __init__(self, random: Random) -> None:
        self.core, self.shown = Core(3), []
        self.id = self.core.native.group_open(0)
        plans = [
            AxisPlan(
                MOTOR | {"start_deg": random.choice((0.0, 6.3)), "driver": float(random.randrange(2))},
                random.choice(("simple", "full")),
                random.choice(LOADS),
                random.randrange(100),
                law=random.choice(("sac", "sac", "mechaduino", "a3967", "pin_bank", "as5047d")),
            )
            for _ in range(random.choice((1, 1, 2, 3)))
        ]
        self.axes: list[Any] = [self.core.open_axis(self.id, plan) for plan in plans]
        self.unwatched = [axis for axis in self.axes if axis.kind.outputs]
        for axis in self.axes:
            if axis.kind.law == Law.mechaduino:
                axis.write_table(IDENTITY)
        shafts = [axis for axis in self.axes if axis.kind.has_motor]
        for axis in self.axes:
            if axis.kind.reads_magnet and shafts:
                zero_deg, is_reversed = random.choice((0.0, 200.0)), bool(random.randrange(2))
                axis.place_magnet(random.choice(shafts), zero_deg=zero_deg, is_reversed=is_reversed)
        for _ in range(random.choice((0, 0, 1, 3)) if self.unwatched else 0):
            sender, receiver = random.choice(self.unwatched), random.choice(self.axes)
            ends = random.choice([*sender.kind.outputs]), random.choice([*receiver.pins])
            self.core.wire((sender, ends[0]), (receiver, ends[1]))
        self.recorded = self.unwatched.pop(0) if self.unwatched and random.random() < 0.5 else None
        if self.recorded:
            self.recorded.record_edges(True)

    def reach(self, at_ns: int) -> None:
        now_ns = -1
        while now_ns < at_ns:
            now_ns, _ = self.core.native.advance(self.id, HORIZON_NS, at_ns)
            self.shown += self.core.take_events(self.id)

    def show(self) -> None:
        self.shown += [axis.snapshot().as_dict() for axis in self.axes]
        if self.recorded:
            self.shown += self.recorded.take_edges()

    def look(self, random: Random) -> None:
        axis = random.choice(self.axes)
        match random.randrange(6):
            case 0:
                axis.snapshot()
            case 1:
                axis.get(random.choice([*axis.kind.fields]))
            case 2:
                self.core.native.release(self.id)  # as real time does, which publishes what it is
                self.core.native.acquire(self.id)
                axis.published()
            case 3:
                interval_ns, points = random.choice(
                    ((0, 1), (300, 1), (77_777, 1), (77_777, 7), (1_000_001, 3))
                )
                axis.watch(random.randrange(3), interval_ns, 50, points)
            case 4:
                axis.take_samples(random.randrange(3))
            case 5 if axis in self.unwatched:
                axis.record_edges(random.random() < 0.6)


def run(seed: int, looks: Random | None) -> list[Any]:
    """Return all that is shown at each command; ``looks``: chance of the cuts and the looks."""
    random = Random(seed)
    group = Group(random)
    then_ns = 0
    for _ in range(COMMANDS):
        now_ns, longest_ns = then_ns, random.choice((1, 500, 30_000, 100_000, 3_000_000, 60_000_000))
        then_ns += random.randrange(longest_ns + 1)
        if looks:
            cuts = [looks.randint(now_ns, then_ns) for _ in range(looks.choice((0, 1, 3, 10)))]
            for at_ns in sorted([*cuts, min(then_ns, now_ns + looks.choice(CUTS_NS))]):
                group.reach(at_ns)
                group.look(looks)
        group.reach(then_ns)
        axis = random.choice(group.axes)
        is_its_own = random.random() < 0.8
        law = axis.kind.law.name
        (COMMANDS_OF[law](random) if is_its_own else anybodys(random, axis))(axis)
        group.show()
    return group.shown


def test_every_law_has_commands() -> None:
    others = {"walter", "own_fields"}  # test_joint_cuts has the joints; fields do not move
    assert COMMANDS_OF.keys() == KINDS.keys() - others


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(SEEDS))
def test_neither_cuts_nor_looks_change_anything(seed: int) -> None:
    whole, cut = run(seed, None), run(seed, Random(-seed))
    for one, other in zip(whole, cut, strict=True):
        if isinstance(one, dict) and repr(one) != repr(other):
            pytest.fail(str({name: (one[name], other[name]) for name in one if one[name] != other[name]}))
    assert repr(whole) == repr(cut)
