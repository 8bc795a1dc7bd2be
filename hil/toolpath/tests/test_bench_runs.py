"""Programs as runs of a bench: what its axes follow, and how far that is from what was asked."""

import json
from dataclasses import replace
from random import Random

import pytest
from small_mill import motions_of

from hil.firmware.set_point_paths import at
from hil.runs import parse_run, plan_run
from hil.testing import Bench
from hil.toolpath.bench_runs import BenchRuns, machine_problems
from hil.toolpath.deviation import asked_path, deviation
from hil.toolpath.machine import machine_from_data
from hil.toolpath.path_plan import plan_path
from hil.vocab.axis import AxisNow
from hil.vocab.parameters import Parameter

LINEAR = {
    "deg_per_mm": 9,
    "min_mm": -60,
    "max_mm": 120,
    "velocity_mm_per_min": 6000,
    "acceleration_mm_per_s2": 1000,
}
AXES = {"m1": AxisNow(0.0, True, (), ("D3",)), "m2": AxisNow(0.0, True), "s1": AxisNow(0.0, False)}


def plotter(**changes):
    """Machine of two servos and a SAC."""
    axes = {"x": {"axis": "m1"} | LINEAR, "y": {"axis": "m2", "is_reversed": True} | LINEAR}
    axes["z"] = {"axis": "s1", "deg_per_mm": 45} | {k: v for k, v in LINEAR.items() if k != "deg_per_mm"}
    axes["z"] |= {"velocity_mm_per_min": 600, "acceleration_mm_per_s2": 100}
    return machine_from_data({"machine": "plotter", "segment_ms": 10, "axes": axes} | changes)


def runs_of(text, machine=None, axes=AXES):
    plan = plan_path(motions_of(text), machine or plotter(), "drawing.ngc")
    assert not plan.problems
    return plan, BenchRuns(plan, axes)


def steps(run):
    return [next(iter(step)) for step in json.loads(run.text)["steps"]]


def random_program(seed, count):
    random = Random(seed)
    here, lines = [0.0, 0.0], ["G21 G90 G64 P0.05"]
    for _ in range(count):
        size = random.choice((0.01, 0.3, 5, 40))
        here = [min(max(each + random.uniform(-size, size), -50), 70) for each in here]
        word = random.choice(("G0", "G1", "G1", "G1"))
        lines.append(f"{word} X{here[0]:.4f} Y{here[1]:.4f} F{random.choice((300, 2000, 9000))}")
    return "\n".join(lines)


@pytest.mark.parametrize("seed", range(4))
def test_a_run_of_any_program_keeps_its_limits_and_its_path(seed):
    plan, made = runs_of(random_program(seed, 150))
    (run,) = made.runs
    planned = plan_run(*parse_run(run.text, "run"), AXES)  # it checks speeds, accelerations and corners
    (phrase,) = planned.phrases
    assert phrase.duration_ns / 1e9 == pytest.approx(run.duration_s, abs=1e-4)
    assert run.duration_s == pytest.approx(sum(each.duration_s for each in plan.stretches), rel=1e-4)
    times_ns = range(0, phrase.duration_ns, phrase.duration_ns // 1500)
    x, y, _ = plan.machine.axes
    followed = [
        (
            at(phrase.paths["m1"], at_ns)[0] / x.motor_deg_per_unit,
            at(phrase.paths["m2"], at_ns)[0] / y.motor_deg_per_unit,
            0.0,
        )
        for at_ns in times_ns
    ]
    asked = asked_path(motions_of(random_program(seed, 150)), plan.machine)
    assert 0.001 < deviation(asked, followed).largest < 0.05
    assert run.timeline == sorted(run.timeline)
    assert len(run.timeline) > 100


def test_a_circle_is_followed_within_its_tolerance_and_the_servos_error():
    """A circle of 50 mm radius at 1200 mm/min."""
    text = "G21 G90 G17\nF1200\nG3 X50 Y0 R60\nG3 I-50\n"
    servo = {"profile": "mechaduino", "flash": {"table": "identity"}}
    made = Bench({"bench": "t", "devices": {"m1": servo, "m2": servo, "s1": {"profile": "sac"}}})
    made.run(4100)
    for name in ("m1", "m2"):
        made.axis(name).do("enable")
    made.run(100)
    made.perform({"run": "zero", "axes": {"m1": {}, "m2": {}}, "steps": [{"move": {"m1": 0.0, "m2": 0.0}}]})
    made.run(100)
    machine = plotter(tolerance_mm=0.05)
    _, runs = runs_of(text, machine)
    recordings = [made.axis(name).record("r", "position_deg", interval_ms=1) for name in ("m1", "m2")]
    progress = made.perform(runs.runs[0].text)
    assert progress.state == "done", progress.why
    scales = [axis.motor_deg_per_unit for axis in machine.axes]
    asked = [place[:2] for place in asked_path(motions_of(text), machine)]
    rows = list(zip(*(each.rows for each in recordings), strict=True))
    off = {}
    for column, name in ((1, "set-points"), (2, "shafts")):
        places = [
            tuple(row[column] / scale for row, scale in zip(pair, scales, strict=False)) for pair in rows
        ]
        off[name] = deviation(asked, places).largest
    error_mm = max(progress.axes[name].error_max_deg for name in ("m1", "m2")) / 9
    assert 0.0002 < off["set-points"] < 0.05
    assert 0.002 < off["shafts"] < off["set-points"] + 1.5 * error_mm
    assert error_mm < 0.08


def test_pauses_make_several_runs_and_dwells_and_pins_are_steps():
    switches = {"spindle": {"pin": "m1.D3", "level": 0}, "flood": {"node": 4, "start": "o1", "stop": "o0"}}
    text = "M3 S100\nG0 X10\nM0\nM8\nG4 P0.5\nG1 Y5 F600\nM5\nM1"
    plan, made = runs_of(text, plotter(switches=switches))
    assert [steps(run) for run in made.runs] == [["pins", "path"], ["dwell_s", "path", "pins"]]
    assert [run.pause and run.pause.place.line for run in made.runs] == [3, None]
    assert json.loads(made.runs[0].text)["steps"][0] == {"pins": {"m1.D3": 0}}
    assert [str(each) for each in made.remarks] == [
        "drawing.ngc:4:1: a node of the line switches flood, which runs do not reach"
        " (nothing is switched; add a pin: to switches.flood)"
    ]
    assert sum(run.duration_s for run in made.runs) == pytest.approx(plan.duration_s, rel=1e-4)


def test_axes_with_ramps_of_their_own_are_sent_from_end_to_end():
    _, made = runs_of("G1 X10 F600\nX20\nX30 Z5\nX40\nY10")
    (run,) = made.runs
    assert steps(run) == ["path", "move", "path"]
    assert json.loads(run.text)["steps"][1]["move"] == {"m1": 270.0, "s1": 225.0}
    assert "Z is moved by ramps of its board, s1" in str(made.remarks[0])
    plan_run(*parse_run(run.text, "run"), AXES)


def test_a_path_that_is_too_long_for_a_run_is_said(monkeypatch):
    monkeypatch.setattr("hil.toolpath.bench_runs.DOCUMENT_BYTES", 2000)
    _, made = runs_of(random_program(1, 60))
    assert "the path is too long: " in str(made.problems[0])
    assert "add a pause (M0)" in str(made.problems[0])


def test_a_long_path_is_several_runs_that_end_where_the_next_begins(monkeypatch):
    text = random_program(3, 400).replace("G0", "G1")
    monkeypatch.setattr("hil.toolpath.bench_runs.PART_CHARACTERS", 6000)
    plan, made = runs_of(text)
    assert not made.problems
    assert len(made.runs) > 3
    assert {run.pause for run in made.runs} == {None}
    assert any("the machine stands here, and goes on" in str(each) for each in made.remarks)
    axes, end_deg = AXES, {}
    followed = []
    for number, run in enumerate(made.runs, 1):
        assert len(run.text) < 6000 + 1500
        assert json.loads(run.text)["run"] == f"plotter_{number}"
        axes = {name: replace(axis, position_deg=end_deg.get(name, 0.0)) for name, axis in axes.items()}
        planned_run = plan_run(*parse_run(run.text, "run"), axes)
        end_deg = dict(planned_run.ends_deg)
        followed.append(end_deg["m1"] / 9)
    assert followed[-1] == pytest.approx([*plan.stretches][-1].stretch.chords[-1].end[0], abs=1e-5)
    assert [run.timeline[0][0] for run in made.runs] == [0.0] * len(made.runs)


def test_what_a_bench_lacks_is_said():
    machine = plotter()
    assert machine_problems(machine, "m.yaml", AXES) == []
    (problem,) = machine_problems(machine, "m.yaml", {name: AXES[name] for name in ("m1", "m2")})
    assert str(problem) == "m.yaml: the bench has no axis s1, which is to move Z (there are m1, m2)"


def test_limits_beyond_a_board_are_problems_of_the_machine():
    bound = {"velocity_rpm": Parameter("velocity_rpm", "", minimum=1, maximum=2000, is_whole=True)}
    axes = AXES | {"s1": AxisNow(0.0, False, bounds=bound)}
    at_most = 2000 * 360 / 45  # mm per minute
    for velocity, problems in ((at_most, 0), (at_most + 1, 1)):
        z = {"axis": "s1", "deg_per_mm": 45} | {k: v for k, v in LINEAR.items() if k != "deg_per_mm"}
        fast = plotter(axes={"x": {"axis": "m1"} | LINEAR, "z": z | {"velocity_mm_per_min": velocity}})
        found = machine_problems(fast, "m.yaml", axes)
        assert len(found) == problems, found
        if problems:
            assert "Z is to have 2000 rpm; s1 takes 1 to 2000 rpm" in str(found[0])
        else:
            _, made = runs_of("G0 Z10", fast, axes)
            assert json.loads(made.runs[0].text)["axes"]["s1"]["velocity_rpm"] == 2000
