"""Messages of pages, good and bad."""

import json
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.web.web_client import MessageRate
from bridges.web.web_messages import (
    NAME,
    NAMES,
    NUMBER,
    WHOLE,
    BadMessage,
    PageRequest,
    answer_text,
    read_request,
    read_terminal,
    refusal_text,
    taken,
    terminal_message,
)
from hil.vocab.desk_protocol import Done
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import json_text

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(st.text() | json_values.map(json.dumps))
def test_any_text_is_a_request_or_is_refused(text: str) -> None:
    try:
        asked = read_request(text)
    except BadMessage as error:
        json.loads(refusal_text(error.id, error))
    else:
        assert isinstance(asked, PageRequest)
        assert json.loads(text)["id"] == asked.id


@given(st.integers(0, 2**53 - 1), st.text(max_size=256), st.dictionaries(st.text(), st.text()))
def test_a_request_is_read_as_it_was_written(number: int, do: str, given: dict[str, str]) -> None:
    others = {name: value for name, value in given.items() if name not in ("id", "do")}
    assert read_request(json.dumps({**others, "id": number, "do": do})) == PageRequest(number, do, others)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no JSON"),
        ("[]", "write an object"),
        ("{}", "id: "),
        ('{"id": true, "do": "ask"}', "id: "),
        ('{"id": -1, "do": "ask"}', "id: "),
        ('{"id": 1.5, "do": "ask"}', "id: "),
        ('{"id": 9007199254740992, "do": "ask"}', "id: "),
        ('{"id": 1}', "do: "),
        ('{"id": 1, "do": 5}', "do: "),
        ('{"id": 1, "do": "ask", "x": NaN}', "no JSON"),
        ("[" * 5000, "no JSON"),
    ],
)
def test_what_is_no_request_is_told_why(text: str, why: str) -> None:
    with pytest.raises(BadMessage, match=why) as caught:
        read_request(text)
    assert caught.value.code == "bad_request"


@given(st.binary(max_size=40))
def test_any_bytes_are_for_a_terminal_or_are_refused(data: bytes) -> None:
    try:
        number, typed = read_terminal(data)
    except BadMessage:
        assert len(data) < 8 or data[0] != 2
    else:
        assert terminal_message(number, typed)[4:] == data[4:]


@given(st.integers(0, 2**32 - 1), st.binary(max_size=40))
def test_a_terminal_message_is_read_as_it_was_written(number: int, data: bytes) -> None:
    assert read_terminal(terminal_message(number, data)) == (number, data)
    assert terminal_message(number, data)[:8] == struct.pack("<BBHI", 2, 0, 0, number)


FORMS = {"a": NAME, "n": NUMBER, "w": WHOLE, "fields": NAMES}


@given(st.dictionaries(st.sampled_from(["a", "n", "w", "fields", "b"]), json_values))
def test_what_is_given_fits_or_is_refused(given: dict[str, object]) -> None:
    fits = (
        given.keys() >= {"a", "n", "w"}
        and "b" not in given
        and all(FORMS[name].fits(value) for name, value in given.items())
    )
    if fits:
        assert taken(given, FORMS, {"fields": []}) == {"fields": [], **given}
    else:
        with pytest.raises(VerbRefused) as caught:
            taken(given, FORMS, {"fields": []})
        assert caught.value.code == "bad_parameter"


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(VerbRefused) as caught:
        taken({"a": 5, "b": 1}, FORMS, {"fields": []})
    assert str(caught.value) == (
        "b: there is no such thing here; a: write a text of at most 256 characters;"
        " n: this one is missing; w: this one is missing"
    )


def test_what_is_no_number_in_json_is_null() -> None:
    assert json_text({"a": [float("nan"), (1.5, float("-inf"))]}) == '{"a": [null, [1.5, null]]}'.replace(
        " ", ""
    )
    assert answer_text(3, Done(7, {"x": float("inf")})) == '{"id":3,"answer":{"effective_at_ns":7,"x":null}}'


def test_problems_of_a_text_have_their_places() -> None:
    why = "<run>:2:8: steps: a list is wanted (write [])\n/a:b/c.yaml:11:1: no: so\n<run>: nothing is here"
    told = json.loads(refusal_text(1, VerbRefused("bad_run", why)))["error"]
    assert told["problems"] == [
        {"line": 2, "column": 8, "message": "steps: a list is wanted (write [])"},
        {"line": 11, "column": 1, "message": "no: so"},
        {"line": 0, "column": 0, "message": "<run>: nothing is here"},
    ]
    assert "problems" not in json.loads(refusal_text(1, VerbRefused("not_now", why)))["error"]


def test_messages_of_a_second_come_at_once_then_each_has_to_wait() -> None:
    rate = MessageRate(10)
    assert [rate.delay_s(5.0) for _ in range(10)] == [0.0] * 10
    assert rate.delay_s(5.0) == pytest.approx(0.1)
    assert rate.delay_s(5.0) == pytest.approx(0.2)
    assert rate.delay_s(20.0) == 0.0
