"""Values of a drive in its registers, and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.drive_map import TYPES, RegisterPlace

HOLDING = Table.HOLDING_REGISTERS


@pytest.mark.parametrize(
    ("type_name", "scale", "value", "words"),
    [
        ("u16", 1, 65535, (0xFFFF,)),
        ("i16", 0.1, -12.3, (0xFF85,)),
        ("u32", 1, 65536, (1, 0)),
        ("i32", 0.01, -0.01, (0xFFFF, 0xFFFF)),
        ("i32", 0.01, 0.57, (0, 57)),
        ("f32", 1, 90.1, (0x42B4, 0x3333)),
        ("i16", -0.5, 10, (0xFFEC,)),
    ],
)
def test_a_value_has_these_words(type_name: str, scale: float, value: float, words: tuple[int, ...]) -> None:
    place = RegisterPlace(HOLDING, 0, type_name, scale)
    assert place.words(value) == words
    assert place.value(words) == value
    assert place.words(value, is_low_first=True) == words[::-1]
    assert place.value(words[::-1], is_low_first=True) == value
    assert place.width == len(words)


@given(st.sampled_from(TYPES[:-1]), st.sampled_from((0.01, 0.001, 0.1, 1.0, 360.0, -0.05)), st.data())
def test_words_come_back_whatever_the_scale(type_name: str, scale: float, data: st.DataObject) -> None:
    place = RegisterPlace(HOLDING, 0, type_name, scale)
    words = tuple(data.draw(st.integers(0, 65535)) for _ in range(place.width))
    value = place.value(words)
    assert place.holds(value)
    assert place.words(value) == words
    if scale in (0.01, 0.001, 0.1):  # the nearest number to the decimal one
        assert value == round(value, 3)


@given(st.sampled_from(TYPES), st.floats(allow_nan=False, allow_infinity=False))
def test_a_value_that_does_not_fit_is_known_and_becomes_the_nearest(type_name: str, value: float) -> None:
    place = RegisterPlace(HOLDING, 0, type_name, 0.5)
    words = place.words(value)
    if place.holds(value):
        assert place.value(words) == pytest.approx(value, rel=1e-6, abs=0.25 if type_name != "f32" else 1e-44)
    else:
        assert abs(place.value(words)) < abs(value) or type_name == "f32"


def test_what_is_no_number_fits_nowhere() -> None:
    assert not any(
        RegisterPlace(HOLDING, 0, kind).holds(value)
        for kind in TYPES
        for value in (float("nan"), float("inf"))
    )
