"""Configurations of an EasyDriver and an Arduino: what is refused, where, and with which remedy."""

import re
from pathlib import Path

import pytest

from hil.compose.find import find_catalogue
from hil.config import ConfigError, parse

EXAMPLE = Path(__file__).parents[1] / "examples/easydriver.yaml"
HEAD = "bench: t\ndevices:\n"


def problems(text: str) -> list[str]:
    try:
        parse(HEAD + text, "t.yaml", find_catalogue())
    except ConfigError as error:
        return [str(problem) for problem in error.problems]
    return []


def test_the_example_has_no_problems() -> None:
    parse(EXAMPLE.read_text(), "easydriver.yaml", find_catalogue())


def test_a_log_has_the_keys_of_an_axis_with_nothing_in_them() -> None:
    assert problems("  u1: {profile: uno, plant: simple, load: null, axis: {}, registers: {}}\n") == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("  u1: {profile: uno, plant: full}", r"3:22: devices.u1.plant: profile uno has no motor \(leave"),
        ("  u1: {profile: uno, axis: {start_deg: 1}}", r"3:22: devices.u1.axis: profile uno has no motor"),
        ("  d1: {profile: easydriver, port: pty}", r"3:29: devices.d1.port: .*no serial interface"),
        *(
            (f"  d1: {{profile: easydriver, axis: {{{name}: {value}}}}}", said)
            for name, value, said in (
                ("phase_current_A", "0.76", r"3:53: .*0.76 A is too large \(write 0.75 or less\)"),
                ("phase_current_A", "0.13", r"3:53: .*0.13 A is too small \(write 0.135 or more\)"),
                ("ambient_degC", "86", r"3:50: .*86 degC is too large \(write 85 or less\)"),
                ("supply_V", "30.1", r"3:46: .*outside the supply range .* \(write 7 to 30\)"),
                ("supply_V", "6.5", r"write 7 to 30, or hardware: \"3V3\""),
                ("phase_inductance_H", "50", r"3:56: .*50 is out of bounds .*another unit"),
                ("current_A", "0.3", r"3:36: .*current_A: unknown key"),
            )
        ),
        (
            "  d1: {profile: easydriver}\n  u1: {profile: uno}\nwires: [{from: u1.D22, to: d1.step}]",
            r"5:16: wires.0.from: u1 has no pin \"D22\"",
        ),
        (
            "  d1: {profile: easydriver}\n  u1: {profile: uno}\nwires: [{from: d1.step, to: u1.D2}]",
            r"wires.0.from: step of d1 is an input",
        ),
        (
            "  u1: {profile: uno}\nfaults: [{fault: shaft_jam, target: u1}]",
            r"faults.0.target: shaft_jam cannot be on \"u1\"",
        ),
        (
            "  d1: {profile: easydriver}\ncan: {can0: {bit_rate: 500000, nodes: {d1: 4}}}",
            r"can.can0.nodes.d1: a easydriver has no drive that a node could command",
        ),
    ],
)
def test_nonsense_is_refused_in_its_place(text: str, said: str) -> None:
    found = problems(text + "\n")
    assert len(found) == 1
    assert re.search(said, found[0]), found
