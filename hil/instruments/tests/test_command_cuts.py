"""Where commands begin and end in a stream of bytes."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hil.instruments.command_cuts import CommandCutter, Cuts


def cut(cuts: Cuts, text: str) -> list[str]:
    """Commands in a text."""
    cutter = CommandCutter(cuts)
    return [line for byte in text if (line := cutter.feed(byte)) is not None]


@pytest.mark.parametrize(
    ("begins", "text", "found"),
    [
        ("\xff\xff\xfd", "\xff\xff\xff\xfd12", ["\xff\xff\xfd12"]),
        ("abab", "abaababx", ["ababx"]),
        ("#", "x#12#123", ["#12", "#12"]),
    ],
)
def test_what_comes_before_a_beginning_is_dropped(begins: str, text: str, found: list[str]) -> None:
    assert cut(Cuts(size=len(found[0]), begins=begins), text) == found


@settings(max_examples=400)
@given(st.text("ab", min_size=1, max_size=4), st.text("ab", max_size=30))
def test_a_beginning_is_found_wherever_it_is(begins: str, text: str) -> None:
    at, found = 0, []
    size = len(begins) + 1
    while (at := text.find(begins, at)) >= 0 and at + size <= len(text):
        found.append(text[at : at + size])
        at += size
    assert cut(Cuts(size=size, begins=begins), text) == found


@pytest.mark.parametrize(
    ("length", "is_cut"), [(9, False), (10, False), (11, True), (12, True), (13, True), (40, True)]
)
@pytest.mark.parametrize("end", ["\r", "\r\n", "END"])
def test_a_command_that_is_too_long(length: int, end: str, *, is_cut: bool) -> None:
    cutter = CommandCutter(Cuts((end,), longest=10))
    assert [cutter.feed(byte) for byte in "x" * length + end][-1] is not None
    assert cutter.is_cut is is_cut
    cutter.is_cut = False
    assert [cutter.feed(byte) for byte in "y" + end][-1] == "y"
    assert not cutter.is_cut
