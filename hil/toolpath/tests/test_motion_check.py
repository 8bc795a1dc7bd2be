"""Programs against a machine: what it cannot do, with the place of each."""

from itertools import pairwise
from math import cos, dist, hypot, pi, sin

import pytest
from small_mill import mill, motions_of, planned, said

from hil.gcode.canonical import Arc, End, Feed, Point, Straight, TextPlace
from hil.toolpath.motion_check import MOST_PROBLEMS, arc_extremes, arc_points, check_motions
from hil.toolpath.path_plan import plan_path

PLACE, FEED = TextPlace(1, 1), Feed("per_minute", 600.0)


def test_each_problem_has_its_place():
    plan = planned("G21 G90 F100\nG1 X201\n  G1 Y-100.5 Z9\nG0 X-999 A5\nG1 X0 Y0 Z0", mill())
    assert said(plan.problems) == [
        "drawing.ngc:2:1: X would go to 201 mm (write -100 to 200)",
        "drawing.ngc:3:3: Y would go to -100.5 mm (write -100 to 200)",
        "drawing.ngc:4:1: the machine has no axis A (leave A out, or add it to the machine)",
        "drawing.ngc:4:1: X would go to -999 mm (write -100 to 200)",
    ]
    assert plan.items == []


def test_an_arc_that_passes_a_limit_between_its_ends():
    plan = planned("G21 G90 F100\nG0 X190 Y20\nG2 X190 Y-20 J-20\nG17 G3 X150 Y-20 I-20", mill())
    assert said(plan.problems) == ["drawing.ngc:3:1: X would pass 210 mm (write -100 to 200)"]


def test_an_arc_without_an_axis_of_its_plane():
    plan = planned("G21 F100\nG18 G2 X10 Z0 I5", mill("xy"))
    assert "the machine has no axis Z" in said(plan.problems)[0]


@pytest.mark.parametrize(
    ("feed", "expected"),
    [(1e-9, "this motion would take"), (1e9, None)],
)
def test_feeds_that_nobody_means(feed, expected):
    plan = plan_path([Straight(PLACE, False, Point(x=10), Feed("per_minute", feed))], mill(), "d.ngc")
    if expected:
        assert expected in said(plan.problems)[0]
        assert plan.items == []
    else:
        assert said(plan.remarks) == ["d.ngc:1:1: F1e+09 is too fast for X (it is done with 3000 a minute)"]
        assert plan.duration_s == pytest.approx(2 * (10 / 200) ** 0.5)


def test_motions_of_no_length_are_none():
    motions = [Straight(PLACE, rapid, Point(x=5), FEED) for rapid in (False, False, True, False)]
    plan = plan_path([*motions, End(PLACE)], mill(), "d.ngc")
    assert [len(each.stretch.chords) for each in plan.stretches] == [1]


def test_a_tolerance_that_whole_pulses_cannot_keep_is_said_once():
    text = "G21 F600\nG64 P0.002\nG1 X5\nY5\nG61.1 X0\nG64 P0.002 Y0\nX5\nG64 P0.1\nX0\nY5"
    assert said(planned(text, mill()).remarks) == [
        "drawing.ngc:3:1: a tolerance of 0.002 mm is less than 1.25 pulses of an axis"
        " (the path may be 0.00781 mm off; allow that, or use more microsteps)"
    ]


def test_a_feed_for_each_turn_needs_a_spindle():
    straight = Straight(PLACE, False, Point(x=5), Feed("per_revolution", 0.1))
    assert "the spindle does not turn" in said(plan_path([straight], mill(), "d").problems)[0]
    plan = planned("G21 M3 S1000\nG95 F0.1 G1 X10", mill(switches={"spindle": {"pin": "m1.D3"}}))
    assert next(plan.stretches).stretch.chords[0].asked_per_s == pytest.approx(100 / 60)


def test_inverse_time_is_the_time_of_the_motion():
    plan = planned("G21 G93\nG1 X30 F2", mill())
    assert next(plan.stretches).stretch.chords[0].asked_per_s == pytest.approx(1.0)


def test_switches_that_the_machine_lacks_are_told_once():
    plan = planned("M8\nM9\nM8\nM4 S10", mill(switches={"spindle": {"pin": "m1.D3"}}))
    assert [line for line in said(plan.remarks) if "flood" in line] == [
        "drawing.ngc:1:1: the machine has no switch for flood (nothing is switched; add switches.flood:)"
    ]
    assert "this spindle turns one way" in said(plan.problems)[0]


def test_problems_are_many_and_not_endless():
    motions = [Straight(TextPlace(line, 1), False, Point(x=999 + line), FEED) for line in range(1, 5000)]
    assert len(check_motions(motions, mill(), "d").problems) == MOST_PROBLEMS


def arc(begin_deg, sweep_deg, radius=30.0, centre=(10.0, 5.0)):
    def at(deg):
        return Point(centre[0] + radius * cos(deg * pi / 180), centre[1] + radius * sin(deg * pi / 180))

    turns = (1 if sweep_deg > 0 else -1) * max(1, -(-abs(sweep_deg) // 360))
    return at(begin_deg), Arc(PLACE, "xy", at(begin_deg + sweep_deg), centre, int(turns), FEED)


@pytest.mark.parametrize("sweep", [10, 90, 200, 360, 725, -10, -90, -200, -360, -725])
@pytest.mark.parametrize("begin", [0, 37, -120])
def test_points_of_an_arc_are_on_it_and_between_them_within_the_tolerance(begin, sweep):
    start, motion = arc(begin, sweep)
    points = [start, *arc_points(start, motion, 0.01)]
    assert points[-1] == motion.end
    assert all(abs(hypot(p.x - 10, p.y - 5) - 30) < 1e-9 for p in points)
    middles = [hypot((a.x + b.x) / 2 - 10, (a.y + b.y) / 2 - 5) for a, b in pairwise(points)]
    assert 30 - min(middles) <= 0.01 + 1e-9
    assert sum(dist(a, b) for a, b in pairwise(points)) == pytest.approx(30 * abs(sweep) * pi / 180, rel=1e-3)
    extremes = dict.fromkeys((0, 1), (1e9, -1e9)) | {}
    for index, place in arc_extremes(start, motion):
        low, high = extremes[index]
        extremes[index] = min(low, place), max(high, place)
    for index in (0, 1):
        ends = [start[index], motion.end[index]]
        low, high = min(extremes[index][0], *ends), max(extremes[index][1], *ends)
        assert min(p[index] for p in points) == pytest.approx(low, abs=0.02)
        assert max(p[index] for p in points) == pytest.approx(high, abs=0.02)


def test_a_helix_and_a_tiny_arc():
    start = Point(10, 0, 0)
    helix = Arc(PLACE, "xy", Point(10, 0, 6), (0.0, 0.0), 3, FEED)
    points = list(arc_points(start, helix, 0.01))
    assert points[-1] == helix.end
    assert [p.z for p in points] == sorted(p.z for p in points)
    tiny = Arc(PLACE, "xy", Point(1e-9, 0), (5e-10, 0.0), 1, FEED)
    assert len(list(arc_points(Point(), tiny, 0.01))) <= 12


def test_short_pieces_are_joined_within_the_tolerance():
    wave = "\n".join(f"X{number * 0.05:.3f} Y{0.01 * sin(number):.4f}" for number in range(1, 400))
    loose = planned(f"G21 G64 P0.05 F1200\nG1 {wave}", mill())
    exact = planned(f"G21 G61 F1200\nG1 {wave}", mill())
    few, many = (next(plan.stretches).stretch.chords for plan in (loose, exact))
    assert len(many) == 399
    assert len(few) < 40
    assert loose.duration_s < exact.duration_s / 5
    assert few[-1].end == many[-1].end


def test_exact_stop_is_a_stretch_for_each_motion():
    plan = planned("G21 G61.1 F600\nG1 X1\nX2\nX2 Y1", mill())
    assert [len(each.stretch.chords) for each in plan.stretches] == [1, 1, 1]
    assert len(motions_of("G1 F100 X1")) > 0
