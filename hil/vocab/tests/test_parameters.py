"""Check of given values against a table, with every problem told."""

import math
from dataclasses import replace
from typing import Any

import pytest

from hil.vocab.parameters import Parameter, filled
from hil.vocab.verbs import CODES, COMMON, Role, Verb, VerbRefused, described, table_of

NUMBER = Parameter("angle_deg", "an angle", "deg", -90.0, 90.0)
WHOLE = Parameter("count", "how many", "", 1, 1e6, is_whole=True)
CHOICE = Parameter("how", "in which way", choices=("grace", "prejudice"), default="grace")
SYNONYMS = replace(CHOICE, also=("controlled", "immediate"))
TEXT = Parameter("text", "what", maximum=5, is_text=True)
OPTIONAL = Parameter("speed_rpm", "a speed", "rpm", 0.0, 10.0, is_optional=True)
DEFAULT = Parameter("rate_Hz", "how fast", "Hz", 1.0, 10.0, 2.5)


@pytest.mark.parametrize(
    ("parameter", "value", "problem"),
    [
        (NUMBER, 90, None),
        (NUMBER, -90.0, None),
        (NUMBER, 90.0000001, "90.0000001 is too large; write -90 to 90 deg"),
        (NUMBER, math.nan, "nan is no number; write -90 to 90 deg"),
        (NUMBER, math.inf, "inf is too large; write -90 to 90 deg"),
        (NUMBER, -math.inf, "-inf is too small; write -90 to 90 deg"),
        (NUMBER, 10**400, f"1{39 * '0'}... is too large; write -90 to 90 deg"),
        (NUMBER, True, "true is no number; write -90 to 90 deg"),
        (NUMBER, "5", '"5" is a text; write the number without quotes, as 5'),
        (NUMBER, "9deg", '"9deg" has its unit; write degrees without the unit, as 9'),
        (NUMBER, None, "nothing is no number; write -90 to 90 deg"),
        (NUMBER, [5], "[5] is no number; write -90 to 90 deg"),
        (NUMBER, {"value": 5}, "{'value': 5} is no number; write -90 to 90 deg"),
        (NUMBER, 5j, "5j is no number; write -90 to 90 deg"),
        (WHOLE, 5, None),
        (WHOLE, 5.0, None),
        (WHOLE, 5.5, "5.5 is not whole; write a whole number, 1 to 1000000"),
        (WHOLE, 0, "0 is too small; write 1 to 1000000"),
        (WHOLE, math.nan, "nan is no number; write 1 to 1000000"),
        (WHOLE, False, "false is no number; write 1 to 1000000"),
        (CHOICE, "prejudice", None),
        (CHOICE, "Grace", 'there is no "Grace" here; did you mean "grace"? write grace or prejudice'),
        (CHOICE, "", 'there is no "" here; write grace or prejudice'),
        (CHOICE, 0, "there is no 0 here; write grace or prejudice"),
        (CHOICE, True, "there is no true here; write grace or prejudice"),
        (CHOICE, ["grace"], "there is no ['grace'] here; did you mean \"grace\"? write grace or prejudice"),
        (TEXT, "", None),
        (TEXT, "12345", None),
        (TEXT, "123456", "its 6 characters are too many; write a text of at most 5 characters"),
        (TEXT, 12345, "12345 is no text; write a text of at most 5 characters"),
        (TEXT, b"123", "b'123' is no text; write a text of at most 5 characters"),
        (TEXT, None, "nothing is no text; write a text of at most 5 characters"),
        (OPTIONAL, -1, "-1 is too small; write 0 to 10 rpm"),
        (replace(WHOLE, maximum=1, limits="0 or 1"), "high", '"high" is no number; write 0 or 1'),
        (
            replace(NUMBER, minimum=-(2.0**53), maximum=1e18),
            "x",
            '"x" is no number; write -9.0072e15 to 1e18 deg',
        ),
        (
            replace(NUMBER, minimum=-(2.0**31), maximum=2.0**53),
            -1e300,
            "-1e+300 is too small; write -2147483648 to 2^53 deg",
        ),
        (replace(NUMBER, minimum=1e-6, maximum=1e18), 0, "0 is too small; write 1e-6 to 1e18 deg"),
    ],
)
def test_a_value_and_what_is_wrong_with_it(parameter: Parameter, value: object, problem: str | None) -> None:
    assert parameter.problem(value) == problem


def test_defaults_are_filled_in_and_what_is_optional_stays_away() -> None:
    values, problems = filled("go", (NUMBER, CHOICE, OPTIONAL, DEFAULT), {"angle_deg": 5})
    assert (values, problems) == ({"angle_deg": 5, "how": "grace", "rate_Hz": 2.5}, {})
    values, problems = filled("go", (NUMBER, CHOICE, OPTIONAL), {"angle_deg": 5, "speed_rpm": None})
    assert (values, problems) == ({"angle_deg": 5, "how": "grace"}, {})


def test_every_problem_is_told() -> None:
    values, problems = filled("go", (NUMBER, WHOLE, CHOICE), {"tilt": 1, "count": True, "how": "well"})
    assert problems == {
        "tilt": "there is no such parameter; parameters of go are angle_deg, count, how",
        "angle_deg": "this one is missing: an angle; write -90 to 90 deg",
        "count": "true is no number; write 1 to 1000000",
        "how": 'there is no "well" here; write grace or prejudice',
    }
    assert values == {}
    assert filled("go", (NUMBER,), {"angle_dg": 1}) == (
        {},
        {"angle_dg": 'there is no such parameter; did you mean "angle_deg"? parameters of go are angle_deg'},
    ), "what was meant is not missing too"
    assert filled("rest", (), {"x": 1}) == (
        {},
        {"x": "there is no such parameter; parameters of rest are none"},
    )


@pytest.mark.parametrize(
    ("said", "means"), [("immediate", "prejudice"), ("controlled", "grace"), ("grace", "grace")]
)
def test_other_words_for_a_choice_are_taken(said: str, means: str) -> None:
    assert filled("stop", (SYNONYMS,), {"how": said}) == ({"how": means}, {})


def test_what_is_no_word_of_a_choice_is_refused() -> None:
    assert filled("stop", (SYNONYMS,), {"how": ["immediate"]})[1] == {
        "how": "there is no ['immediate'] here; did you mean \"immediate\"? write grace or prejudice"
    }
    assert (
        SYNONYMS.described()
        == "in which way, grace or prejudice (also controlled or immediate), default grace"
    )


def test_null_is_as_missing() -> None:
    assert filled("go", (CHOICE,), {"how": None})[1] == {
        "how": "this one is missing: in which way; write grace or prejudice"
    }


def test_a_verb_tells_all_that_is_wrong_with_its_parameters() -> None:
    verb = Verb("go", "go there", (NUMBER, WHOLE))
    assert verb.filled({"angle_deg": 1, "count": 2}) == {"angle_deg": 1, "count": 2}
    with pytest.raises(VerbRefused) as refused:
        verb.filled({"angle_deg": math.nan})
    assert refused.value.code == "bad_parameter"
    assert refused.value.code in CODES
    assert str(refused.value) == (
        "angle_deg: nan is no number; write -90 to 90 deg;"
        " count: this one is missing: how many; write 1 to 1000000"
    )


def test_described_for_people() -> None:
    assert [each.described() for each in (NUMBER, WHOLE, CHOICE, TEXT, OPTIONAL)] == [
        "an angle, -90 to 90 deg, needed",
        "how many, 1 to 1000000, needed",
        "in which way, grace or prejudice, default grace",
        "what, text, at most 5 characters, needed",
        "a speed, 0 to 10 rpm, may be left out",
    ]
    load = Parameter("torque_Nm", "a torque", "Nm", -1e3, 1e3, limits="-3 to 3 times of what it holds")
    assert load.described() == "a torque, -3 to 3 times of what it holds, in Nm, needed"
    assert load.problem(2e3) == "2000 is too large; write -3 to 3 times of what it holds"


def test_the_common_verbs_stand_in_every_table() -> None:
    own = Verb("go", "go there", (NUMBER,), role=Role.ADMIN)
    table = table_of((own,))
    assert list(table) == ["go", *(verb.name for verb in COMMON)]
    rows: list[dict[str, Any]] = described(table)
    assert rows[0]["role"] == "admin"
    assert rows[0]["parameters"] == {"angle_deg": "an angle, -90 to 90 deg, needed"}
    assert {row["verb"]: row["role"] for row in rows[1:]} == dict.fromkeys(
        ("type", "reset", "pin", "zero"), "operator"
    )
