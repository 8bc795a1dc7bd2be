"""Configurations of a firmware's build, and of 5 V at pins of 3.3 V: what is refused, and where."""

import pytest

from hil.compose.find import find_catalogue
from hil.config import ConfigError, parse

HEAD = "bench: t\ndevices:\n"


def _problems(text):
    try:
        parse(HEAD + text, "b.yaml", find_catalogue())
    except ConfigError as error:
        return [str(problem) for problem in error.problems]
    return []


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("{spr: 400, pKp: 20}", None),
        ("{identifier: elbow, starts_in: position}", None),
        ("{spr: 2.5}", "2.5 is too small"),
        ("{spr: 0}", "write 4 to 1000"),
        ("{sprr: 400}", 'there is no parameter of its build "sprr"'),
        ("{iMAX: 3}", "write 0 to 2.2"),
        ("{starts_in: closed}", "write open_loop or position"),
        ("{identifier: 3}", "write a text of at most 40 characters"),
        ("{pKp: x}", '"x" is no number (write '),
    ],
)
def test_a_value_of_the_build_is_checked(keys, said):
    problems = _problems(f"  m1: {{profile: mechaduino, parameters: {keys}}}\n")
    assert not problems if said is None else said in " ".join(problems)
    assert all(each.startswith("b.yaml:3:") for each in problems)


def test_all_wrong_values_are_said_at_once():
    problems = _problems("  m1: {profile: mechaduino, parameters: {spr: 0, iMAX: 9, x: 1}}\n")
    assert len(problems) == 3


def test_a_board_without_parameters_takes_none():
    (problem,) = _problems("  u1: {profile: uno, parameters: {spr: 400}}\n")
    assert "the firmware of a uno has no parameters of its build" in problem


def _wired(pin, hardware, giver="u1: {profile: uno}", source="u1.D4"):
    board = f'  m1: {{profile: mechaduino, hardware: "{hardware}"}}\n  {giver}\n'
    return _problems(f"{board}wires: [{{from: {source}, to: m1.{pin}}}]\n")


@pytest.mark.parametrize("pin", ["D2", "enable", "D3"])
def test_5_V_at_a_pin_of_3_3_V_is_refused(pin):
    (problem,) = _wired(pin, "0.1")
    assert problem.startswith("b.yaml:5:")
    assert f"u1 brings 5 V to {pin} of m1, which takes 3.3 V" in problem
    assert 'hardware: "0.2"' in problem


@pytest.mark.parametrize(("pin", "hardware"), [("D0", "0.1"), ("step", "0.1"), ("D2", "0.2"), ("D3", "0.2")])
def test_5_V_at_a_pin_with_a_level_converter_is_good(pin, hardware):
    assert not _wired(pin, hardware)


def test_a_sac_gives_5_V_and_a_mechaduinos_pins_are_not_outputs():
    (problem,) = _wired("enable", "0.1", "s1: {profile: sac}", "s1.OP_SA")
    assert "s1 brings 5 V" in problem
