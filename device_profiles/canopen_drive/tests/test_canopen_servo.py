"""The drive below its node: its verbs, its ramps and its faults."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.testing import Bench, check_profile
from hil.vocab.verbs import VerbRefused

BOARD = Path(__file__).parents[1]


@pytest.fixture
def bench() -> Iterator[Bench]:
    one = Bench({"bench": "t", "devices": {"x": {"profile": "canopen_drive"}}})
    one.run(ms=250)
    yield one
    one.close()


def position_deg(bench: Bench) -> float:
    return float(bench.axis("x").snapshot().yw)


def test_it_passes_the_checks_of_all_boards() -> None:
    check_profile(BOARD)


def test_verbs_move_it(bench: Bench) -> None:
    drive = bench.device("x")
    assert drive.do("enable")["set_point"] == 0.0
    assert drive.do("move_abs", position_deg=90.0)["ends_after_ns"] == 350_000_000
    bench.run(ms=400)
    assert position_deg(bench) == pytest.approx(90.0, abs=0.2)
    drive.do("move_rel", angle_deg=-30.0, velocity_rpm=600.0, acceleration_rpm_per_s=60_000.0)
    bench.run(ms=150)
    assert position_deg(bench) == pytest.approx(60.0, abs=0.2)
    drive.do("position", position_deg=61.0)
    bench.run(ms=150)
    assert position_deg(bench) == pytest.approx(61.0, abs=0.2)
    drive.do("disable")
    assert bench.axis("x").snapshot().loop_on == 0


def test_stop_is_on_a_ramp_or_at_once(bench: Bench) -> None:
    drive = bench.device("x")
    drive.do("enable")
    drive.do("move_abs", position_deg=3600.0)
    bench.run(ms=500)
    answer = drive.do("stop", acceleration_rpm_per_s=6000.0)
    bench.run(ms=answer["ends_after_ns"] / 1e6 + 100)
    assert position_deg(bench) == pytest.approx(answer["set_point"], abs=0.2)
    drive.do("move_rel", angle_deg=3600.0)
    bench.run(ms=500)
    here_deg = position_deg(bench)
    assert "ends_after_ns" not in drive.do("stop", how="prejudice")
    bench.run(ms=200)
    assert position_deg(bench) == pytest.approx(here_deg, abs=2.0)


def test_an_effort_turns_it_and_a_stop_catches_it(bench: Bench) -> None:
    drive = bench.device("x")
    drive.do("enable")
    drive.do("torque", effort_count=40.0)
    bench.run(ms=200)
    assert position_deg(bench) > 20
    drive.do("stop", acceleration_rpm_per_s=6000.0)
    bench.run(ms=500)
    here_deg = position_deg(bench)
    bench.run(ms=100)
    assert position_deg(bench) == pytest.approx(here_deg, abs=0.1)


@pytest.mark.parametrize(
    ("verb", "given", "why"),
    [
        ("move_abs", {"position_deg": 1.0}, "the control loop is off; enable it first"),
        ("torque", {"effort_count": 1.0}, "the control loop is off; enable it first"),
        ("position", {"position_deg": 1e7}, "position_deg"),
    ],
)
def test_what_cannot_be_is_refused(bench: Bench, verb: str, given: dict[str, float], why: str) -> None:
    with pytest.raises(VerbRefused, match=why):
        bench.device("x").do(verb, **given)


def test_a_drive_that_starts_takes_no_verbs() -> None:
    one = Bench({"bench": "t", "devices": {"x": {"profile": "canopen_drive"}}})
    with pytest.raises(VerbRefused, match="the drive starts"):
        one.device("x").do("enable")
    one.close()


def test_an_error_of_the_encoder_takes_the_current_off_until_it_is_cleared(bench: Bench) -> None:
    drive = bench.device("x")
    drive.do("enable")
    drive.set_register("errfl", 1)
    bench.run(ms=10)
    assert bench.axis("x").snapshot().loop_on == 0
    with pytest.raises(VerbRefused, match="fault 2, the encoder reports an error; clear it first"):
        drive.do("enable")
    drive.do("clear_fault")
    drive.do("enable")
    assert bench.axis("x").snapshot().loop_on == 1
