"""Limit of the manual, T = 2 L I / V: in the numbers, in the coils' currents, and where the motor stalls."""

import pytest
from driver_sweep import config, stall

from device_profiles.easydriver.reversal import reversal_us, says
from hil.testing import Bench
from hil.vocab.axis_plan import AxisPlan

MANUAL = (12.0, 0.050, 0.135)
"""Supply, inductance and current of the manual."""


def test_the_manuals_numbers() -> None:
    us = reversal_us(0.050, 0.135, 12.0)
    assert us == pytest.approx(1125.0)
    assert int(us / 8) == 140


def test_the_readout_follows_motor_supply_and_mode() -> None:
    with Bench(config(*MANUAL)) as bench:
        for ms1, ms2, steps_Hz in ((1, 1, 7111.1), (0, 1, 3555.6), (1, 0, 1777.8), (0, 0, 888.9)):
            bench.device("d1").pin("MS1", ms1)
            bench.device("d1").pin("MS2", ms2)
            shot = bench.axis("d1").snapshot()
            assert (shot.reversal_us, shot.most_steps_Hz) == pytest.approx((1125.0, steps_Hz), abs=0.1)
        with bench.fault("supply_sag", "d1", supply_V=6.0):
            assert bench.axis("d1").snapshot().reversal_us == pytest.approx(2250.0)


def test_the_board_says_it() -> None:
    supply_V, inductance_H, current_A = MANUAL
    numbers = {"supply_V": supply_V, "phase_inductance_H": inductance_H, "phase_current_A": current_A}
    plan = AxisPlan(numbers | {"rotor_teeth": 50.0}, "full", law="mechaduino")
    assert says(plan) == [
        "12 V reverse 0.135 A in 50 mH in 1.125 ms: up to 888.9 full steps/s, 7111.1 eighth steps/s"
        " (one each 140.6 us), 266.7 rpm"
    ]


@pytest.mark.parametrize(
    ("supply_V", "inductance_H", "current_A"),
    [MANUAL, (24.0, 0.050, 0.135), (12.0, 0.100, 0.135), (12.0, 0.050, 0.6), (30.0, 0.020, 0.3)],
)
@pytest.mark.parametrize("fast_decay_pct", [0.0, 39.4, 100.0])
def test_a_coil_is_turned_round_in_this_time(
    supply_V: float, inductance_H: float, current_A: float, fast_decay_pct: float
) -> None:
    """With full steps and a clamped rotor: no back-EMF, and both coils at 70.7 % of the current."""
    numbers = {"phase_resistance_ohm": 1.0, "fast_decay_pct": fast_decay_pct}
    with Bench(config(supply_V, inductance_H, current_A, **numbers)) as bench:
        bench.run(ms=50)
        bench.fault("shaft_jam", "d1")
        for pin in ("MS1", "MS2"):
            bench.device("d1").pin(pin, 0)
        bench.run(ms=10)
        at_ns, before_A = bench.now_ns, bench.axis("d1").snapshot().current_b_A
        currents = bench.axis("d1").record("current_b_A", interval_ms=0.05)
        bench.device("d1").pin("dir", 1)
        bench.device("d1").pin("step", 1)
        bench.run(ms=20)
        assert before_A == pytest.approx(current_A * 0.5**0.5)
        assert currents.rows[-1][1] == pytest.approx(-before_A)
        turned_ns = next(then_ns for then_ns, amperes in currents.rows if amperes < -0.999 * before_A)
        expected_us = reversal_us(inductance_H, before_A, supply_V)
        assert (turned_ns - at_ns) / 1e3 == pytest.approx(expected_us, rel=0.05, abs=90)


@pytest.mark.thorough
@pytest.mark.long
def test_the_manuals_motor_stalls_at_the_formulas_rate_under_half_its_load() -> None:
    assert stall(*MANUAL, load=0.55) == pytest.approx(1.0, abs=0.1)
    assert stall(*MANUAL, load=0.0) == pytest.approx(2.4, abs=0.2)


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize(
    ("supply_V", "resistance_ohm", "by_decay"),
    [(12.0, 34.0, (1.11, 1.11, 1.09)), (18.0, 5.0, (0.43, 0.98, 1.46)), (27.0, 34.0, (0.69, 1.29, 1.29))],
)
def test_how_a_current_falls_matters_where_the_coil_does_not_brake_it(
    supply_V: float, resistance_ohm: float, by_decay: tuple[float, float, float]
) -> None:
    """Slow, mixed and fast decay against half the load: what a coil's own voltage does not do, PFD has to."""
    numbers = {"phase_resistance_ohm": resistance_ohm, "load": 0.5}
    seen = [stall(supply_V, 0.05, 0.135, fast_decay_pct=pct, **numbers) for pct in (0.0, 39.4, 100.0)]
    assert seen == pytest.approx(by_decay, abs=0.06)


@pytest.mark.thorough
@pytest.mark.long
def test_the_stall_goes_with_supply_inductance_and_current_as_the_formula_does() -> None:
    """Where resistance takes little of the supply, the coils' flux is about the magnets' or more, and all of
    the supply brings a current down, as the formula has it."""
    changed = [
        *((supply_V, 0.050, 0.135) for supply_V in (8.0, 12.0, 18.0, 27.0)),
        *((12.0, inductance_H, 0.135) for inductance_H in (0.080, 0.120)),
        *((12.0, 0.050, current_A) for current_A in (0.2, 0.3)),
    ]
    rates = [stall(*numbers, load=0.5, phase_resistance_ohm=5.0, fast_decay_pct=100.0) for numbers in changed]
    mean = sum(rates) / len(rates)
    assert mean == pytest.approx(1.5, abs=0.1)
    assert rates == pytest.approx([mean] * len(rates), rel=0.1)
