"""Drawings by both executors: the path asked for, the one that axes follow, and a picture of both."""

import math
from pathlib import Path
from typing import Any

import pytest
from markdown_blocks import ROOT

from device_profiles.sac.board import PROFILE
from device_profiles.sac.line_nodes import NODES
from hil.config import ConfigError
from hil.gcode.canonical import Point, Settings
from hil.gcode.reader import read_program
from hil.master.path_run import path_run
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import RunState
from hil.telemetry.path_picture import parted
from hil.telemetry.picture import FORMATS
from hil.testing import Bench, FollowedPath, attend, draw_by_runs, followed_by
from hil.toolpath.bench_runs import BenchRuns
from hil.toolpath.deviation import asked_path, asked_rapids, deviation, zero_shift_deg
from hil.toolpath.machine import parse_machine
from hil.toolpath.node_phrases import NodePhrases
from hil.toolpath.path_plan import plan_path, plan_program

EXAMPLES = ROOT / "examples/line"
LIMITS = "min_mm: -200, max_mm: 200, velocity_mm_per_min: 1500, acceleration_mm_per_s2: 200"
MILL = f"""
machine: mill
line: bus0.master
axes:
  x: {{node: 4, axis: s4, steps_per_mm: 20, {LIMITS}}}
  y: {{node: 5, axis: s5, steps_per_mm: 20, {LIMITS}}}
"""


def plotter() -> Bench:
    bench = Bench(EXAMPLES / "servos.yaml")
    bench.run(4100)
    for name in ("m1", "m2"):
        bench.axis(name).do("enable")
    bench.run(100)
    return bench


@pytest.mark.long
def test_the_example_is_drawn_by_runs() -> None:
    drawn = draw_by_runs(plotter(), EXAMPLES / "plot.ngc", EXAMPLES / "plotter.yaml")
    assert [progress.state for progress in drawn.progress] == ["done"]
    assert len(drawn.followed) < 20_000  # it takes less than 20 s
    off = drawn.deviation
    assert 0.03 < off.largest < 0.12
    assert off.rest < 0.1
    for suffix in FORMATS:
        head = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
        assert drawn.picture(suffix, title="plot").startswith(head)
    again = draw_by_runs(plotter(), EXAMPLES / "plot.ngc", EXAMPLES / "plotter.yaml")
    assert again.followed == drawn.followed


def test_a_zero_of_the_shaft_is_none_of_the_drawing() -> None:
    """Set-points stay where the boards have them when `hil zero` moves the shafts' zero."""
    bench, circle = plotter(), b"G21 G17\nF1500\nG3 I-20\nM2\n"
    before = draw_by_runs(bench, circle, EXAMPLES / "plotter.yaml").deviation.largest
    bench.axis("m1").do("position", position_deg=287.0)
    bench.run(2000)
    bench.axis("m1").zero()
    assert abs(bench.axis("m1").snapshot().yw - bench.axis("m1").snapshot().position_deg) > 200
    after = draw_by_runs(bench, circle, EXAMPLES / "plotter.yaml").deviation.largest
    assert 0.01 < before < 0.12
    assert after == pytest.approx(before, abs=0.02)


def test_the_shift_of_zeros_by_kind_of_axis() -> None:
    assert zero_shift_deg({"position_deg": 5.0, "yw": 12.0, "loop_on": 1, "r": 300.0}) == 7.0
    assert zero_shift_deg({"position_deg": 5.0, "yw": 0.0, "loop_on": 0}) == 0.0
    assert zero_shift_deg({"position_deg": 5.0, "commanded_deg": 4.0}) == -1.0
    assert zero_shift_deg({"position_deg": 5.0}) == 0.0


@pytest.mark.thorough
@pytest.mark.long
def test_a_circle_by_sacs_on_their_line_is_measured(segment: Any) -> None:
    """A circle of 50 mm radius at 1200 mm/min, over a line at 38400 baud."""
    bench = segment(2)
    machine = parse_machine(MILL, "mill.yaml")
    program = read_program(b"G21 G17 G64 P0.05\nG1 X50 F1200\nG3 I-50\nM2\n")
    assert program.problems == ()
    plan = plan_path(program.motions, machine, "circle.ngc")
    master = NodeMaster(NODES)
    run = path_run(master, machine, NodePhrases(machine, PROFILE.paths).of(plan))

    def carry_out() -> None:
        run.start(bench.now_ns)
        attend(bench, {"bus0.master": run}, lambda: run.is_over)

    followed = followed_by(bench, machine, carry_out)
    assert run.state is RunState.ENDED, run.why
    drawn = FollowedPath(machine, asked_path(program.motions, machine), followed)
    assert 0.01 < drawn.deviation.largest < 0.15
    assert drawn.picture(".png").startswith(b"\x89PNG")


def test_rapids_of_a_path_are_drawn_apart() -> None:
    text = b"G21 G90 G17\nG0 X20 Y0\nG1 X30 F1500\nG3 I-5\nG0 X0\nM2\n"
    motions = read_program(text).motions
    machine = parse_machine((EXAMPLES / "plotter.yaml").read_text(), "plotter.yaml")
    asked, rapids = asked_path(motions, machine), asked_rapids(motions)
    assert len(asked) == len(rapids)
    assert [rapids[0], rapids[1], rapids[2], rapids[-1]] == [False, True, False, True]
    assert sum(rapids) == 2
    fed, rapid = parted(asked, rapids)
    pieces = [[place[:2] for place in rapid[at : at + 3]] for at in range(0, len(rapid), 3)]
    assert [[*map(tuple, piece[1:])] for piece in pieces] == [[(0, 0), (20, 0)], [(30, 0), (0, 0)]]
    assert all(math.isnan(piece[0][0]) for piece in pieces)
    assert len(fed) == len(asked) - 2 + 1  # without the first place and the last; one gap
    assert parted(asked, ()) == (asked, ())


def test_problems_of_program_and_machine_are_told_together(tmp_path: Path) -> None:
    bench = plotter()
    machine = (EXAMPLES / "plotter.yaml").read_text()
    with pytest.raises(ConfigError, match="would go to 999 mm"):
        draw_by_runs(bench, b"G0 X999\nM2\n", machine)
    with pytest.raises(ConfigError, match="the bench has no axis m7"):
        draw_by_runs(bench, b"G0 X9\nM2\n", machine.replace("axis: m2", "axis: m7"))
    with pytest.raises(ConfigError, match=r"program:1:1"):
        draw_by_runs(bench, b"\xff\xfe", machine)


@pytest.mark.thorough
@pytest.mark.parametrize("pause_ms", [70, 150, 230, 300])
def test_a_pause_in_the_first_rapid_moves_no_axis_off_its_path(pause_ms: int) -> None:
    """Servos overshoot at the end of their rapid, by the same with a pause and without."""
    bench = plotter()
    machine = parse_machine((EXAMPLES / "plotter.yaml").read_text(), "plotter.yaml")
    axes = bench.run_axes
    stand_deg = {axis: axes[str(axis.bench_axis)].position_deg - axis.zero_deg for axis in machine.axes}
    begin = Point(**{axis.letter: at_deg / axis.motor_deg_per_unit for axis, at_deg in stand_deg.items()})
    program = read_program(b"G21 G90 G17\nG0 X20 Y0\nF1500\nG3 I-20\nM2\n", Settings("circle.ngc", begin))
    plan = plan_program(program, machine, "circle.ngc", begin)
    (run,) = BenchRuns(plan, axes).runs
    execution = bench.execute(run.text)

    def carry_out() -> None:
        begun_ns, paces = bench.now_ns, [(pause_ms, 0.0), (pause_ms + 400, 1.0)]
        for until_ns in execution.run():
            bench.run_until(until_ns / 1e6)
            if paces and bench.now_ns - begun_ns >= paces[0][0] * 1e6:
                execution.set_pace(paces.pop(0)[1])

    followed = followed_by(bench, machine, carry_out)
    assert execution.progress.state == "done"
    assert 0.01 < deviation(asked_path(program.motions, machine, begin), followed).largest < 0.12
