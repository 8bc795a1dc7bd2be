"""Text of other programs' files, and the tally of what was left out of it."""

import pytest

from hil.wire.outside_text import LeftOut, lines_of, text_of


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings(encoding: str) -> None:
    assert text_of("a °C ü".encode(encoding)) == "a °C ü"


def test_any_bytes_are_text_and_lines_end_in_three_ways() -> None:
    assert text_of(bytes(range(256)))
    assert text_of(b"\xff\xfe\0") == "\ufffd"
    assert lines_of("a\r\nb\rc\nd") == ["a", "b", "c", "d"]


def test_reasons_are_counted_and_are_few() -> None:
    left_out = LeftOut()
    assert left_out.told() == ""
    for number in range(20):
        left_out.add(f"line {number}", f"reason {number % 10}", "x\n")
    left_out.note("otherwise")
    said = left_out.told()
    assert said.startswith("20 left out: line 0 'x\\n' and 1 more: reason 0; ")
    assert "line 6 'x\\n' and 7 more: for other reasons; otherwise" in said
    assert said.isprintable()
