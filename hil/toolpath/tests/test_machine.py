"""Documents of machines: what they mean, and each mistake with its place."""

import pytest

from hil.toolpath.machine import machine_reference, parse_machine
from hil.vocab.problem import ConfigError

MILL = """\
machine: mill
line: bus0.master
axes:
  x: {node: 4, steps_per_mm: 80, min_mm: 0, max_mm: 9, velocity_mm_per_min: 3e3, acceleration_mm_per_s2: 200}
  y:
    node: 5
    axis: s2
    is_reversed: true
    steps_per_mm: 40
    microstep_exponent: 3
    min_mm: -10
    max_mm: 20.5
    velocity_mm_per_min: 1200
    acceleration_mm_per_s2: 100
  a:
    {axis: m1, deg_per_deg: 2, min_deg: 0, max_deg: 9, velocity_deg_per_min: 3600, acceleration_deg_per_s2: 9}
switches:
  spindle: {node: 9, start: "m", stop: "S"}
  flood: {pin: m1.D3}
"""


def problems(text):
    with pytest.raises(ConfigError) as error:
        parse_machine(text, "mill.yaml")
    return [str(problem) for problem in error.value.problems]


def test_a_machine_in_units_and_seconds():
    machine = parse_machine(MILL, "mill.yaml")
    x, y, a = machine.axes
    assert (x.letter, x.index, x.unit, x.speed_per_s) == ("x", 0, "mm", 50)
    assert (x.pulses_per_unit, x.pulses_at(1.25), x.bench_axis) == (160, 200, None)
    assert (y.pulses_per_unit, y.motor_deg_per_unit, y.motor_deg(2)) == (-320, -72, -144)
    assert (a.index, a.unit, a.speed_per_s, a.motor_deg(10), a.pulses_per_unit) == (3, "deg", 60, 20, 0)
    assert not machine.has_nodes
    assert not machine.has_bench_axes
    assert machine.text.tolerance_mm == 0.02


def test_every_mistake_has_its_place_and_a_remedy():
    assert problems(
        """\
machine: mill
tolerance: 0.1
axes:
  x: {node: 3, step_per_mm: 80, min_mm: 0, max_mm: 300, velocity_mm_per_min: 300, acceleration_mm_per_s2: -1}
  q: {}
"""
    ) == [
        'mill.yaml:2:1: tolerance: unknown key (did you mean "tolerance_mm"?)',
        "mill.yaml:4:13: axes.x.node: the number 3 is too small (write 4 or more)",
        'mill.yaml:4:16: axes.x.step_per_mm: unknown key (did you mean "steps_per_mm"?)',
        "mill.yaml:4:107: axes.x.acceleration_mm_per_s2: the number -1 is too small (write more than 0.0)",
        "mill.yaml:5:3: axes.q: unknown key (known are: a, b, c, u, v, w, y, z)",
    ]


def test_what_does_not_fit_together():
    limits = "min_mm: 5, max_mm: 5, velocity_mm_per_min: 300000, acceleration_mm_per_s2: 9"
    found = problems(
        f"""\
machine: mill
axes:
  x: {{node: 4, steps_per_mm: 200, {limits}}}
  y: {{node: 4, {limits}}}
  z: {{{limits}}}
  u: {{axis: m1, {limits}}}
switches:
  mist: {{pin: m1.D3, node: 4}}
  flood: {{node: 9, start: m}}
"""
    )
    said = [line.split(": ", 1) for line in found]
    assert {place for place, _ in said} >= {"mill.yaml:3:3", "mill.yaml:4:3", "mill.yaml:5:3"} - {
        "mill.yaml:3:3"
    }
    text = "\n".join(found)
    for part in (
        "axes.x.min_mm: it is not less than max_mm",
        "axes.x.velocity_mm_per_min: these are more than 500000 pulses a second (write at most 75000)",
        "axes.y: a node needs steps_per_mm",
        "axes.y.node: x has this node, too",
        "axes.z: nothing moves it",
        "axes.u: an axis of the bench needs deg_per_mm",
        "switches.mist: a pin or a node switches it",
        "switches.flood: a node needs start and stop",
    ):
        assert part in text, part


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "keys are wanted here, not nothing"),
        ("machine: mill\naxes: {}\n", "there is no axis"),
        ("bench: b\ndevices: {}\n", "this is a bench's configuration, not a machine"),
        ("machine: mill\naxes: 7\n", "keys are wanted here, not the number 7"),
    ],
)
def test_no_machine_at_all(text, said):
    assert said in problems(text)[0]


def test_the_reference_has_every_key():
    page = machine_reference()
    for key in (
        "tolerance_mm",
        "steps_per_mm",
        "steps_per_deg",
        "microstep_exponent",
        "start_ccw",
        "latency_ms",
    ):
        assert f"`{key}`" in page
