"""Documents of runs: what one may say, and what is planned from it."""

from typing import Any

import pytest

from hil.config import ConfigError
from hil.firmware.set_point_paths import at, length_ns
from hil.runs import Plan, RunTextError, all_problems, parse_run, plan_run, run_from_data
from hil.runs.plan import Level, Move
from hil.vocab.axis import AxisNow

SERVO = AxisNow(0.0, True, ("position_deg", "yw"), ("D3", "step"))
STEPPER = AxisNow(0.0, False, ("position_deg",), ("sync",))
AXES = {"m1": SERVO, "m2": SERVO, "s1": STEPPER}


def plan(*steps: dict[str, Any], axes: dict[str, Any] | None = None, **top: Any) -> Plan:
    data = {"run": "r", "axes": axes or {"m1": {}, "m2": {}, "s1": {}}, "steps": list(steps)} | top
    return plan_run(*run_from_data(data), AXES)


def problems(*steps: dict[str, Any], **rest: Any) -> str:
    with pytest.raises(ConfigError) as refused:
        plan(*steps, **rest)
    return str(refused.value)


def test_axes_of_a_move_end_together_and_others_stand() -> None:
    made = plan({"move": {"m1": 360.0}}, {"move": {"m1": 0.0, "m2": 10.0}})
    (phrase,) = made.phrases
    for name in ("m1", "m2"):
        assert length_ns(phrase.paths[name]) == phrase.duration_ns
    middle_ns = phrase.marks[1][0]
    assert at(phrase.paths["m1"], middle_ns)[0] == pytest.approx(360)
    assert at(phrase.paths["m2"], middle_ns - 1)[0] == 0
    assert at(phrase.paths["m2"], phrase.duration_ns) == (10.0, 0.0)
    assert made.ends_deg == {"m1": 0.0, "m2": 10.0, "s1": 0.0}


def test_limits_are_kept_all_the_way() -> None:
    rules = {"velocity_rpm": 50.0, "acceleration_rpm_per_s": 300.0, "jerk_rpm_per_s2": 3000.0}
    made = plan({"move": {"m1": 200.0}}, {"line": {"m1": 0.0, "m2": 90.0}}, axes={"m1": rules, "m2": rules})
    for path in made.phrases[0].paths.values():
        for piece in path:
            for into_ns in (0, piece.duration_ns // 2, piece.duration_ns):
                assert abs(piece.after(into_ns)[1]) <= 300 * (1 + 1e-9)
            assert abs(piece.per_s2) <= 1800 * (1 + 1e-9)
            assert abs(piece.per_s3) <= 18000 * (1 + 1e-9)


def test_a_line_is_straight() -> None:
    (phrase,) = plan({"line": {"m1": 90.0, "m2": -45.0}}).phrases
    for part in range(11):
        when_ns = phrase.duration_ns * part // 10
        first, second = (at(phrase.paths[name], when_ns)[0] for name in ("m1", "m2"))
        assert second == pytest.approx(-first / 2, abs=1e-6)


def test_a_spline_goes_through_its_points_at_their_times() -> None:
    points = [{"at_s": 1.0, "m1": 30.0}, {"at_s": 1.5, "m1": 20.0}, {"at_s": 3.0, "m1": 60.0}]
    (phrase,) = plan({"spline": points}).phrases
    assert phrase.duration_ns == 3_000_000_000
    for point in points:
        assert at(phrase.paths["m1"], round(point["at_s"] * 1e9))[0] == pytest.approx(point["m1"], abs=1e-6)


def test_a_given_time_is_kept() -> None:
    (phrase,) = plan({"move": {"m1": 90.0}, "in_s": 1.25}).phrases
    assert phrase.duration_ns == 1_250_000_000


def test_repetitions_are_done_in_their_order() -> None:
    made = plan(
        {"label": "a", "move_by": {"m1": 1.0}},
        {"move_by": {"m1": 10.0}},
        {"repeat": {"label": "a", "times": 3}},
    )
    assert made.steps == 8
    assert made.ends_deg["m1"] == 44


def test_a_stepper_starts_with_the_servos_and_takes_about_as_long() -> None:
    made = plan({"move": {"m1": 180.0, "s1": 90.0}}, {"move": {"m1": 0.0}})
    first, second = made.phrases
    (event,) = first.events
    assert isinstance(event, Move)
    assert (event.at_ns, event.axis, event.position_deg) == (0, "s1", 90)
    turns_s = 90 / (event.velocity_rpm * 6)
    assert turns_s <= first.duration_ns / 1e9 <= 2 * turns_s
    assert first.awaited == {"s1"}
    assert second.paths.keys() == {"m1"}


def test_pins_and_waits() -> None:
    made = plan(
        {"move": {"m1": 10.0}},
        {"pins": {"m1.D3": 1}},
        {"wait_until": {"axis": "m1", "field": "yw", "above": 9.0}},
        {"dwell_s": 0.5},
    )
    first, second = made.phrases
    assert first.events == (Level(first.duration_ns, "m1", "D3", 1),)
    assert first.wait is not None
    assert second.duration_ns == 500_000_000


BAD: list[tuple[dict[str, Any], str]] = [
    ({"move": {"m9": 1.0}}, "'m9' is none of the run's axes"),
    ({"move": {"m1": 1e9}}, "steps.0.move.m1"),
    ({"move": {"m1": float("nan")}}, "finite"),
    ({"move": {}}, "nothing in it"),
    ({"line": {"m1": 1.0, "s1": 1.0}}, "s1 makes ramps of its own"),
    ({"move": {"m1": 90.0}, "in_s": 0.01}, "write 0."),
    ({"move": {"s1": 90.0}, "in_s": 0.01}, "s1 cannot be so quick"),
    ({"dwell_s": 1.0, "in_s": 1.0}, "in_s is for moves"),
    ({"dwell_s": -1.0}, "dwell_s"),
    ({"spline": [{"m1": 1.0}, {"m2": 1.0}]}, "the same axes"),
    ({"spline": [{"m1": 1.0, "at_s": 1.0}, {"m1": 2.0}]}, "at_s"),
    ({"spline": [{"m1": 1.0, "at_s": 1.0}, {"m1": 2.0, "at_s": 1.0}]}, "later time"),
    ({"spline": [{"m1": 90.0, "at_s": 0.01}]}, "the limit is"),
    ({"spline": [{"m1": "far"}]}, "angles are wanted"),
    ({"wait_until": {"axis": "m1", "field": "yv", "above": 1.0}}, "has no 'yv'"),
    ({"wait_until": {"axis": "m1", "field": "yw"}}, "neither above nor below"),
    ({"wait_until": {"axis": "m7", "field": "yw", "above": 1.0}}, "'m7' is none"),
    ({"pins": {"m1.D9": 1}}, "has no input 'D9'"),
    ({"pins": {"m1.D3": 2}}, "steps.0.pins"),
    ({"repeat": {"label": "x", "times": 1}}, "no step before has the label 'x'"),
    ({}, "a step does one thing"),
    ({"path": {"axes": ["m1"], "rows": "1 0"}}, "row 1: 2 numbers; a row has 3: seconds, begin, m1"),
    ({"path": {"axes": ["m1"], "rows": "1 0 x"}}, "row 1: 'x' is no number"),
    (
        {"path": {"axes": ["m1"], "rows": "0 0 9"}},
        "row 1: 0 s is no time of a row (it takes 0.000001",
    ),
    ({"path": {"axes": ["m1"], "rows": "1 3 9"}}, "row 1: it begins with 3 times its mean speed"),
    ({"path": {"axes": ["m1"], "rows": "1 0 nan"}}, "row 1: nan is no angle"),
    ({"path": {"axes": ["m1"], "rows": "1 0 900\n1 2 0"}}, "row 1: m1: 300 rpm; its limit is 60"),
    ({"path": {"axes": ["m1"], "rows": ".01 0 1\n.01 2 2"}}, "row 1: m1: 3333 rpm/s; its limit is 600"),
    ({"path": {"axes": ["m1"], "rows": "1 1 300\n1 2 400"}}, "its speed changes at once by 50 rpm"),
    ({"path": {"axes": ["m1"], "rows": "1 0 100"}}, "it ends with 33.33 rpm: `corner_s` allows 6"),
    ({"path": {"axes": ["m1", "m1"], "rows": ""}}, "m1 is there twice"),
    ({"path": {"axes": ["s1"], "rows": ""}}, "s1 makes ramps of its own, and keeps to no path"),
    ({"path": {"axes": ["m1"], "rows": "1 0 2000000"}}, "2e+06 is no angle"),
    ({"move": {"m1": 1.0}, "dwell_s": 1.0}, "a step does one thing"),
    ({"mov": {"m1": 1.0}}, "did you mean"),
]


@pytest.mark.parametrize(("step", "said"), BAD, ids=[f"{i}-{said[:16]}" for i, (_, said) in enumerate(BAD)])
def test_what_cannot_be_done_is_said(step: dict[str, Any], said: str) -> None:
    assert said in problems(step)


def test_all_problems_are_listed_with_their_places() -> None:
    text = """
run: bad
axes:
  m1: {max_deg: 50}
  m2: {}
steps:
  - move: {m1: 90}
  - line: {m2: 10, s1: 1}
"""
    with pytest.raises(ConfigError) as refused:
        plan_run(*parse_run(text, "bad.yaml"), AXES)
    assert str(refused.value).splitlines() == [
        "bad.yaml:7:16: steps.0.move.m1: m1 may not go to 90 deg (its range is -1000000 to 50)",
        """bad.yaml:8:24: steps.1.line.s1: 's1' is none of the run's axes (known are: m1, m2)""",
    ]


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ({"move": {"m9": 1.0}}, "steps.0.move.m9: 'm9' is none of the run's axes (known are: m1, m2, s1)"),
        ({"move": {"m1": 99.0}}, "steps.0.move.m1: m1 may not go to 99 deg (its range is -1000000 to 50)"),
    ],
)
def test_a_repeated_step_that_cannot_be_done_is_said_once(step: dict[str, Any], said: str) -> None:
    steps = [{"label": "a"} | step, {"move": {"m1": 7.0}}, {"repeat": {"label": "a", "times": 3}}]
    run = {"run": "r", "axes": {"m1": {"max_deg": 50.0}, "m2": {}, "s1": {}}, "steps": steps}
    with pytest.raises(ConfigError) as refused:
        plan_run(*run_from_data(run), AXES)
    assert str(refused.value).endswith(said)
    assert len(str(refused.value).splitlines()) == 1


def test_rows_of_a_path_have_their_places() -> None:
    text = """
run: bad
axes: {m1: {max_deg: 50}}
steps:
  - path:
      axes: [m1]
      rows: |
        1 0 10

        1 1 30
        1 what 90
        1 2
"""
    with pytest.raises(ConfigError) as refused:
        plan_run(*parse_run(text, "bad.yaml"), AXES)
    assert str(refused.value).splitlines() == [
        "bad.yaml:11:11: steps.0.path.rows: 'what' is no number (write a number)",
        "bad.yaml:12:9: steps.0.path.rows: 2 numbers; a row has 3: seconds, begin, m1 (write all of them)",
    ]
    with pytest.raises(ConfigError) as refused:
        plan_run(*parse_run(text.replace("what", "1").replace("1 2\n", "1 2 90\n"), "bad.yaml"), AXES)
    assert [line[:18] for line in str(refused.value).splitlines()] == [
        "bad.yaml:11:13: st",
        "bad.yaml:12:13: st",
    ]


def test_a_path_goes_through_its_rows_at_their_times() -> None:
    made = plan(
        {"move": {"m1": 0.0, "m2": 0.0}},
        {"path": {"axes": ["m2", "m1"], "rows": "0.5 0 10 5\n0.25 1 20 10\n0.5 2 30 15\n"}},
        {"dwell_s": 1.0},
    )
    _, path, dwell = made.phrases
    assert [phrase.duration_ns for phrase in made.phrases[1:]] == [1_250_000_000, 1_000_000_000]
    assert dwell.paths == {}
    for name, share in (("m2", 1.0), ("m1", 0.5)):
        places = [at(path.paths[name], ms * 1_000_000) for ms in (0, 250, 500, 625, 750, 1000, 1250)]
        assert [r for r, _ in places] == pytest.approx([share * r for r in (0, 2.5, 10, 15, 20, 27.5, 30)])
        assert [v for _, v in places] == pytest.approx([share * v for v in (0, 20, 40, 40, 40, 20, 0)])


def test_an_axis_that_cannot_take_part_is_said() -> None:
    run = {"run": "r", "axes": {"m1": {}}, "steps": [{"move": {"m1": 1.0}}]}
    off = {"m1": AxisNow(0.0, True, why_not="its control loop is off", remedy="`hil axis m1 enable` first")}
    with pytest.raises(
        ConfigError, match=r"axes\.m1: its control loop is off \(`hil axis m1 enable` first\)"
    ):
        plan_run(*run_from_data(run), off)


def test_endless_repetitions_are_refused() -> None:
    steps = ({"label": "a", "dwell_s": 0.0}, *({"repeat": {"label": "a", "times": 9000}} for _ in range(2)))
    assert "10000 steps or more" in problems(*steps)


REAL_SERVO = AxisNow(12.5, True, tells_position=False)
REAL_STEPPER = AxisNow(0.0, False, tells_position=False)


def with_real(*steps: dict[str, Any], **rules: Any) -> Plan:
    data = {"run": "r", "axes": {"m1": {}, "m2": rules, "s1": {}}, "steps": list(steps)}
    axes = {"m1": SERVO, "m2": REAL_SERVO, "s1": REAL_STEPPER}
    return plan_run(*run_from_data(data), axes)


def test_a_phrase_waits_for_the_last_word_of_real_servos() -> None:
    made = with_real({"line": {"m1": 90.0, "m2": 90.0}}, {"move": {"s1": 9.0}}, {"move": {"m1": 0.0}})
    assert [phrase.awaited for phrase in made.phrases] == [{"m2", "s1"}, set()]
    assert at(made.phrases[0].paths["m2"], 0)[0] == 12.5


def test_a_benchs_configuration_is_no_run() -> None:
    with pytest.raises(ConfigError) as refused:
        parse_run("# lab\nbench: lab\ndevices: {m1: {profile: mechaduino}}\n", "lab.yaml")
    said = "this is a bench's configuration, not a run (`hil serve lab.yaml` starts the bench)"
    assert str(refused.value) == f"lab.yaml:2:1: bench: {said}"


def test_what_a_real_board_cannot_do_is_found() -> None:
    for steps, rules, said in (
        ([{"line": {"s1": 9.0}}], {}, "s1 makes ramps of its own"),
        ([{"pins": {"m2.D3": 1}}], {}, "m2 has no input 'D3' (there are none)"),
        ([{"dwell_s": 1.0}], {"following_error_deg": 5.0}, "axes.m2.following_error_deg: m2 is a real board"),
    ):
        with pytest.raises(ConfigError) as refused:
            with_real(*steps, **rules)
        assert said in str(refused.value)


@pytest.mark.parametrize(("said", "means"), [("controlled", "grace"), ("immediate", "prejudice")])
def test_ways_to_stop_have_two_words_each(said: str, means: str) -> None:
    data = {"run": "r", "axes": {"m1": {}}, "on_fault": said, "steps": [{"dwell_s": 0.1}]}
    document, _ = run_from_data(data)
    assert document.on_fault == means


def test_all_problems_of_a_text_and_of_its_bench_are_listed_at_once() -> None:
    run = {
        "run": "r",
        "axes": {"m1": {"velocity_rpm": -1}, "m9": {}, "m2": {}},
        "steps": [{"moov": {"m1": 1.0}}, {"move": {"m1": 1.0, "m7": 2.0}}, {"pins": {"m2.nix": 1}}],
    }
    axes = {"m1": SERVO, "m2": SERVO}
    with pytest.raises(RunTextError) as caught:
        run_from_data(run)
    said = str(all_problems(caught.value, axes))
    for part in ("velocity_rpm", "there is no device 'm9'", "moov", "'m7' is none of", "no input 'nix'"):
        assert part in said, said
    del run["axes"]["m1"]["velocity_rpm"]
    run["steps"][0] = {"wait_until": {"axis": "m9", "field": "any", "above": 1.0}}
    with pytest.raises(ConfigError) as planned:
        plan_run(*run_from_data(run), axes)
    said = str(planned.value)
    assert "there is no device 'm9'" in said
    assert "'m7' is none of" in said
    assert "any" not in said, "what a device has that there is not is not known"


def test_rows_have_a_limit_with_their_repetitions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hil.runs.planner.ROWS", 8)
    path = {"label": "again", "path": {"axes": ["m1"], "rows": "1 0 0.1\n1 2 0.2\n1 0 0.1\n1 2 0"}}
    plan(path, {"repeat": {"label": "again", "times": 1}})
    said = problems(path, {"repeat": {"label": "again", "times": 9000}})
    assert "the run has over 8 rows up to here, repetitions counted (repeat less" in said
    assert len(said) < 300
