"""The model against the figures that the manual prints, and the native engine against the model."""

import os
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from motion_model import Command, Model, Setup, TooManyPulses, acceleration, deceleration, linear_steps, plan

from device_profiles.sac.typed_text import from_cycle, from_rpm
from hil.core import Core
from hil.core.kinds.sac.core_motion import CoreMotion
from hil.vocab.axis_plan import AxisPlan
from hil.vocab.motion import ONE_SHOT_SLOT, MotionEntry, MotionSetup

MOTOR = {
    "inertia_kg_m2": 5.4e-6,
    "viscous_Nm_s_per_rad": 0.004,
    "torque_constant_Nm_per_A": 0.155,
    "start_deg": 0.0,
    "load_torque_Nm": 0.0,
    "rotor_teeth": 50,
    "phase_current_A": 1.0,
    "driver": 0,
}
END = 1 << 62


# ---- the manual's figures ----


def lengths(c: Command) -> tuple[int, int, int]:
    pulses, _ = plan(c, 10, Setup())
    phases = [p.phase for p in pulses]
    return phases.count("ACCEL"), phases.count("CRUISE"), phases.count("DECEL")


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (Command(200), (90, 20, 90)),
        (Command(200, acc=50), (133, 0, 67)),
        (Command(200, acc=40, dec=99900), (200, 0, 0)),
        (Command(2000), (90, 1820, 90)),
        (Command(2000, dec=99900), (90, 1910, 0)),
        (Command(2000, acc=0), (0, 1910, 90)),
        (Command(300, rpm=10, cycle=30000), (0, 300, 0)),
        (Command(200, acc=40, dec=4000), (198, 0, 2)),  # "exactly one step" cannot hold beside (200, 0, 0)
    ],
)
def test_worked_examples(command: Command, expected: tuple[int, int, int]) -> None:
    assert lengths(command) == expected


def test_the_harmonic_ramp_from_10_to_100_rpm() -> None:
    periods = acceleration(Command(2000), 10, Setup())
    assert (len(periods), sum(periods), periods[0]) == (90, 704_486, 30_000)
    assert deceleration(Command(2000), 100, 100, Setup()) == periods[::-1]


@pytest.mark.parametrize(
    ("rpm", "cycle_us"), [(150, 2000), (70, 4285), (59, 5084), (61, 4918), (60, 5000), (100, 3000)]
)
def test_periods_of_the_manual(rpm: int, cycle_us: int) -> None:
    assert from_rpm(rpm, 200).cycle_us == cycle_us


@pytest.mark.parametrize(("cycle_us", "rpm"), [(4321, 69), (4567, 65), (42567, 7)])
def test_speeds_of_the_manual(cycle_us: int, rpm: int) -> None:
    assert from_cycle(cycle_us, 200).rpm == rpm


@pytest.mark.parametrize(
    ("rpm", "acc", "twice"), [(50, 1, 872), (100, 1, 3490), (100, 10, 349), (600, 2, 62831), (300, 30, 1047)]
)
def test_linear_step_counts_are_half_of_the_manuals_table(rpm: int, acc: int, twice: int) -> None:
    # The text's formula holds; the table of Appendix D is twice it.
    assert linear_steps(rpm, acc * 100, 200) in (twice // 2, (twice + 1) // 2)


# ---- the engine ----


@dataclass(frozen=True)
class Act:
    after_half_us: int
    what: str
    value: Any = None


def entry_of(c: Command) -> MotionEntry:
    return MotionEntry(
        steps=c.steps,
        is_ccw=c.ccw,
        rpm=c.rpm,
        cycle_us=c.cycle,
        acc_hundredths=c.acc,
        dec_hundredths=c.dec,
        is_linear=c.linear,
        extra_pulses=c.extra,
        is_sync=c.sync,
        wait_us=c.wait_us,
        is_pulses=c.in_pulses,
    )


class Engine:
    """The native engine, given the model's actions."""

    def __init__(self, setup: Setup) -> None:
        self.core = Core(1)
        self.group = self.core.native.group_open(0)
        axis = self.core.open_axis(self.group, AxisPlan(MOTOR, law="sac"))
        assert isinstance(axis, CoreMotion)
        self.axis = axis
        self.axis.setup(
            MotionSetup(
                steps_per_rev=setup.sprf,
                slow_rpm=setup.slow,
                microstep_exponent=setup.exponent,
                pulse_us=1,
                interrupt_overhead_us=8,
                clock_correction_us=setup.correction_us,
                is_clock_internal=True,
                external_clock_Hz=1_000_000,
                is_cw_high=False,
                ops=36,
                mode_pins=0,
            )
        )
        self.axis.record_edges(True)
        self._position = 0

    def act(self, now: int, what: str, value: Any) -> None:
        self.play_until(now)
        match what:
            case "enqueue":
                self._position = self._position % 30 + 1
                self.axis.write_entry(self._position, entry_of(value))
                self.axis.enqueue(self._position)
            case "once" if value.continuous:
                self.axis.write_entry(0, entry_of(value))
                self.axis.run_continuous()
            case "once":
                self.axis.write_entry(ONE_SHOT_SLOT, entry_of(value))
                self.axis.run_once(ONE_SHOT_SLOT)
            case "release":
                self.axis.release_sync()
            case "stop":
                self.axis.stop(value)
            case "next":
                self.axis.next(value)
            case "finish":
                self.axis.finish()
            case "gap":
                self.axis.gap(value)

    def play_until(self, until: int) -> None:
        while self.core.native.advance(self.group, END, until * 500)[0] < until * 500:
            pass  # one call does only so much

    def edges(self) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
        """Pulses with their direction, and edges of OP SA; half-us."""
        level, pulses, op_sa = 0, [], []
        for at_ns, pin, high in self.axis.take_edges():
            assert at_ns % 500 == 0
            if pin == "dir":
                level = high
            elif pin == "clk" and high:
                pulses.append((at_ns // 500, -1 if level else 1))
            elif pin == "OP_SA":
                op_sa.append((at_ns // 500, high))
        return pulses, op_sa


rpms = st.one_of(st.integers(1, 30), st.integers(1, 600))
ramps = st.one_of(
    st.sampled_from([0, 100, 1047, 5000, 99899, 99900]), st.integers(100, 3000), st.integers(100, 20000)
)


@st.composite
def commands(draw: st.DrawFn) -> Command:
    rpm = draw(rpms)
    cycle = 300_000 // rpm if draw(st.booleans()) else draw(st.integers(300, 60_000))
    return Command(
        steps=draw(st.one_of(st.integers(0, 3), st.integers(1, 400))),
        ccw=draw(st.booleans()),
        rpm=300_000 // cycle if cycle <= 300_000 else 0,
        cycle=cycle,
        acc=draw(ramps),
        dec=draw(ramps),
        linear=draw(st.booleans()),
        extra=draw(st.sampled_from([0, 0, 0, 1, 7, 255])),
        sync=draw(st.sampled_from([False, False, False, True])),
        wait_us=draw(st.sampled_from([0, 0, 0, 1, 16, 500, 30_000])),
        in_pulses=draw(st.booleans()),
    )


continuous = commands().map(
    lambda c: Command(**{**vars(c), "steps": 0, "continuous": True, "extra": 0, "cycle": max(c.cycle, 500)})
)
acts = st.builds(
    Act,
    st.one_of(st.integers(1, 100), st.integers(1, 400_000), st.integers(1, 4_000_000)),
    st.just("enqueue"),
    commands(),
) | st.builds(
    lambda after, pair: Act(after, *pair),
    st.integers(1, 2_000_000),
    st.one_of(
        st.tuples(st.just("once"), commands() | continuous),
        st.tuples(st.just("release"), st.none()),
        st.tuples(st.just("stop"), st.none() | ramps),
        st.tuples(st.just("next"), st.booleans()),
        st.tuples(st.just("finish"), st.none()),
        st.tuples(st.just("gap"), st.booleans()),
    ),
)
setups = st.builds(
    Setup,
    st.sampled_from([200, 400]),
    st.sampled_from([10, 10, 30, 1]),
    st.sampled_from([0, 1, 1, 2, 3, 5, 7]),
    st.sampled_from([0, 0, 3, -5]),
)


MOST_PULSES = 200_000
"""Maximum number of pulses of an example: half a minute of 128 pulses a step would be millions, and
minutes."""


@pytest.mark.long
@settings(max_examples=int(os.environ.get("HIL_FUZZ", 60)))
@given(setups, st.lists(acts, min_size=4, max_size=14))
def test_pulse_times_are_the_models_to_the_half_microsecond(setup: Setup, given_acts: list[Act]) -> None:
    """Nine commands and interventions an example; `make fuzz` has 10,000 and more."""
    model, engine = Model(setup, MOST_PULSES), Engine(setup)
    now = 0
    try:
        for act in given_acts:
            now += act.after_half_us
            model.act(now, act.what, act.value)
            engine.act(now, act.what, act.value)
        now += 2_000_000
        model.play_until(now)
    except TooManyPulses:
        reject()
    engine.play_until(now)
    pulses, op_sa = engine.edges()
    assert pulses == model.pulses
    assert op_sa == model.op_sa
