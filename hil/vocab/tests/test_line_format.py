"""Formats of characters."""

from itertools import product

import pytest

from hil.vocab.line_format import EIGHT_N_1, FORMATS, format_named


def test_formats_of_segments_are_the_same_by_name() -> None:
    assert format_named("8N1") is EIGHT_N_1
    assert all(format_named(name) is each for name, each in FORMATS.items())


@pytest.mark.parametrize(
    "name", ["", "9N1", "4N1", "8X1", "8N0", "8N3", "8n1", "8N1\n", "8N", "8N11", "\u0668N1"]
)
def test_no_such_format(name: str) -> None:
    assert format_named(name) is None


@pytest.mark.parametrize("name", ["".join(each) for each in product("5678", "NEOMS", "12")])
def test_levels_of_a_character(name: str) -> None:
    line_format = format_named(name)
    assert line_format
    assert line_format.name == name
    data_bits, stop_bits = int(name[0]), int(name[2])
    for byte in (0x00, 0xFF, 0x55, 0x6D, 0x72):
        levels = line_format.levels(byte)
        assert len(levels) == line_format.bits
        assert (levels[0], levels[-stop_bits:]) == (0, (1,) * stop_bits)
        data = levels[1 : 1 + data_bits]
        assert data == tuple(byte >> bit & 1 for bit in range(data_bits))
        parity = levels[1 + data_bits : -stop_bits]
        expected = {"N": (), "E": (sum(data) % 2,), "O": (1 - sum(data) % 2,), "M": (1,), "S": (0,)}
        assert parity == expected[name[1]]
