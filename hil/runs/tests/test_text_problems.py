"""Mistakes in a run's text that are seen without its bench."""

import pytest

from hil.config import ConfigError
from hil.runs import checked_run


def problems(steps: str, axes: str = "{m1: {}, m2: {max_deg: 90}}") -> list[str]:
    """Problems of a run with these steps, without the file's name."""
    with pytest.raises(ConfigError) as raised:
        checked_run(f"run: r\naxes: {axes}\nsteps: [{steps}]\n", "r.yaml")
    return [str(each).removeprefix("r.yaml:") for each in raised.value.problems]


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ("{move: {m9: 90}}", "steps.0.move.m9: 'm9' is none of the run's axes"),
        ("{move_by: {m9: 90}}", "steps.0.move_by.m9: 'm9' is none of the run's axes"),
        ("{pins: {m9.D3: 1}}", "'m9' is none of the run's axes"),
        ("{move: {m2: 91}}", "m2 may not go to 91 deg"),
        ("{repeat: {label: a, times: 2}}", "no step before has the label 'a' (label a step before it)"),
        ("{wait_until: {axis: m1, field: e}}", "neither above nor below is said"),
        ("{dwell_s: 10ms}", '"10ms" is in milliseconds (write seconds without the unit, as 0.01)'),
    ],
)
def test_a_step_that_no_bench_could_do(steps: str, said: str) -> None:
    (found,) = problems(steps)
    assert said in found


def test_all_are_said_at_once() -> None:
    found = problems("{move: {m1: 90deg}}, {move: {m9: 1}}", "{m1: {min_deg: 5, max_deg: 1}}")
    assert len(found) == 3
    assert "min_deg: it is more than max_deg" in found[0]


@pytest.mark.parametrize(
    "steps",
    [
        "{move: {m1: 180}, in_s: 0.01}",
        "{move_by: {m2: 180}}",
        "{line: {m1: 5, m2: 6}}",
        "{wait_until: {axis: m1, field: anything, above: 1}}",
    ],
)
def test_what_a_bench_could_do_is_let_be(steps: str) -> None:
    """Where its axes stand, what they are and which fields they have, the bench alone knows."""
    assert checked_run(f"run: r\naxes: {{m1: {{}}, m2: {{max_deg: 90}}}}\nsteps: [{steps}]\n", "r").run == "r"


def test_an_empty_file_is_told_what_begins_a_run() -> None:
    with pytest.raises(ConfigError, match=r'r.yaml:1:1: the file is empty \(begin with "run: NAME"\)'):
        checked_run("# nothing yet\n", "r.yaml")
