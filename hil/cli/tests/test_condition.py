"""Conditions on fields, as `hil wait` reads them: what they mean, and what is said of one that is none."""

from typing import Any

import pytest
import typer

from hil.cli.boards.time_given import seconds_of
from hil.net.condition import ConditionError, parse_condition

VALUES = {"position_deg": 90.5, "velocity_rpm": -2.0, "loop_on": 1.0, "torque_Nm": None}


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("position_deg > 89", True),
        ("position_deg>89", True),
        ("89 < position_deg", True),
        ("position_deg <= 90.5", True),
        ("position_deg >= 90.6", False),
        ("velocity_rpm == -2", True),
        ("velocity_rpm != -2e0", False),
        ("velocity_rpm < position_deg", True),
        ("position_deg > 89 and loop_on == 1", True),
        ("position_deg > 91 and loop_on == 1", False),
        ("position_deg > 91 or loop_on == 1", True),
        ("loop_on == 1 or position_deg > 91 and velocity_rpm > 0", True),
        ("velocity_rpm > 0 and position_deg > 91 OR loop_on == 1", True),
        ("torque_Nm > 0", False),
        ("torque_Nm <= 0", False),
        ("torque_Nm != 0", False),
    ],
)
def test_what_a_condition_means(text: str, holds: bool) -> None:
    assert parse_condition(text).holds(VALUES) is holds


def test_its_fields_stand_once() -> None:
    assert parse_condition("b > 1 and a < b or 2 == a").fields == ("b", "a")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "a field or a number is missing; write it as in `position_deg > 89`"),
        ("position_deg", "write one of <= >= == != < > behind position_deg"),
        ("position_deg 89", "behind position_deg, not '89'"),
        ("position_deg >", "behind > a field or a number is missing"),
        ("position_deg > > 89", "behind > a field or a number is missing where '>' stands"),
        ("position_deg > 89 and", "a field or a number is missing"),
        ("or position_deg > 89", "a field or a number is missing where 'or' stands"),
        ("position_deg = 89", "write ==, not ="),
        ("position_deg => 89", "write >=, not =>"),
        ("position_deg >< 89", "write one of <= >= == != < >, not ><"),
        ("position_deg > 89deg", "write 89, not 89deg: a field's name says its unit"),
        ("1 < position_deg < 89", "'<' is too much: write `and` or `or` between two comparisons"),
        ("position_deg > 89 loop_on == 1", "'loop_on' is too much"),
        ("not loop_on == 1", "`not` means nothing here: write the opposite comparison"),
        ("(loop_on == 1)", "'(' means nothing here"),
        ("__import__('os')", "'(' means nothing here"),
        ("1 < 2", "'1 < 2' has no field"),
    ],
)
def test_what_is_no_condition(text: str, said: str) -> None:
    with pytest.raises(ConditionError) as error:
        parse_condition(text)
    assert said in str(error.value)


def test_a_field_that_is_not_there() -> None:
    with pytest.raises(ConditionError) as error:
        parse_condition("positon_deg > 89").check("m1", list(VALUES))
    assert str(error.value).startswith("""m1 has no field 'positon_deg'; did you mean "position_deg"?""")


@pytest.mark.parametrize(
    ("text", "seconds"), [("2s", 2), ("2", 2), ("500ms", 0.5), ("20 us", 2e-5), ("1.5min", 90), (".5S", 0.5)]
)
def test_lengths_of_time(text: str, seconds: float) -> None:
    assert seconds_of(text) == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["", "s", "2h", "-1s", "0", "1e9", "nan", "2000min"])
def test_what_is_no_length_of_time(text: str, capsys: Any) -> None:
    with pytest.raises(typer.Exit) as ended:
        seconds_of(text)
    assert ended.value.exit_code == 2
    assert f"--within {text}: write " in capsys.readouterr().err
