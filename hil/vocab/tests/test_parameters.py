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
        (NUMBER, 90.0000001, "write -90 to 90"),
        (NUMBER, math.nan, "write -90 to 90"),
        (NUMBER, math.inf, "write -90 to 90"),
        (NUMBER, -math.inf, "write -90 to 90"),
        (NUMBER, 10**400, "write -90 to 90"),
        (NUMBER, True, "write a number"),
        (NUMBER, "5", "write a number"),
        (NUMBER, None, "write a number"),
        (NUMBER, [5], "write a number"),
        (NUMBER, {"value": 5}, "write a number"),
        (NUMBER, 5j, "write a number"),
        (WHOLE, 5, None),
        (WHOLE, 5.0, None),
        (WHOLE, 5.5, "write a whole number"),
        (WHOLE, 0, "write 1 to 1000000"),
        (WHOLE, math.nan, "write 1 to 1000000"),
        (WHOLE, False, "write a number"),
        (CHOICE, "prejudice", None),
        (CHOICE, "Grace", "write grace or prejudice"),
        (CHOICE, "", "write grace or prejudice"),
        (CHOICE, 0, "write grace or prejudice"),
        (CHOICE, True, "write grace or prejudice"),
        (CHOICE, ["grace"], "write grace or prejudice"),
        (TEXT, "", None),
        (TEXT, "12345", None),
        (TEXT, "123456", "write a text of at most 5 characters"),
        (TEXT, 12345, "write a text of at most 5 characters"),
        (TEXT, b"123", "write a text of at most 5 characters"),
        (TEXT, None, "write a text of at most 5 characters"),
        (OPTIONAL, -1, "write 0 to 10"),
        (replace(WHOLE, maximum=1, limits="0 or 1"), "high", "write 0 or 1"),
        (replace(NUMBER, minimum=-(2.0**53), maximum=1e18), "x", "write a number"),
        (replace(NUMBER, minimum=-(2.0**31), maximum=2.0**53), -1e300, "write -2147483648 to 2^53"),
        (replace(NUMBER, minimum=1e-6, maximum=1e18), 0, "write 1e-6 to 1e18"),
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
        "tilt": "parameters of go are angle_deg, count, how",
        "angle_deg": "this one is missing: an angle",
        "count": "write a number",
        "how": "write grace or prejudice",
    }
    assert values == {}
    assert filled("go", (NUMBER,), {"angle_dg": 1}) == (
        {},
        {"angle_dg": 'did you mean "angle_deg"? parameters of go are angle_deg'},
    ), "what was meant is not missing too"
    assert filled("rest", (), {"x": 1}) == ({}, {"x": "parameters of rest are none"})


@pytest.mark.parametrize(
    ("said", "means"), [("immediate", "prejudice"), ("controlled", "grace"), ("grace", "grace")]
)
def test_other_words_for_a_choice_are_taken(said: str, means: str) -> None:
    assert filled("stop", (SYNONYMS,), {"how": said}) == ({"how": means}, {})


def test_what_is_no_word_of_a_choice_is_refused() -> None:
    assert filled("stop", (SYNONYMS,), {"how": ["immediate"]})[1] == {"how": "write grace or prejudice"}
    assert (
        SYNONYMS.described()
        == "in which way, grace or prejudice (also controlled or immediate), default grace"
    )


def test_null_is_as_missing() -> None:
    assert filled("go", (CHOICE,), {"how": None})[1] == {"how": "this one is missing: in which way"}


def test_a_verb_tells_all_that_is_wrong_with_its_parameters() -> None:
    verb = Verb("go", "go there", (NUMBER, WHOLE))
    assert verb.filled({"angle_deg": 1, "count": 2}) == {"angle_deg": 1, "count": 2}
    with pytest.raises(VerbRefused) as refused:
        verb.filled({"angle_deg": math.nan})
    assert refused.value.code == "bad_parameter"
    assert refused.value.code in CODES
    assert str(refused.value) == "angle_deg: write -90 to 90; count: this one is missing: how many"


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
    assert load.problem(2e3) == "write -3 to 3 times of what it holds"


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
