"""Answers of twins' axes to a run about the motions that it has given them."""

from itertools import pairwise

import pytest

from hil.runs import TwinAxes
from hil.testing import Bench
from hil.vocab.axis import Axis
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS, ms
from hil.vocab.verbs import VerbRefused

SOON_MS, NOW_MS = 100, 4500


def stepper() -> tuple[Bench, Axis]:
    bench = Bench({"bench": "t", "devices": {"s1": {"profile": "sac"}}})
    bench.run_until(ms=NOW_MS)
    axis = TwinAxes(bench._runtime, bench._time.sampler)["s1"]
    axis.hold()
    return bench, axis


def servo() -> tuple[Bench, Axis]:
    bench = Bench(
        {"bench": "t", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
    )
    bench.run_until(ms=NOW_MS)
    bench.axis("m1").do("enable")
    bench.axis("m1").do("position", position_deg=10.0)
    bench.run(ms=SOON_MS)
    return bench, TwinAxes(bench._runtime, bench._time.sampler)["m1"]


def test_a_motion_that_could_not_be_done_at_its_time_is_told() -> None:
    bench, axis = stepper()
    axis.move(90.0, 60, ms(NOW_MS + SOON_MS))
    bench.port("s1").write(b"xm2000v60\r")
    assert axis.refusal is None
    bench.run(ms=2 * SOON_MS)
    assert axis.refusal is not None
    assert axis.refusal.startswith("move_abs: it moves")
    axis.release()
    axis.hold()
    assert axis.refusal is None


@pytest.mark.parametrize("due_ms", [NOW_MS + SOON_MS, NOW_MS], ids=["now", "late"])
def test_a_motion_that_is_due_at_once_is_refused_at_once(due_ms: int) -> None:
    """A motion that comes when its time is over is refused at once, too."""
    bench, axis = stepper()
    bench.port("s1").write(b"xm2000v60\r")
    bench.run(ms=SOON_MS)
    with pytest.raises(VerbRefused):
        axis.move(90.0, 60, ms(due_ms))
    assert axis.refusal is None


def test_the_zero_of_an_axis_stays_while_a_run_has_it() -> None:
    bench, axis = stepper()
    with pytest.raises(ValueError, match="a run goes by it; cancel it, or wait for its end"):
        bench.axis("s1").zero()
    axis.release()
    bench.axis("s1").zero()


def test_a_stepper_follows_no_path() -> None:
    _, axis = stepper()
    with pytest.raises(VerbRefused, match="follows no paths"):
        axis.follow((PathPiece(0, 1.0),), ms(NOW_MS + SOON_MS))


def test_an_axis_is_sampled_while_it_is_held() -> None:
    bench, axis = servo()
    bench.run(ms=5)
    assert axis.samples() == ()
    axis.hold()
    bench.run(ms=5)
    rows = axis.samples()
    assert len(rows) == 5
    assert [after[0] - before[0] for before, after in pairwise(rows)] == [NS_PER_MS] * 4
    for _, commanded_deg, position_deg in rows:
        assert commanded_deg == pytest.approx(10.0)
        assert position_deg == pytest.approx(10.0, abs=0.2)
    assert axis.samples() == []
    axis.release()


def test_a_servo_says_what_its_loop_does() -> None:
    bench, axis = servo()
    state = axis.state()
    assert (state.is_moving, state.is_under_way, state.is_on, state.keeps_angle) == (
        False,
        False,
        True,
        True,
    )
    assert state.off_by_deg < 0.2
    axis.follow((PathPiece(2 * NS_PER_MS, 10.0, 5.0), PathPiece(0, 10.01)), bench.now_ns + NS_PER_MS)
    bench.run(ms=2)
    assert (axis.state().is_moving, axis.state().is_under_way) == (True, True)
    bench.axis("m1").do("velocity", velocity_rpm=100.0)
    bench.run(ms=SOON_MS)
    state = axis.state()
    assert (state.is_moving, state.is_under_way, state.keeps_angle, state.off_by_deg) == (
        True,
        False,
        False,
        0.0,
    )
    bench.axis("m1").do("disable")
    bench.run(ms=1)
    assert (axis.state().is_moving, axis.state().is_on) == (False, False)


def test_a_stepper_says_whether_it_moves() -> None:
    bench, axis = stepper()
    assert (axis.state().is_moving, axis.state().is_under_way) == (False, False)
    axis.move(90.0, 60, bench.now_ns)
    bench.run(ms=SOON_MS)
    state = axis.state()
    assert (state.is_moving, state.is_under_way, state.is_on, state.off_by_deg) == (
        True,
        True,
        True,
        0.0,
    )
    axis.stop("prejudice", 600.0)
    bench.run(ms=SOON_MS)
    assert (axis.state().is_moving, axis.state().is_under_way) == (False, False)


def test_a_board_without_a_shaft_is_beside_those_of_a_run() -> None:
    """The pins of an Uno take part in no motion, and keep no other axis from it."""
    bench = Bench({"bench": "t", "devices": {"u1": {"profile": "uno"}, "s1": {"profile": "sac"}}})
    bench.run_until(ms=NOW_MS)
    axes = TwinAxes(bench._runtime, bench._time.sampler).axes()
    assert axes["u1"].why_not == "it has pins alone, and no shaft"
    assert axes["s1"].why_not is None
