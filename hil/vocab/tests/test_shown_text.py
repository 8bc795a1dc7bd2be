"""Text that may be anybody's, for a terminal."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.vocab.shown_text import printable, printable_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b]0;x\x07\x1b[2J", "\\x1b]0;x\\x07\\x1b[2J"),
        ("\x9b31m\x85", "\\x9b31m\\x85"),
        ("a\u202eb\u2066c\u200b\ufeff", "a\\u202eb\\u2066c\\u200b\\ufeff"),
        ("\udcff", "\\udcff"),
        ("ok\rno", "ok\\rno"),
        ("ü°µ ▁█ 日本", "ü°µ ▁█ 日本"),
    ],
)
def test_what_a_terminal_would_carry_out_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == printable_lines(text) == shown


def test_lines_keep_their_ends_and_a_line_has_none() -> None:
    assert printable_lines("a\tb\r\nc\n") == "a\tb\r\nc\n"
    assert printable("a\tb\r\nc\n") == "a\\tb\\r\\nc\\n"


@given(st.text())
def test_nothing_is_left_and_nothing_more_happens_the_second_time(text: str) -> None:
    assert printable(text).isprintable()
    lines = printable_lines(text)
    assert lines.replace("\r\n", "").replace("\n", "").replace("\t", "").isprintable()
    assert printable_lines(lines) == lines
