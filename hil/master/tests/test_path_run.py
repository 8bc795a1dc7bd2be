"""Programs in G-code over a line of SACs in simulated time: from the text to the pulses."""

import pytest

from device_profiles.sac.board import PROFILE
from device_profiles.sac.line_nodes import NODES
from hil.gcode.reader import read_program
from hil.master.path_run import path_run, rad_per_s2
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import RunState
from hil.testing.line_masters import attend
from hil.toolpath.machine import Machine, parse_machine
from hil.toolpath.node_phrases import NodePhrases
from hil.toolpath.path_plan import plan_path

TAP = "bus0.master"
LIMITS = "min_mm: -200, max_mm: 200, velocity_mm_per_min: 1500, acceleration_mm_per_s2: 200"
MACHINE = f"""
machine: mill
line: bus0.master
rapid_mm_per_min: 1500
axes:
  x: {{node: 4, steps_per_mm: 20, {LIMITS}}}
  y: {{node: 5, steps_per_mm: 20, {LIMITS}}}
switches:
  flood: {{node: 6, start: m50v300a999d999, stop: m-50v300a999d999}}
"""
PULSES_PER_MM = 40
DEG_PER_PULSE = 0.9


@pytest.fixture
def rig(segment):
    bench = segment(3)
    return bench, NodeMaster(NODES), parse_machine(MACHINE, "mill.yaml")


def run_of(master: NodeMaster, machine: Machine, text: bytes, **given):
    program = read_program(text)
    assert program.problems == ()
    plan = plan_path(program.motions, machine, "part.ngc")
    assert plan.problems == []
    phrases = NodePhrases(machine, PROFILE.paths)
    return path_run(master, machine, phrases.of(plan), **given), plan, phrases


def place_mm(bench) -> tuple[float, float]:
    """Place of x and y by their pulses."""
    turned = [bench.axis(f"s{node}").snapshot().commanded_deg for node in (4, 5)]
    return tuple(round(deg / DEG_PER_PULSE / PULSES_PER_MM, 3) for deg in turned)


def test_a_program_ends_where_it_says(rig):
    bench, master, machine = rig
    text = b"G21 G90\nM8\nG0 X10 Y5\nG1 X30 Y20 F900\nG2 X30 Y20 I-10 J0\nG4 P0.3\nM9\nG1 X0 Y0\nM2\n"
    run, plan, _ = run_of(master, machine, text)
    run.start(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.is_over)
    assert run.state is RunState.ENDED, run.why
    assert place_mm(bench) == (0.0, 0.0)
    assert bench.axis("s6").snapshot().commanded_deg == 0
    assert plan.duration_s < run.report.took_s < plan.duration_s * 1.5 + 2


def test_a_program_pauses_and_goes_on(rig):
    bench, master, machine = rig
    run, _, _ = run_of(master, machine, b"G21\nG1 X10 F900\nM0\nM1\nG1 X20\nM2\n")
    run.start(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.state is RunState.PAUSED)
    assert (place_mm(bench), run.progress(bench.now_ns).line) == ((10.0, 0.0), 3)
    run.resume(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.is_over)
    assert place_mm(bench) == (20.0, 0.0)


def test_a_circle_that_is_paused_in_the_middle_goes_on_to_its_end(rig):
    bench, master, machine = rig
    run, _, _ = run_of(master, machine, b"G21 G64 P0.05\nG1 X20 F1200\nG2 X20 Y0 I-20 J0\nM2\n")
    run.start(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.progress(bench.now_ns).done_s > 3)
    run.pause()
    attend(bench, {TAP: run}, lambda: run.state is RunState.PAUSED)
    x_mm, y_mm = place_mm(bench)
    assert x_mm**2 + y_mm**2 == pytest.approx(400, abs=4)
    run.resume(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.is_over)
    assert (run.state, place_mm(bench)) == (RunState.ENDED, (20.0, 0.0))


def test_a_stop_with_grace_says_where_the_axes_are(rig):
    bench, master, machine = rig
    run, _, _ = run_of(master, machine, b"G21 G64 P0.05\nG1 X20 F1200\nG2 X20 Y0 I-20 J0\nM2\n")
    run.start(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.progress(bench.now_ns).done_s > 3)
    run.stop(bench.now_ns)
    attend(bench, {TAP: run}, lambda: run.is_over)
    assert run.state is RunState.STOPPED
    bench.run(ms=300)
    told = [each.pulses for each in run.report.axes]
    assert [pulses / PULSES_PER_MM for pulses in told] == list(place_mm(bench))


def test_a_brake_is_the_acceleration_of_the_machine_at_the_motor(rig):
    _, _, machine = rig
    x = machine.axes[0]
    assert rad_per_s2(x) == pytest.approx(200 * 20 / 200 * 2 * 3.14159265, rel=1e-6)


def test_a_machine_without_nodes_is_refused(rig):
    _, master, _ = rig
    machine = parse_machine(MACHINE.replace("node: 5,", "axis: m1,"), "mill.yaml")
    with pytest.raises(ValueError, match="axes without a node"):
        path_run(master, machine, [])
