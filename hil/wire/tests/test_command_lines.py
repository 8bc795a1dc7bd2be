"""Lines about commands: each follows the one before, and what is changed or missing shows."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from hil.wire.command_lines import AFTER, BEGINS, chain_of, chained, checked_lines, command_words

ROW = {"user": "ann", "door": "zenoh", "operation": "move_abs", "target": "m1", "given": {"position_deg": 90}}
TEXTS = st.text(st.characters(codec="utf-8"), max_size=20)
ROWS = st.lists(st.dictionaries(st.sampled_from(["user", "why", "chain"]), TEXTS), min_size=2, max_size=8)


def log_of(rows: list[dict[str, Any]], after: str = "") -> list[str]:
    texts = list[str]()
    for row in [{BEGINS: "hil 1", "bench": "b", AFTER: after}, *rows]:
        texts.append(chained(row, chain_of(texts[-1]) if texts else after).text)
    return texts


def wrong(texts: list[str]) -> list[int]:
    return [number for number, line in enumerate(checked_lines(texts)) if line.wrong]


@given(ROWS)
def test_each_line_follows_the_one_before_and_one_that_is_taken_out_shows(rows: list[dict[str, Any]]) -> None:
    texts = log_of(rows)
    assert wrong(texts) == []
    assert [dict(line.row) for line in checked_lines(texts)][1] == {"v": 1, **rows[0]} | {
        "chain": chain_of(texts[1])
    }
    for out in range(1, len(texts) - 1):
        assert wrong(texts[:out] + texts[out + 1 :]) == [out]
    assert wrong(texts[1:]) == [0]


@given(
    st.lists(st.one_of(TEXTS, st.sampled_from(['{"chain":1}', "[]", '{"v":1,"chain":"' + "0" * 64 + '"}'])))
)
def test_what_is_no_line_is_said_and_hinders_nothing(texts: list[str]) -> None:
    assert len(wrong(texts)) == len(texts)


def test_a_changed_line_shows_and_the_next_is_right_again() -> None:
    texts = log_of([ROW, ROW, ROW])
    texts[2] = texts[2].replace("ann", "bob")
    assert wrong(texts) == [2]


def test_a_file_goes_on_from_another_or_from_one_that_was_removed() -> None:
    first = log_of([ROW])
    second = log_of([ROW], after=chain_of(first[-1]))
    assert wrong(first + second) == []
    assert wrong(second) == []
    assert wrong(first[:-1] + second) == [1]


def test_a_line_in_words() -> None:
    assert command_words(ROW | {"outcome": "done"}) == "ann at zenoh: m1: move_abs position_deg 90: done"
    refused = {"door": "web", "operation": "halt", "outcome": "refused", "why": "no", "count": 3}
    assert command_words(refused) == "web: halt, 3 times: refused: no"
