"""JSON from outside: what is read, what is refused, and that a refusal costs no time."""

import json
import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.wire.json_text import DEEPEST, JsonError, read_json

INTEGERS = st.integers(-(1 << 63), (1 << 64) - 1)
FLOATS = st.floats(allow_nan=False, allow_infinity=False)
TEXTS = st.text(st.characters(exclude_categories=["Cs"]))
VALUES = st.recursive(
    st.none() | st.booleans() | INTEGERS | FLOATS | TEXTS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4),
    max_leaves=20,
)


@given(VALUES, st.booleans())
def test_what_is_json_is_read(value: object, is_ascii: bool) -> None:
    text = json.dumps(value, ensure_ascii=is_ascii)
    assert read_json(text) == value
    assert read_json(text.encode()) == value


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (b"\xff", "byte 0 is no UTF-8"),
        (b"\xff\xfe1\x00", "byte 0 is no UTF-8"),
        ("", "Expecting value, at character 1"),
        ("{} {}", "Extra data, at character 4"),
        ('"a\0"', "Invalid control character at, at character 3"),
        ("NaN", "NaN is no number"),
        ("[1, -Infinity]", "-Infinity is no number"),
        ("1e999", "1e999 is more than a float holds"),
        ("9" * 400 + ".0", "999999999999999999999999 is more than a float holds"),
        ("9" * 401, "999999999999999999999999... is no number of 64 bits"),
        ("9" * 5000, "999999999999999999999999... is no number of 64 bits"),
        (str(1 << 64), "18446744073709551616 is no number of 64 bits"),
        (str(-(1 << 63) - 1), "-9223372036854775809 is no number of 64 bits"),
        ('{"a": "\\ud800"}', "half of a surrogate pair is no character"),
        ('{"\\uDfff": 1}', "half of a surrogate pair is no character"),
    ],
)
def test_what_is_none_says_why(text: str | bytes, why: str) -> None:
    with pytest.raises(JsonError) as caught:
        read_json(text)
    assert str(caught.value) == why


@pytest.mark.parametrize(("opening", "closing"), [("[", "]"), ('{"a":', "}"), ('[{"a":1,"b":', "}]")])
def test_nesting_has_an_end(opening: str, closing: str) -> None:
    levels = DEEPEST // (opening.count("[") + opening.count("{"))
    assert read_json(opening * levels + "1" + closing * levels) is not None
    for deep in (levels + 1, 500, 100_000):
        for text in (opening * deep + "1" + closing * deep, opening * deep):
            with pytest.raises(JsonError):
                read_json(text)


def test_brackets_in_texts_and_side_by_side_are_no_nesting() -> None:
    assert read_json(json.dumps("[" * 100)) == "[" * 100
    assert read_json(json.dumps(["[" * 100, *([[]] * 100)])) == ["[" * 100, *([[]] * 100)]


@given(st.text(max_size=60) | st.binary(max_size=60))
def test_any_text_is_read_or_refused(text: str | bytes) -> None:
    with suppress(JsonError):
        value = read_json(text)
        assert not isinstance(value, float) or math.isfinite(value)
