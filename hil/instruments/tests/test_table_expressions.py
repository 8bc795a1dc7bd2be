"""Expressions of a table: what they are worth, and what is none."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.instruments.instrument_table import Variable
from hil.instruments.table_expressions import (
    INFINITE,
    ExpressionRefused,
    Meaning,
    Value,
    in_order,
    loop_in,
    read_expression,
)

KNOWN: dict[str, Meaning] = {
    "voltage_V": Variable("voltage_V", unit="V"),
    "limit_V": Variable("limit_V", unit="V"),
    "current_A": Variable("current_A", unit="A"),
    "output": Variable("output", "switch"),
    "mode": Variable("mode", "choice", words=("CV", "CC")),
    "relay": Variable("relay", "switch", many=4),
}
VALUES: dict[str, Value] = {"voltage_V": 5.0, "limit_V": 8.0, "current_A": 2.0, "output": 1.0, "mode": "CC"}


def look(name: str, number: int | None) -> Value:
    return float(number == 2) if name == "relay" else VALUES[name]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("voltage_V * current_A", 10.0),
        ("-voltage_V + 2 * limit_V", 11.0),
        ("voltage_V if output else 0", 5.0),
        ("1 < voltage_V <= 5 and not (mode == 'CV')", 1.0),
        ("relay[2] + relay[current_A - 1]", 1.0),
        ("min(voltage_V, limit_V) + abs(-1) + round(2.5) + max(1, 2, 3)", 12.0),
        ("voltage_V // 2 + voltage_V % 2", 3.0),
        ("voltage_V / 0", INFINITE),
        ("0 / 0 + voltage_V % 0 + sqrt(-4)", 0.0),
        ("mode if output else 'none'", "CC"),
        ("relay[4]", 0.0),
        ("9e37 * 9e37", INFINITE),
    ],
)
def test_values(text: str, value: Value) -> None:
    assert read_expression(text, KNOWN).value(look) == value


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("voltge_V", 'there is no variable "voltge_V"'),
        ("voltage_V + current_A", "V and A do not go together"),
        ("min(voltage_V, current_A)", "V and A do not go together"),
        ("mode + 1", "mode is a text, not a number"),
        ("mode == 1", "a text is compared with a number"),
        ("relay", "relay does not stand so here"),
        ("voltage_V[1]", "voltage_V does not stand so here"),
        ("relay[5]", "there is no 5 of relay"),
        ("open('x')", 'there is no function "open"'),
        ("voltage_V.real", "voltage_V.real is not computed here"),
        ("2 ** 9999", "2 ** 9999 is not computed here"),
        ("[1 for _ in ()]", "[1 for _ in ()] is not computed here"),
        ("__import__('os')", 'there is no function "__import__"'),
        ("1 +", "'1 +' is no expression"),
        ("(" * 399, f"{'(' * 399!r} is no expression"),
        ("1" * 401, "this expression is too long"),
        ("abs(1, 2)", "abs takes 1 numbers"),
    ],
)
def test_refused(text: str, why: str) -> None:
    with pytest.raises(ExpressionRefused) as refused:
        read_expression(text, KNOWN)
    assert str(refused.value) == why
    assert refused.value.remedy


@given(st.text(alphabet="voltage_V output()+-*/<>=[]!.,'\" 0123456789 and or not if else min", max_size=60))
def test_any_text_is_an_expression_or_is_refused(text: str) -> None:
    try:
        value = read_expression(text, KNOWN).value(look)
    except ExpressionRefused:
        return
    assert isinstance(value, str) or math.isfinite(value)


def test_units_go_on_where_they_are_known() -> None:
    assert read_expression("voltage_V if output else 0", KNOWN).unit == "V"
    assert read_expression("voltage_V / current_A", KNOWN).unit == ""


def test_loops_are_found_and_an_order_without_them() -> None:
    reads = {"a": frozenset({"b", "x"}), "b": frozenset({"c"}), "c": frozenset[str]()}
    assert loop_in(reads) == ()
    assert in_order(reads) == ("c", "b", "a")
    assert loop_in(reads | {"c": frozenset({"a"})}) == ("a", "b", "c")
