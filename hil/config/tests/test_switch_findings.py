"""Findings about switches along axes: all at once, each with its place and a remedy."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse

HEAD = """\
bench: t
devices:
  s1: {profile: sac, plant: full, load: {kind: end_stops, min_deg: -90, max_deg: 90}}
  m1: {profile: mechaduino}
  u1: {profile: uno}
wires: [{from: s1.clk, to: m1.step}]
"""


def problems(text: str) -> list[str]:
    try:
        parse(text, "b.yaml", find_catalogue())
    except ConfigError as error:
        return [str(problem) for problem in error.problems]
    return []


def said_of(switch: str) -> str:
    (found,) = problems(f"{HEAD}switches:\n  a: {switch}\n")
    return found


@pytest.mark.parametrize(
    ("switch", "said"),
    [
        (
            "{axis: s9, to_deg: 1}",
            'b.yaml:8:13: switches.a.axis: there is no device "s9" (known are: m1, s1, u1)',
        ),
        (
            "{axis: u1, to_deg: 1}",
            'b.yaml:8:13: switches.a.axis: "u1" has no motor, and so no shaft that could hold a switch'
            " (write one of s1, m1)",
        ),
        (
            "{axis: s1, to_deg: 1, to: s1.Estp}",
            'b.yaml:8:32: switches.a.to: s1 has no pin "Estp" (did you mean "Estop"? there are sync, Estop,'
            " RST, EnA, EnB, xclk)",
        ),
        (
            "{axis: s1, to_deg: 1, to: s1.clk}",
            "b.yaml:8:32: switches.a.to: clk of s1 is an output"
            " (write one of sync, Estop, RST, EnA, EnB, xclk)",
        ),
        (
            "{axis: s1, to_deg: 1, to: m1.D1}",
            "b.yaml:8:32: switches.a.to: m1.D1 is driven by s1.clk already (give each a pin of its own)",
        ),
        (
            "{axis: s1, from_deg: 91}",
            "b.yaml:8:27: switches.a.from_deg: s1 stops at 90 deg, before the switch"
            " (write an angle from -90 to 90, or put the stop behind the switch)",
        ),
        (
            "{axis: s1, to_deg: -91}",
            "b.yaml:8:25: switches.a.to_deg: s1 stops at -90 deg, before the switch"
            " (write an angle from -90 to 90, or put the stop behind the switch)",
        ),
        (
            "{axis: m1}",
            "b.yaml:8:3: switches.a: the switch has no place (write from_deg, to_deg or both)",
        ),
        (
            "{axis: m1, from_deg: 2, to_deg: 1}",
            "b.yaml:8:38: switches.a.to_deg: the switch ends where it has not begun"
            " (write an angle that is not less than from_deg)",
        ),
        (
            "{axis: m1, from_deg: 0, to_deg: 9, every_deg: 10, hysteresis_deg: 1}",
            "b.yaml:8:52: switches.a.every_deg: with 10 deg the switch is never let go"
            " (write from_deg and to_deg, with more than what lies between them here)",
        ),
    ],
)
def test_a_wrong_switch_is_said_where_it_stands(switch: str, said: str) -> None:
    assert said_of(switch) == said


def test_two_switches_at_one_pin_by_any_of_its_names() -> None:
    rows = "".join(f"  {name}: {{axis: s1, to_deg: 1, to: s1.Estop}}\n" for name in "ab")
    text = f"{HEAD}switches:\n{rows}"
    assert problems(text) == [
        "b.yaml:9:32: switches.b.to: s1.Estop is driven by the switch a already (give each a pin of its own)"
    ]


def test_an_axis_has_so_many_switches() -> None:
    rows = "".join(f"  x{i}: {{axis: s1, to_deg: {i}}}\n" for i in range(9))
    (found,) = problems(f"{HEAD}switches:\n{rows}")
    assert found == "b.yaml:16:14: switches.x8.axis: s1 has 8 switches already (take one of them out)"
