"""``plant: full``: physics of the motor, loads, encoder errors, and the firmware on top of them.

Physics is tested on an axis alone, with the profile's parameters; the encoder's errors and the full-step
error are off there unless a test is about them.
"""

import math
import random
from array import array
from functools import cache

import pytest

from hil.compose import find_catalogue
from hil.core import Core, Snapshot
from hil.testing import Bench, ConfigError
from hil.vocab.axis_plan import AxisPlan, Load

PROFILE = find_catalogue().profiles["mechaduino"]
FULL = {name: parameter.default("full") for name, parameter in PROFILE.axis.items()}
NO_ERRORS = {
    "full_step_error_pct": 0.0,
    "encoder_eccentricity_deg": 0.0,
    "encoder_nonlinearity_deg": 0.0,
    "encoder_noise_counts": 0.0,
}
IDENTITY = array("f", [i * 360 / 16384 for i in range(16384)]).tobytes()
STEP_DEG = 1.8
TWO_AMPERES = 232  # counts: 2.0016 A


class Rig:
    """An axis without firmware, with an identity table; times in ns since its opening."""

    def __init__(self, load: Load | None = None, seed: int = 0, **parameters: float) -> None:
        self.core = Core(1)
        self.group = self.core.native.group_open(0)
        plan = AxisPlan(FULL | NO_ERRORS | parameters, "full", load or Load(), seed)
        self.axis = self.core.open_axis(self.group, plan)
        self.axis.write_table(IDENTITY)
        self.now_ns = 0

    def run(self, duration_ns: float) -> None:
        self.run_to(self.now_ns + round(duration_ns))

    def run_to(self, at_ns: int) -> None:
        self.now_ns = at_ns
        self.core.native.advance(self.group, 2**62, at_ns)

    def run_ms(self, duration_ms: float) -> Snapshot:
        self.run(duration_ms * 1e6)
        return self.axis.snapshot()

    def torque_mode(self, counts: float) -> None:
        self.axis.set("mode", ord("t"))
        self.axis.set("r", counts)
        self.axis.loop(True)

    @property
    def deg(self) -> float:
        return self.axis.get("position_deg")


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
        rig.run_ms(10)
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
    """Whether 60 full steps from standstill are all made."""
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


# ---- the whole board ----


def board(axis: dict[str, float] | None = None, seed: int = 1, **keys: object) -> Bench:
    device = {
        "profile": "mechaduino",
        "port": "memory",
        "plant": "full",
        "flash": {"table": "identity"},
        "axis": axis or {},
    }
    bench = Bench({"bench": "full", "seed": seed, "devices": {"m1": device | keys}})
    bench.run_until(4500)
    bench.port("m1").read()
    return bench


def typed(bench: Bench, text: bytes, for_ms: float) -> bytes:
    bench.port("m1").write(text)
    bench.run_until(bench.now_ns / 1e6 + for_ms)
    return bench.port("m1").read()


CALIBRATED_AXIS = {"encoder_eccentricity_deg": 0.8}


@cache
def calibrated() -> Bench:
    bench = board(CALIBRATED_AXIS)
    assert b"Calibration complete!" in typed(bench, b"c", 60_000)
    return bench


def angle_errors(table: "array[float]", seed: int) -> list[float]:
    """Table minus shaft angle over a turn, the mean left out: where 0 deg is, is the firmware's choice."""
    errors = []
    for degree in range(0, 360, 2):
        errors_on = {name: FULL[name] for name in NO_ERRORS} | CALIBRATED_AXIS | {"encoder_noise_counts": 0.0}
        rig = Rig(seed=seed, start_deg=degree, **errors_on)
        errors.append((table[int(rig.axis.get("raw"))] - degree + 180) % 360 - 180)
    mean = sum(errors) / len(errors)
    return [error - mean for error in errors]


def test_the_calibration_takes_the_encoders_error_out() -> None:
    bench = calibrated()
    before = angle_errors(array("f", IDENTITY), seed=1)
    after = angle_errors(array("f", bytes(bench.device("m1").nvm["lookup"])), seed=1)
    assert 0.7 < max(map(abs, before)) < 1.1
    assert max(map(abs, after)) < 0.2


def test_the_calibrated_board_goes_where_it_is_told() -> None:
    bench = calibrated()
    typed(bench, b"xy", 1000)
    assert typed(bench, b"r90\n", 1500) == b"Enter setpoint:\r\n90.00\r\n"
    first = bench.axis("m1").snapshot()
    assert abs(first.yw - 90) < 0.1
    typed(bench, b"r450\n", 1500)
    now = bench.axis("m1").snapshot()
    assert abs(now.yw - 450) < 0.1
    assert now.position_deg - first.position_deg == pytest.approx(360, abs=0.1)


def test_velocity_mode_reaches_its_speed() -> None:
    bench = board(dict(NO_ERRORS))
    typed(bench, b"xy", 500)
    typed(bench, b"vr0\n", 500)
    typed(bench, b"r300\n", 2000)
    start_deg = bench.axis("m1").snapshot().position_deg
    bench.run_until(bench.now_ns / 1e6 + 1000)
    assert (bench.axis("m1").snapshot().position_deg - start_deg) / 6 == pytest.approx(300, rel=0.02)


def readings(seed: int) -> bytes:
    bench = board(seed=seed, axis={"encoder_noise_counts": 5.0})
    return b"".join(typed(bench, b"p", 200) for _ in range(5))


def test_noise_comes_from_the_benchs_seed() -> None:
    assert readings(1) == readings(1)
    assert readings(1) != readings(2)


def test_two_boards_of_a_bench_have_noise_of_their_own() -> None:
    device = {"profile": "mechaduino", "port": "memory", "plant": "full"}
    bench = Bench({"bench": "two", "devices": {"m1": device, "m2": device}})
    raws: dict[str, list[int]] = {"m1": [], "m2": []}
    for at_ms in range(100, 200):
        bench.run_until(at_ms)
        for name, found in raws.items():
            found.append(bench.axis(name).snapshot().raw)
    assert raws["m1"] != raws["m2"]


@pytest.mark.parametrize(
    ("load", "settles_deg", "within_deg"),
    [
        ({"kind": "constant", "torque_Nm": 0.02, "inertia_kg_m2": 1e-5}, 7.2, 0.9),
        ({"kind": "spring", "stiffness_Nm_per_rad": 0.1, "centre_deg": 6.3}, 6.3, 0.2),
        ({"kind": "pendulum", "mass_kg": 0.05, "length_m": 0.05, "centre_deg": -83.7}, 5.8, 0.9),
        ({"kind": "lead_screw", "lead_mm": 8.0, "mass_kg": 2.0, "gravity": "positive"}, 7.2, 0.9),
    ],
)
def test_a_board_holds_each_kind_of_load(
    load: dict[str, object], settles_deg: float, within_deg: float
) -> None:
    now = board(dict(NO_ERRORS), load=load).axis("m1").snapshot()
    assert now.velocity_rpm == pytest.approx(0, abs=0.01)
    assert now.position_deg == pytest.approx(settles_deg, abs=within_deg)


def test_a_board_runs_against_its_end_stop() -> None:
    bench = board(dict(NO_ERRORS), load={"kind": "end_stops", "min_deg": -90.0, "max_deg": 45.0})
    typed(bench, b"xy", 500)
    typed(bench, b"r90\n", 1000)
    now = bench.axis("m1").snapshot()
    assert now.position_deg == pytest.approx(45, abs=0.2)
    assert now.u == 115


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"axis": {"phase_inductance_H": 0.0}}, "0 H is too small (write more than 0)"),
        ({"axis": {"phase_resistance_ohm": -1.0}}, "-1 ohm is too small (write more than 0)"),
        ({"axis": {"inertia_kg_m2": -1e-6}}, "-1e-06 kg m2 is too small (write more than 0)"),
        ({"axis": {"coulomb_torque_Nm": math.nan}}, "coulomb_torque_Nm"),
        ({"axis": {"supply_V": 30.0}}, "30 V is outside the supply range of mechaduino 0.1 (write 8 to 25"),
        ({"load": {"kind": "spring"}}, "load.stiffness_Nm_per_rad: this key is missing"),
        ({"load": {"kind": "spring", "stiffness_Nm_per_rad": -1.0}},
         "load.stiffness_Nm_per_rad: -1.0 is too small"),
        ({"load": {"kind": "sprung"}},
         'load.kind: there is no kind of load "sprung" (did you mean "spring"?'),
        ({"load": {"kind": "constant", "torque_nm": 1.0}},
         'load.torque_nm: unknown key (did you mean "torque_Nm"?)'),
        ({"load": {"kind": "constant", "torque_Nm": math.inf}}, "load.torque_Nm"),
        ({"load": {"torque_Nm": 1.0}}, "load: the load has no kind (known kinds are: constant"),
        ({"load": 3}, "load: a load's kind and numbers are wanted here"),
        ({"load": {"kind": "end_stops", "min_deg": 5.0, "max_deg": 5.0}},
         "there is no room between the stops"),
        ({"load": {"kind": "pendulum", "mass_kg": 1.0, "length_m": 1.0, "inertia_kg_m2": -1.0}},
         "too small"),
        ({"load": {"kind": "end_stops", "min_deg": 7.0, "max_deg": 90.0}},
         "the shaft starts outside the stops"),
        ({"plant": "simple", "load": {"kind": "constant"}}, "(write plant: full)"),
    ],
)  # fmt: skip
def test_senseless_values_are_refused(keys: dict[str, object], expected: str) -> None:
    with pytest.raises(ConfigError) as caught:
        board(**keys)  # type: ignore[arg-type]
    assert expected in str(caught.value)
