"""The zero of a shaft's angle: of what is told alone, for each kind of board, and in the log."""

import io
import re

import pytest

from hil.compose.replay import replay
from hil.core.axis_kind import ANGLE
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.sim.settable import setting_problem
from hil.testing import Bench

BUS = {"can0": {"bit_rate": 500_000, "nodes": {"m1": 1}}}
PROFILES = ("mechaduino", "sac", "modbus_drive", "canopen_drive")


def config(profile: str = "sac", **keys: object) -> dict[str, object]:
    return {"bench": "z", "devices": {"m1": {"profile": profile, **keys}}}


@pytest.mark.parametrize("plant", ["simple", "full"])
@pytest.mark.parametrize("profile", PROFILES)
def test_a_zero_turns_nothing(profile: str, plant: str) -> None:
    with (
        Bench(config(profile, plant=plant)) as bench,
        Bench(config(profile, plant=plant)) as untouched,
    ):
        for each in (bench, untouched):
            each.run(ms=1500)
            each.axis("m1").load_torque_Nm = 0.3
            each.run(ms=20)
        here_deg = bench.axis("m1").snapshot().position_deg
        bench.axis("m1").zero()
        assert bench.axis("m1").snapshot().position_deg == 0
        for each in (bench, untouched):
            each.run(ms=50)
        zeroed, other = (each.axis("m1").snapshot().as_dict() for each in (bench, untouched))
        for angle in ("position_deg", "commanded_deg"):
            assert zeroed.pop(angle, 0.0) == pytest.approx(other.pop(angle, here_deg) - here_deg, abs=1e-6)
        assert zeroed == other


def test_what_a_stepper_is_sent_to_counts_from_the_zero() -> None:
    with Bench(config()) as bench:
        bench.run(ms=1200)
        axis = bench.axis("m1")
        axis.do("move_abs", position_deg=90)
        bench.run(ms=2000)
        axis.zero()
        axis.do("move_abs", position_deg=-45)
        bench.run(ms=2000)
        shot = axis.snapshot()
        assert shot.position_deg == pytest.approx(-45, abs=0.1)
        assert (shot.commanded_deg, shot.pulses) == (pytest.approx(-45), 50)  # 100 there, 50 back


def test_a_servo_goes_on_by_its_own_angle() -> None:
    flash = {"table": "identity"}
    with Bench(config("mechaduino", flash=flash)) as bench:
        bench.run(ms=4500)
        axis = bench.axis("m1")
        axis.do("enable")
        bench.run(ms=100)
        axis.zero()
        axis.do("move_abs", position_deg=50)
        bench.run(ms=2000)
        shot = axis.snapshot()
        assert shot.yw == pytest.approx(50, abs=0.1)
        assert shot.position_deg == pytest.approx(50 - 6.3, abs=0.2)


def test_it_survives_a_reset_and_is_in_the_log() -> None:
    log = io.StringIO()
    with Bench(config(), around=BenchHooks(log=InputLogWriter(log, "test", config(), {}))) as bench:
        bench.run(ms=1200)
        bench.axis("m1").load_torque_Nm = 0.1
        bench.run(ms=100)
        bench.axis("m1").zero()
        bench.device("m1").reset()
        bench.axis("m1").load_torque_Nm = 0.0
        bench.run(ms=1000)
        shot = bench.axis("m1").snapshot()
        assert -1.8 < shot.position_deg < 0
    replayed = replay(log.getvalue().splitlines(keepends=True))
    assert replayed.runtime.snapshot("m1") == shot


def test_a_stepper_that_moves_keeps_its_zero() -> None:
    with Bench(config()) as bench:
        bench.run(ms=1200)
        bench.axis("m1").do("velocity", velocity_rpm=60)
        bench.run(ms=100)
        with pytest.raises(ValueError, match="its motions end at angles; wait until it stands"):
            bench.axis("m1").zero()
        bench.axis("m1").do("stop", how="prejudice")
        bench.run(ms=100)
        bench.axis("m1").zero()


def test_the_drive_of_a_bus_is_homed_by_its_master() -> None:
    with Bench({**config("mechaduino", flash={"table": "identity"}), "can": BUS}) as bench:
        with pytest.raises(ValueError, match="masters of the CAN bus count by it; let them home"):
            bench.axis("m1").zero()
        runtime = bench._runtime
        problem = setting_problem(runtime.faults, runtime.devices["m1"], ANGLE, 90.0)
        assert str(problem).startswith("position_deg: masters")


@pytest.mark.parametrize("value", [1.1e6, -1.1e6, float("nan"), float("inf"), True, "0"])
def test_no_angle_far_out(value: object) -> None:
    runtime = Bench(config())._runtime
    problem = setting_problem(runtime.faults, runtime.devices["m1"], ANGLE, value)
    assert problem is not None
    assert re.fullmatch(r"position_deg: .+ is (too large|too small|no number|a text); write .+", problem)
