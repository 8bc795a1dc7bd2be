"""``plant: full``: physics of the motor and its loads.

An axis alone is tested, with the profile's parameters; the encoder's errors and the full-step error are off
unless a test is about them.
"""

import math
import random
from functools import cache

import pytest
from full_plant_rig import FULL, NO_ERRORS, STEP_DEG, TWO_AMPERES, Rig

from hil.vocab.axis_plan import Load


def test_current_rises_with_the_time_constant_l_over_r() -> None:
    # 2 V drive 1.82 A at most, less than the command, so the regulator never steps in.
    rig = Rig(Load(inertia_kg_m2=1000), supply_V=2.0)
    rig.axis.vref(0, 0)
    rig.run_ms(20)
    assert rig.axis.get("current_a_A") == 0
    rig.axis.vref(255, 0)
    began_ns = rig.now_ns
    while rig.axis.get("current_a_A") < 2.0 / 1.1 * (1 - math.exp(-1)):
        rig.run(2000)
    assert (rig.now_ns - began_ns) * 1e-9 == pytest.approx(2.6e-3 / 1.1, rel=0.02)


def test_the_supply_limits_how_fast_a_current_changes() -> None:
    slopes_A_per_ms = []
    for supply_V in (12.0, 24.0):
        rig = Rig(Load(inertia_kg_m2=1000), supply_V=supply_V)
        rig.axis.vref(0, 0)
        rig.run_ms(20)
        rig.axis.vref(255, 0)
        slopes_A_per_ms.append(rig.run_ms(0.1).current_a_A / 0.1)
        assert rig.axis.get("voltage_a_V") == supply_V
    assert slopes_A_per_ms == pytest.approx([12 / 2.6, 24 / 2.6], rel=0.03)


@cache
def no_load_rpm(supply_V: float, effort: int) -> float:
    """Speed of the free shaft, commutated every 10 us at the angle of the largest torque."""
    rig = Rig(supply_V=supply_V)
    every_ns, duration_ms = 10_000, 1000
    rows = []
    for _ in range(duration_ms * 1_000_000 // every_ns):
        deg, deg_per_s = rig.deg, rig.axis.get("velocity_rpm") * 6
        rows.append(deg)
        rig.axis.output(-(deg + deg_per_s * every_ns * 0.5e-9) - STEP_DEG, effort)
        rig.run(every_ns)
    tail = rows[len(rows) * 4 // 5 :]
    return (tail[-1] - tail[0]) / 6 / ((len(tail) - 1) * every_ns * 1e-9)


@pytest.mark.parametrize("effort", [20, 40, 115])
def test_no_load_speed_grows_with_the_supply(effort: int) -> None:
    assert no_load_rpm(24.0, effort) / no_load_rpm(12.0, effort) == pytest.approx(2, rel=0.05)


def test_no_load_speed_is_that_of_such_a_motor() -> None:
    # Back-EMF alone, 0.155 V s/rad against 24 V (square wave: 30.6 V), gives 1479 (1882) rpm.
    assert 1300 < no_load_rpm(24.0, 20) < 2200


@pytest.mark.parametrize("sign", [1, -1])
def test_holding_torque(sign: int) -> None:
    rig = Rig()
    rig.axis.vref(TWO_AMPERES, TWO_AMPERES)
    rig.run_ms(200)
    start_deg = rig.deg
    torque_Nm = 0.0
    while abs(rig.deg - start_deg) < 2 * STEP_DEG:
        torque_Nm += 0.0005
        rig.axis.set("load_torque_Nm", sign * torque_Nm)
        rig.run_ms(4)  # both coils at 2 A make the driver too hot within 5 s
    assert torque_Nm == pytest.approx(0.45, rel=0.02)


def stored_J(rig: Rig) -> float:
    now = rig.axis.snapshot()
    rad_per_s = now.velocity_rpm * math.tau / 60
    coils_J = 0.5 * FULL["phase_inductance_H"] * (now.current_a_A**2 + now.current_b_A**2)
    detent_J = FULL["detent_torque_Nm"] / 200 * -math.cos(math.radians(200 * now.position_deg))
    return 0.5 * FULL["inertia_kg_m2"] * rad_per_s**2 + coils_J + detent_J


@pytest.mark.parametrize("load_Nm", [0.0, -0.06, 0.06])
@pytest.mark.parametrize("counts", [20, 60, 115])
def test_energy_balance(load_Nm: float, counts: int) -> None:
    rig = Rig(load_torque_Nm=load_Nm)
    rig.run_ms(100)
    before, stored_before_J = rig.axis.snapshot(), stored_J(rig)
    rig.torque_mode(counts)
    now = rig.run_ms(700)
    electrical_J = now.electrical_J - before.electrical_J
    out_J = now.copper_J - before.copper_J + now.friction_J - before.friction_J + now.load_J - before.load_J
    moved_J = max(abs(electrical_J), now.copper_J - before.copper_J)
    assert abs(electrical_J - out_J - (stored_J(rig) - stored_before_J)) < 0.01 * moved_J
    assert now.load_J - before.load_J == pytest.approx(
        -load_Nm * math.radians(now.position_deg - before.position_deg), rel=1e-3, abs=1e-6
    )


@pytest.mark.parametrize(("load_Nm", "loaded_ms"), [(-0.5, 20), (-0.3, 4), (-0.4, 4), (0.4, 6), (0.3, 12)])
def test_lost_steps_come_in_fours(load_Nm: float, loaded_ms: float) -> None:
    rig = Rig(Load(inertia_kg_m2=2e-5), start_deg=0.0)
    rig.axis.output(0.0, 150)
    rig.run_ms(500)
    start_deg = rig.deg
    for step in range(1, 41):
        rig.axis.output(-STEP_DEG * step, 150)
        if step == 20:
            rig.axis.set("load_torque_Nm", load_Nm)
            rig.run_ms(loaded_ms)
            rig.axis.set("load_torque_Nm", 0.0)
        rig.run_ms(40)
    rig.run_ms(500)
    lost = 40 - (rig.deg - start_deg) / STEP_DEG
    assert abs(lost) > 3.9
    assert lost / 4 == pytest.approx(round(lost / 4), abs=0.02)


def starts_at(steps_per_s: float, load_Nm: float) -> bool:
    """Return whether 60 full steps from standstill are all made."""
    rig = Rig(Load(torque_Nm=load_Nm), start_deg=0.0)
    rig.axis.output(0.0, 150)
    rig.run_ms(500)
    start_deg = rig.deg
    for step in range(1, 61):
        rig.axis.output(-STEP_DEG * step, 150)
        rig.run(1e9 / steps_per_s)
    rig.run_ms(300)
    return abs(rig.deg - start_deg - 60 * STEP_DEG) < STEP_DEG / 2


def test_pull_in_speed_falls_with_the_load() -> None:
    speeds = range(50, 2001, 50)
    pull_in = [
        max((speed for speed in speeds if starts_at(speed, -load_Nm)), default=0)
        for load_Nm in (0.0, 0.03, 0.06, 0.09, 0.12, 0.15)
    ]
    assert pull_in == sorted(set(pull_in), reverse=True), pull_in
    assert 1000 < pull_in[0] < 2000


def test_a_stopped_shaft_stays_stopped() -> None:
    rig = Rig(detent_torque_Nm=0.0)
    rig.axis.vref(0, 0)
    rig.run_ms(500)
    rest_deg = rig.deg
    rig.axis.set("load_torque_Nm", 0.0079)
    rig.run_ms(2000)
    assert rig.deg == rest_deg
    assert rig.axis.get("velocity_rpm") == 0
    rig.axis.set("load_torque_Nm", 0.0081)
    rig.run_ms(1000)
    assert rig.deg > rest_deg + 1


def test_a_spring_twists_until_it_pulls_as_much_as_the_load() -> None:
    rig = Rig(Load(stiffness_Nm_per_rad=0.5, centre_deg=30), detent_torque_Nm=0.0, start_deg=30.0)
    rig.axis.vref(0, 0)
    rig.axis.set("load_torque_Nm", 0.2)
    now = rig.run_ms(3000)
    stuck_deg = math.degrees(FULL["coulomb_torque_Nm"] / 0.5)
    assert now.position_deg - 30 == pytest.approx(math.degrees(0.2 / 0.5), abs=stuck_deg)


def test_a_pendulum_swings_as_long_as_its_length_says() -> None:
    length_m = 0.1
    load = Load(inertia_kg_m2=0.5 * length_m**2, pendulum_Nm=0.5 * 9.80665 * length_m)
    rig = Rig(load, detent_torque_Nm=0.0, coulomb_torque_Nm=0.0, viscous_Nm_s_per_rad=0.0, start_deg=5.0)
    rig.axis.vref(0, 0)
    crossings = []
    for _ in range(3000):
        before = rig.deg
        if rig.run_ms(1).position_deg <= 0 < before:
            crossings.append(rig.now_ns)
    period_s = (crossings[-1] - crossings[0]) / (len(crossings) - 1) * 1e-9
    assert period_s == pytest.approx(math.tau * math.sqrt(length_m / 9.80665), rel=0.01)


def test_numbers_stay_finite_under_any_load() -> None:
    for load_Nm in (1e300, -1e300, math.inf, math.nan, 1e9):
        rig = Rig(Load(stiffness_Nm_per_rad=0.1))
        rig.torque_mode(115)
        rig.axis.set("load_torque_Nm", load_Nm)
        for _ in range(20):
            now = rig.run_ms(50).as_dict()
            assert {name: value for name, value in now.items() if not math.isfinite(value)} == {}


def noisy_run(seed: int, cuts: list[int]) -> tuple[float, ...]:
    rig = Rig(
        Load(end_stops=True, min_deg=-500, max_deg=500),
        seed,
        **{name: FULL[name] for name in NO_ERRORS},
    )
    rig.torque_mode(30)
    for cut_ns in cuts:
        rig.run_to(cut_ns)
        rig.axis.snapshot()
    rig.run_to(300_000_000)
    return tuple(rig.axis.snapshot().as_dict().values())


def test_how_time_is_cut_changes_nothing() -> None:
    once = noisy_run(5, [])
    for seed in range(5):
        cuts = sorted(random.Random(seed).sample(range(300_000_000), 500))
        assert noisy_run(5, cuts) == once


def test_equal_seeds_are_equal_and_others_are_not() -> None:
    assert noisy_run(1, []) == noisy_run(1, [])
    assert noisy_run(1, []) != noisy_run(2, [])
