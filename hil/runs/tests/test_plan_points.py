"""Points of a plan, as they are drawn before anything moves."""

import pytest
from test_run_plan import plan

from hil.runs import plan_points


def test_the_extremes_of_each_axis_are_there_whatever_the_number_of_points() -> None:
    made = plan({"move": {"m1": 360.0}}, {"dwell_s": 2.0}, {"line": {"m1": -90.0, "m2": 10.0}})
    for most in (10, 100, 5000):
        told = plan_points(made, most)
        way = told["axes"]["m1"]
        assert (min(way["position_deg"]), max(way["position_deg"])) == pytest.approx((-90, 360))
        assert way["at_s"] == sorted(way["at_s"])
        assert way["at_s"][-1] == pytest.approx(told["duration_s"], abs=1e-3)
        assert sum(len(each["at_s"]) for each in told["axes"].values()) <= most + 6
    assert told["is_exact"]
    assert told["axes"]["s1"] == {"at_s": [0.0, told["duration_s"]], "position_deg": [0.0, 0.0]}


def test_steps_stand_with_their_times_and_what_they_do() -> None:
    told = plan_points(
        plan(
            {"label": "on", "pins": {"m1.D3": 1}},
            {"move": {"m1": 36.0}, "in_s": 2.0},
            {"dwell_s": 0.5},
            {"repeat": {"label": "on", "times": 1}},
        ),
        100,
    )
    assert [step[:3] for step in told["steps"]] == [
        [0.0, 0.0, 1], [0.0, 2.0, 2], [2.0, 2.5, 3], [2.5, 2.5, 1], [2.5, 4.5, 2], [4.5, 5.0, 3]
    ]  # fmt: skip
    assert [step[3] for step in told["steps"][:3]] == ["pins m1.D3 1", "move m1 36", "dwell_s 0.5"]


def test_ramps_of_a_boards_own_and_waits_are_drawn_and_said_to_be_about() -> None:
    wait = {"axis": "m1", "field": "position_deg", "above": 1.0}
    told = plan_points(plan({"move": {"s1": 360.0}}, {"wait_until": wait}, {"move": {"m1": 90.0}}), 100)
    assert not told["is_exact"]
    way = told["axes"]["s1"]
    assert (way["position_deg"][0], way["position_deg"][-1]) == (0.0, 360.0)
    assert told["steps"][1][3] == "wait for m1 position_deg"
    assert told["steps"][2][0] == told["steps"][0][1] == 1.0


def test_a_run_of_nothing_and_a_long_one() -> None:
    assert plan_points(plan({"label": "here"}), 50)["duration_s"] == 0
    many = [{"move": {"s1": float(number % 7)}} for number in range(2000)]
    told = plan_points(plan(*many), 400)
    assert (len(told["steps"]), told["steps_left_out"]) == (300, 1700)
    assert max(told["axes"]["s1"]["position_deg"]) == 6
