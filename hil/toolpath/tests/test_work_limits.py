"""Limits of what planning a program takes, for all of it together."""

import pytest
from small_mill import mill, motions_of, said

from hil.toolpath.motion_check import MOST_CHORDS, arc_pieces
from hil.toolpath.path_plan import LONGEST_STREAM, plan_path

TURNS = "G17 G2 X0 Y0 I10 J0 P10\n"


def test_arcs_have_a_limit_together():
    motions = motions_of("G21 G90 F6000\n" + TURNS * 100)
    plan = plan_path(motions, mill("xy", segment_ms=5), "d.ngc", most_chords=20_000)
    (problem,) = plan.problems
    assert 2 < problem.line < 100
    assert "needs over 20000 straight pieces" in str(problem)
    assert plan.items == []


def test_lines_have_the_same_limit():
    motions = motions_of("G21 G90 F600\n" + "G1 X1\nG1 X0\n" * 6)
    assert plan_path(motions, mill("xy"), "d.ngc", most_chords=12).problems == []
    assert said(plan_path(motions, mill("xy"), "d.ngc", most_chords=11).problems) == [
        "d.ngc:13:1: the path up to here needs over 11 straight pieces"
        " (allow a larger tolerance, or make several programs of it)"
    ]


def test_an_arc_of_any_length_is_counted_and_not_made():
    motions = motions_of("G21 G90 F6000\nG17 G2 X0 Y0 I10 J0 P900000000\n")
    assert arc_pieces(motions[0].end, motions[0], 0.01) > 10**9
    (problem,) = plan_path(motions, mill("xy"), "d.ngc").problems
    assert str(problem).startswith(f"d.ngc:2:5: the path up to here needs over {MOST_CHORDS} straight")


@pytest.mark.parametrize("waits", ["G4 P50000\n", "G1 X100 F0.1\nG0 X0\n"])
def test_a_program_takes_a_day_at_most(waits):
    plan = plan_path(motions_of("G21 G90 F1\n" + waits), mill("xy"), "d.ngc")
    assert plan.problems == []
    plan = plan_path(motions_of("G21 G90 F1\n" + waits * 2), mill("xy"), "d.ngc")
    assert [each.message for each in plan.problems] == ["the program takes over a day up to here"]
    assert plan.problems[0].line > 2
    assert plan.items == []


def test_a_stream_to_nodes_ends_at_some_time():
    text = "G21 G90 F1\nG1 X100\nG1 X0\n"
    assert plan_path(motions_of(text), mill("xy"), "d.ngc").problems == []
    (problem,) = plan_path(motions_of(text), mill("xy", segment_ms=5), "d.ngc").problems
    assert str(problem).startswith("d.ngc:2:1: it is 3.33 hours from here to the next stop (stop within 2.78")
    assert pytest.approx(2.78, abs=0.01) == LONGEST_STREAM * 0.005 / 3600
