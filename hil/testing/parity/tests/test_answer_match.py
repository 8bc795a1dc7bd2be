"""Comparison of a board's answer with its twin's: bytes, measured numbers, own words."""

import pytest

from hil.testing.parity.answer_match import AnswerMatcher, Parting
from hil.testing.parity.typed_session import MeasuredNumber


def test_equal_answers_have_all_of_their_bytes() -> None:
    for text in ("", "SAC>", "a\r\nb\r\n"):
        match = AnswerMatcher({}).match(text, text)
        assert (match.percent, match.parting) == (100.0, None)


@pytest.mark.parametrize(
    ("board", "twin", "percent", "parting"),
    [
        ("abcd", "abXd", 75.0, Parting(at=2, board="abcd", twin="abXd")),
        ("one\r\ntwo\r\n", "one\r\n", 50.0, Parting(at=5, board="two\r\n", twin=None)),
        ("one\r\n", "one\r\ntwo\r\n", 50.0, Parting(at=5, board=None, twin="two\r\n")),
        ("", "SAC>", 0.0, Parting(at=0, board=None, twin="SAC>")),
        ("one\ntwo\n", "one\r\ntwo\n", 8 / 9 * 100, Parting(at=3, board="one\n", twin="one\r\n")),
        ("a\nx\nb\n", "a\nb\n", 100 * 4 / 6, Parting(at=2, board="x\n", twin=None)),
    ],
)
def test_where_answers_part(board: str, twin: str, percent: float, parting: Parting) -> None:
    match = AnswerMatcher({}).match(board, twin)
    assert match.percent == pytest.approx(percent)
    assert match.parting == parting


def test_a_measured_number_may_differ_so_far() -> None:
    rules = {"Angle: ": MeasuredNumber(within=0.5)}
    assert AnswerMatcher(rules).match("Angle: 9.80, x\r\n", "Angle: 10.30, x\r\n").parting is None
    apart = AnswerMatcher(rules).match("Angle: 9.79, x\r\n", "Angle: 10.30, x\r\n")
    assert apart.parting == Parting(at=7, board="Angle: 9.79, x\r\n", twin="Angle: 10.30, x\r\n")
    assert AnswerMatcher(rules).match("Angle: 9.80, y\r\n", "Angle: 10.30, x\r\n").parting


def test_a_number_that_turns_is_near_across_the_turn() -> None:
    rules = {"Angle: ": MeasuredNumber(within=0.5, turn=360)}
    assert AnswerMatcher(rules).match("Angle: 359.90", "Angle: 0.20").parting is None
    assert AnswerMatcher(rules).match("Angle: 359.60", "Angle: 0.20").parting


def test_a_number_from_the_first_on_compares_the_changes() -> None:
    matcher = AnswerMatcher({"Angle: ": MeasuredNumber(within=0.1, turn=360, from_first=True)})
    assert matcher.match("Angle: 200.00", "Angle: 6.30").parting is None
    assert matcher.match("Angle: 198.20", "Angle: 4.50").parting is None
    assert matcher.match("Angle: 200.00", "Angle: 2.70").parting
    assert matcher.origins == {"Angle: ": (200.0, 6.3)}


def test_a_number_at_the_beginning_of_a_line() -> None:
    matcher = AnswerMatcher({"": MeasuredNumber(within=10)})
    assert matcher.match("100\r\n-7\r\n", "109\r\n-1\r\n").parting is None
    assert matcher.match("a 100\r\n", "a 101\r\n").parting
    assert matcher.match("100\r\n120\r\n", "109\r\n131\r\n").parting == Parting(
        at=6, board="120\r\n", twin="131\r\n"
    )


def test_own_words_of_the_twin_stand_for_any_line() -> None:
    matcher = AnswerMatcher({}, lambda line: line == "(ours)")
    assert matcher.match("a\r\nTheirs, long\r\nb\r\n", "a\r\n(ours)\r\nb\r\n").parting is None
    assert matcher.match("a\r\n(ours)\r\nb\r\n", "a\r\nTheirs\r\nb\r\n").parting


def test_the_place_counts_in_the_boards_bytes() -> None:
    matcher = AnswerMatcher({"n ": MeasuredNumber(within=1000)})
    match = matcher.match("n 5\r\nabc", "n 500\r\nabX")
    assert match.parting == Parting(at=7, board="abc", twin="abX")
