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
        ("not torque_Nm > 0", False),
        ("abs(torque_Nm) >= 0 or max(torque_Nm, 1) > 0 or min(1, torque_Nm) < 2", False),
        ("torque_Nm / 2 < 1 or -torque_Nm < 1", False),
        ("position_deg / 0 > 1 or not position_deg / 0 > 1", False),
        ("abs(velocity_rpm) > 1", True),
        ("abs(velocity_rpm + position_deg) - 88.5 == 0", True),
        ("-velocity_rpm == 2", True),
        ("position_deg -90 == .5", True),
        ("position_deg - 2 * 40 == 10.5", True),
        ("(position_deg - 2) * 2 / 4 == 44.25", True),
        ("min(position_deg, velocity_rpm, 7) == -2 and max(position_deg, 7) == 90.5", True),
        ("not loop_on == 1", False),
        ("not (loop_on == 0 and position_deg > 89 or velocity_rpm > 0)", True),
        ("not not loop_on == 1 and NOT velocity_rpm > 0", True),
        ("(loop_on == 1 or velocity_rpm > 0) and position_deg > 91", False),
        ("(loop_on) == 0x01", True),
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
        ("position_deg > 89deg", '"89deg" has a unit; write 89: a field\'s name says its unit'),
        ("1 < position_deg < 89", "'<' is too much: write `and` or `or` between two comparisons"),
        ("position_deg > 89 loop_on == 1", "'loop_on' is too much"),
        ("(loop_on == 1", "a ) is missing"),
        ("(loop_on == 1 loop_on", "a ) is missing where 'loop_on' stands"),
        ("not loop_on", "write one of <= >= == != < > behind loop_on, as in `loop_on == 1`"),
        ("loop_on and position_deg > 1", "behind loop_on, not 'and'"),
        ("__import__('os')", "there is no function '__import__'; there are abs, max, min"),
        ("ab(loop_on) > 1", """there is no function 'ab'; did you mean "abs"? there are"""),
        ("abs(loop_on, 2) > 1", "abs() takes 1, not 2"),
        ("min(loop_on) > 1", "min() takes 2 or more, not 1"),
        ("abs() > 1", "in abs() a field or a number is missing where ')' stands"),
        ("(loop_on > 1) + 2 > 1", "(loop_on > 1) is no number"),
        ("abs(loop_on > 1) > 1", "a ) is missing where '>' stands"),
        ("2 + (loop_on > 1) > 1", "(loop_on > 1) is no number"),
        ("loop_on > (loop_on > 1)", "(loop_on > 1) is no number"),
        ("loop_on % 2 == 1", "'%' means nothing here"),
        ("(" * 60 + "loop_on > 1" + ")" * 60, "too deep; write at most 50"),
        ("loop_on > 1" + " or loop_on > 1" * 200, "write at most 500"),
        ("1" + "/2" * 60 + "> loop_on", "write at most 50 /"),
        ('loop_on > 1 and m1.sent > "a"', 'm1.sent > "a": of words write has, == or !='),
        ("m1.sent has loop_on", "behind m1.sent has, not 'loop_on'"),
        ('m1.sent has ""', 'm1.sent has "": write what to look for'),
        ("m1.sent has 0x123", "0x123 is half a byte"),
        ('m1.sent has "Err', 'the words behind " have no end'),
        ('2 == "Err"', 'as in `m1.sent has "Err"`'),
        ("1 < 2", "'1 < 2' has no field"),
    ],
)
def test_what_is_no_condition(text: str, said: str) -> None:
    with pytest.raises(ConditionError) as error:
        parse_condition(text)
    assert said in str(error.value)


def test_an_example_is_of_who_asks() -> None:
    with pytest.raises(ConditionError, match=r"'\)' stands; write it as in `m1.position_deg > 89`"):
        parse_condition(")", "m1.position_deg > 89")
    with pytest.raises(ConditionError, match=r"is missing; write it as in `abs\(m1.e\) > 5`"):
        parse_condition("abs(m1.e) >", "m1.position_deg > 89")


def test_codes_have_the_words_that_the_status_shows() -> None:
    for text, field, code in (
        ("motion_state == standby", "motion_state", 0),
        ("s1.motion_state == Cruise", "s1.motion_state", 2),
        ("mode == velocity", "mode", ord("v")),
        ("mode == v", "mode", ord("v")),
    ):
        condition = parse_condition(text)
        assert condition.fields == (field,)
        assert condition.holds({field: code})
        assert not condition.holds({field: code + 1})
    assert parse_condition("motion_state == v").fields == ("motion_state", "v")


def test_a_field_is_not_compared_with_a_word() -> None:
    with pytest.raises(ConditionError) as error:
        parse_condition("mode == foo").check("m1", ["mode", "e"])
    assert str(error.value) == (
        "m1 has no field 'foo' to compare mode with; write a number, position, velocity, torque, hybrid,"
        " or a field: there are mode, e"
    )


def test_words_in_quotes_and_bytes() -> None:
    condition = parse_condition(
        r"""m1.sent has "E\x1b\r\"é" or not bus0.text != 'a' and m1.sent has 0x0D0a"""
    )
    assert condition.fields == ()
    assert [tuple(test) for test in condition.tests] == [
        ("m1.sent", "has", b'E\x1b\r"\xc3\xa9'),
        ("bus0.text", "==", b"a"),
        ("m1.sent", "has", b"\r\n"),
    ]
    assert [
        condition.function(*each) for each in ((True, None, None), (None, True, True), (None, True, False))
    ] == [
        True,
        True,
        False,
    ]


def test_of_a_text_that_is_not_there_neither_a_test_nor_its_opposite_holds() -> None:
    condition = parse_condition('m1.sent has "a" and loop_on == 1')
    assert [condition.function(1, each) for each in (True, False, None)] == [True, False, False]
    opposite = parse_condition('not m1.sent has "a"')
    assert [opposite.function(each) for each in (True, False, None)] == [False, True, False]
    with pytest.raises(ConditionError, match="`hil find` looks for words in quotes"):
        condition.check("m1", list(VALUES))


def test_a_field_that_is_not_there() -> None:
    with pytest.raises(ConditionError) as error:
        parse_condition("positon_deg > 89").check("m1", list(VALUES))
    assert str(error.value).startswith("""m1 has no field 'positon_deg'; did you mean "position_deg"?""")
    with pytest.raises(ConditionError, match=r"m1 has no field 'loop_on.__class__'"):
        parse_condition("loop_on.__class__ == 1").check("m1", list(VALUES))


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
    assert f"--within {text}: this is " in capsys.readouterr().err
