"""Keys that are typed in a terminal, in pieces of any length."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.cli.monitor.typed_keys import COMMAND, QUIT, KeyReader, MacroRefused, macro_in, macros_in

PLAIN = st.binary().filter(lambda data: QUIT not in data and COMMAND not in data)


@given(PLAIN, st.sampled_from([b"\r", b"\n", b"\r\n", b""]), st.integers(1, 7))
def test_each_key_is_sent_and_enter_as_the_board_takes_it(keys: bytes, enter: bytes, size: int) -> None:
    reader = KeyReader(enter)
    sent = b"".join(reader.read(keys[at : at + size]).data for at in range(0, len(keys), size))
    assert sent == keys.replace(b"\r", enter)


@given(st.binary(), st.integers(1, 7))
def test_pieces_are_read_as_the_whole(keys: bytes, size: int) -> None:
    macros = {chr(key): bytes((key,)) * 3 for key in range(0x21, 0x7F)}
    whole = KeyReader(b"\n", macros).read(keys)
    reader, sent, is_end = KeyReader(b"\n", macros), b"", False
    for at in range(0, len(keys), size):
        came = reader.read(keys[at : at + size])
        sent, is_end = sent + came.data, is_end or came.is_end
        if is_end:
            break
    assert (sent, is_end) == (whole.data, whole.is_end)


def test_a_macro_types_its_text_and_other_keys_say_that_they_do_not() -> None:
    reader = KeyReader(b"\n", {"1": b"m3000v150\r"})
    assert reader.read(b"\x14").data == b""
    assert reader.read(b"1x").data == b"m3000v150\rx"
    assert reader.read(b"\x142").unknown == "2"
    assert reader.read(b"\x14?").asks_help
    assert reader.read(b"\x14\x14\x14\x1d").data == b"\x14\x1d"
    assert reader.read(b"a\x1db").is_end
    assert "Ctrl-T 1  types m3000v150\\r" in reader.help_lines()


def test_a_macro_has_a_key_and_a_text() -> None:
    assert macro_in(r"1=a=\x1b\r") == ("1", b"a=\x1b\r")
    for wrong, word in (("1", "no macro"), ("ab=x", "no key"), ("?=x", "no key"), ("1=", "nothing")):
        with pytest.raises(MacroRefused, match=word):
            macro_in(wrong)
    with pytest.raises(MacroRefused, match="means nothing"):
        macro_in(r"1=\q")


def test_all_problems_of_a_file_are_told_with_their_places() -> None:
    macros, problems = macros_in(["# moves", "1: a b ", "", "nothing", "1: c", r"2: \q", "é: x", ":: x"])
    assert macros == {"1": b"a b ", ":": b"x"}
    assert [(line, column) for line, column, _ in problems] == [(4, 1), (5, 1), (6, 4), (7, 1)]


@given(st.lists(st.text(max_size=12), max_size=6))
def test_any_file_is_macros_or_problems(lines: list[str]) -> None:
    macros, problems = macros_in(lines)
    assert len(macros) + len(problems) <= len(lines)
    assert all(1 <= line <= len(lines) and column >= 1 for line, column, _ in problems)
