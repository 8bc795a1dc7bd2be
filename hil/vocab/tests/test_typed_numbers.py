"""Numbers as they are typed: units, commas, signs, and what is too large."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.vocab.typed_numbers import number_problem, quoted, typed_number, unit_in


@pytest.mark.parametrize(
    ("text", "unit", "problem"),
    [
        ("90deg", "deg", '"90deg" has its unit; write degrees without the unit, as 90'),
        ("-4.5 °", "deg", '"-4.5 °" has its unit; write degrees without the unit, as -4.5'),
        ("90rad", "deg", '"90rad" is in radians; write degrees without the unit, as 5156.62'),
        ("0.5rev", "deg", '"0.5rev" is in turns; write degrees without the unit, as 180'),
        ("2rpm", "deg", '"2rpm" is in rpm, and degrees are meant; write 0 to 9'),
        ("2x", "deg", '"2x" is no number; write degrees without the unit, as 2'),
        ("360deg/s", "rpm", '"360deg/s" is in deg/s; write rpm without the unit, as 60'),
        ("20ms", "s", '"20ms" is in milliseconds; write seconds without the unit, as 0.02'),
        ("1%", "", '"1%" is in percent; write it without a unit, as 0.01'),
        ("5mm", "", '"5mm" has a unit; write it without a unit, as 5'),
        ("9.6kbit/s", "bit/s", '"9.6kbit/s" is in kbit/s; write bit/s without the unit, as 9600'),
        ("1,5", "deg", '"1,5" has a comma; write a point before decimals, as 1.5'),
        ("--5", "deg", '"--5" has more than one sign; write one, as -5'),
        ("+-5e3", "", '"+-5e3" has more than one sign; write one, as -5e3'),
        ("1e400", "deg", '"1e400" is too large; write 0 to 9'),
        ("nan", "deg", '"nan" is no number; write 0 to 9'),
        ("inf", "deg", '"inf" is no number; write 0 to 9'),
        ("far", "deg", '"far" is no number; write 0 to 9'),
        ("  ", "deg", "no number is given; write 0 to 9"),
        ("7", "deg", '"7" is a text; write the number without quotes, as 7'),
    ],
)
def test_a_text_that_is_no_number_and_what_to_write(text: str, unit: str, problem: str) -> None:
    assert "; ".join(number_problem(text, unit, "0 to 9")) == problem


def test_names_say_their_unit() -> None:
    names = ("position_deg", "acceleration_rpm_per_s", "rate_Hz", "load_torque_Nm", "rate", "s", "pKp", "_")
    assert [unit_in(name) for name in names] == ["deg", "rpm/s", "Hz", "Nm", "", "", "", ""]


def test_what_was_given_is_not_too_long() -> None:
    assert quoted("x" * 50) == f'"{"x" * 40}..."'
    assert [quoted(each) for each in (0.1, True, None, [1])] == ["0.1", "true", "nothing", "[1]"]


@given(st.text(max_size=12))
def test_each_text_is_a_finite_number_or_has_a_problem_with_a_remedy(text: str) -> None:
    value = typed_number(text)
    if isinstance(value, str):
        what, remedy = number_problem(text, "deg", "0 to 9")
        assert value == text
        assert what
        assert remedy.startswith("write ")
    else:
        assert math.isfinite(value)
