"""``plant: full`` under the whole board: calibration, set-points, noise, loads, and refused values."""

import math
from array import array
from functools import cache

import pytest
from full_plant_rig import FULL, IDENTITY, NO_ERRORS, Rig

from hil.testing import Bench, ConfigError


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
        ({"load": {"torque_Nm": 1.0}}, "load: the load has no kind (add kind: and one of constant"),
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
