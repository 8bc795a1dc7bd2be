"""Speeds along a path, against the axes' limits, and the load of a line."""

from itertools import pairwise
from random import Random
from time import process_time

import pytest
from small_mill import mill, planned, said

from hil.gcode.canonical import Feed, Point, Settings, Straight, TextPlace
from hil.gcode.reader import read_program
from hil.toolpath.line_load import line_load
from hil.toolpath.path_plan import plan_path, plan_program


def segments_of(plan):
    for each in plan.stretches:
        here = each.stretch.begin
        for segment in each.segments(plan.machine):
            yield segment, tuple(b - a for a, b in zip(here, segment.end, strict=True))
            here = segment.end


def random_path(seed, count=200):
    random = Random(seed)
    here = [0.0, 0.0, 0.0]
    lines = ["G21 G90 F2000 G1"]
    for _ in range(count):
        size = random.choice((0.01, 0.3, 5, 40))
        here = [min(max(h + random.uniform(-size, size), -90), 90) for h in here]
        lines.append("X{:.4f} Y{:.4f} Z{:.4f}".format(*here) + f" F{random.choice((300, 2000, 9000))}")
    return "\n".join(lines)


@pytest.mark.parametrize("seed", range(4))
def test_speeds_and_their_steps_stay_within_the_limits(seed):
    machine = mill()
    plan = planned(random_path(seed), machine)
    stretch = next(plan.stretches)
    assert stretch.is_streamed
    speeds, lasts = [(0.0,) * 3], [machine.segment_s]
    total = [0.0] * 3
    for segment, way in segments_of(plan):
        speeds.append(tuple(w / segment.duration_s for w in way))
        lasts.append(segment.duration_s)
        total = [a + b for a, b in zip(total, way, strict=True)]
    speeds.append((0.0,) * 3)
    lasts.append(machine.segment_s)
    assert total == pytest.approx(stretch.end, abs=1e-9)
    assert sum(lasts[1:-1]) == pytest.approx(stretch.duration_s)
    for axis in range(3):
        assert max(abs(speed[axis]) for speed in speeds) <= 50 * (1 + 1e-9)
        for (a, b), (la, lb) in zip(pairwise(speeds), pairwise(lasts), strict=True):
            # Acceleration along the chords, and as much again at a corner between them.
            allowed = 200 * (min(la, 1.6 * 0.05) / 2 + min(lb, 1.6 * 0.05) / 2 + machine.segment_s)
            assert abs(b[axis] - a[axis]) <= allowed * (1 + 1e-9)
    assert min(lasts) >= machine.segment_s * 0.6


def test_a_line_takes_its_time():
    plan = planned("G21 F1200\nG1 X60 Y80", mill())
    assert plan.duration_s == pytest.approx(100 / 20 + 20 / 250)  # 200 mm/s2 for Y is 250 along the path
    assert plan.length(is_rapid=False) == 100
    assert planned("G0 X60", mill()).duration_s == pytest.approx(60 / 50 + 50 / 200)
    slow = planned("G0 X60", mill(rapid_mm_per_min=600))
    assert slow.duration_s == pytest.approx(6 + 10 / 200)
    assert said(slow.remarks) == []


def test_a_feed_of_a_rotary_axis():
    plan = planned("F3600\nG1 A30", mill("xa"))
    assert plan.duration_s == pytest.approx(30 / 60 + 60 / 300)


def test_dwells_count():
    assert planned("G4 P1.5\nG0 X0", mill()).duration_s == 1.5


def test_stops_are_taken_where_they_are_quicker():
    """A sharp corner of long lines costs a stop more than it costs to slow down."""
    plan = planned("G21 G64 F2400\nG1 X50\nY50\nX0\nY0", mill("xy"))
    assert [each.is_streamed for each in plan.stretches] == [True]
    back = planned("G21 G64 F2400\nG1 X50\nX0", mill("xy"))
    assert next(back.stretches).speeds[0].end_per_s <= 200 * 0.05


def test_samples_pass_through_the_ends():
    plan = planned("G21 F1200\nG1 X10\nG3 X20 Y10 J10\nG1 Y30", mill("xy"))
    stretch = next(plan.stretches)
    samples = list(stretch.samples(0.01))
    assert samples[0][:2] == (0.0, (0.0, 0.0))
    assert samples[-1][:2] == (pytest.approx(stretch.duration_s), (20.0, 30.0))
    assert [at for at, _, _ in samples[:3]] == [0.0, 0.01, 0.02]
    assert {place.line for _, _, place in samples} == {2, 3, 4}


def test_a_line_that_cannot_keep_up_is_told_with_figures():
    text = "G21 G61 F3000 G1\n" + "\n".join(f"X{n * 0.05:.3f} Y{n % 2 * 0.05:.3f}" for n in range(1, 200))
    load = planned(text, mill("xy", segment_ms=10)).line_load
    assert not load.keeps_up
    assert load.needed_per_s > load.possible_per_s
    fine = planned(text, mill("xy")).line_load
    assert fine.keeps_up
    assert fine.needed_per_s <= 42


def test_three_axes_at_50_ms_keep_up_at_38400_baud():
    text = "G21 G61 F3000 G1\n" + "\n".join(f"X{n} Y{n % 2} Z{n % 3}" for n in range(1, 100))
    machine = mill()
    plan = planned(text, machine)
    segments = [segment for segment, _ in segments_of(plan)]
    load = line_load(machine, (0.0, 0.0, 0.0), segments)
    assert load.keeps_up
    assert 40 <= load.needed_per_s <= 75 < 94 < load.possible_per_s


@pytest.mark.thorough
def test_ten_thousand_motions_in_a_second():
    motions = [
        Straight(TextPlace(n, 1), False, Point(x=n % 100 * 0.5, y=n % 7 * 0.3), Feed("per_minute", 1200.0))
        for n in range(1, 10_001)
    ]
    begin_s = process_time()
    plan = plan_path(motions, mill(), "d")
    assert plan.line_load
    assert process_time() - begin_s < 1.0


def listed(text):
    """Places and messages of all problems of a program for a mill from -100 to 100 mm."""
    program = read_program(text.encode(), Settings("p.ngc"))
    assert program.problems
    assert not program.motions
    return [(p.line, p.message) for p in plan_program(program, mill(), "p.ngc").problems]


def test_problems_of_words_and_of_ways_are_listed_at_once():
    found = listed("G21 G90 G17 F600\nG1 X500\nG1 X10 Q7\nG1 X20 Y20\nG2 X30 Y20 I99 J0\nG1 Y700\nM2\n")
    assert [line for line, _ in found] == [2, 3, 5, 6], found


def test_a_way_that_a_problem_has_made_unknown_is_none():
    inch = listed("G21 G90 F600\nG20 Q7\nG1 X50\nG1 X500\nM2\n")
    assert [line for line, _ in inch] == [2], inch
    step = listed("G21 G91 F600\nG1 X60 Q7\nG1 X60\nG1 X60\nM2\n")
    assert [line for line, _ in step] == [2], step


def test_where_a_program_begins_is_not_known_without_a_machine():
    text = b"G21 G90 G17 F600\nG2 X30 Y20 I99 J0\nG1 X10 Q7\nM2\n"
    assert [p.line for p in read_program(text, Settings()).problems] == [2, 3]
    assert [p.line for p in read_program(text, Settings(), is_somewhere=True).problems] == [3]
