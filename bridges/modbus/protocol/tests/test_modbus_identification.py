"""Read Device Identification: categories, single objects, as many answers as it takes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.protocol.client_side import ask_identification, encode, parse_answer
from bridges.modbus.protocol.identification import (
    OBJECT_BYTES_MAX,
    Identification,
    IdentificationPiece,
    ReadDeviceId,
    identify,
)
from bridges.modbus.protocol.pdu import Code, Refused, parse

BASIC = Identification("Acme", "M1", "1.0")
REGULAR = Identification("Acme", "M1", "1.0", product_name="Motor", user_application_name="left")
EXTENDED = Identification("Acme", "M1", "1.0", model_name="m", extended={0xFF: b"z", 0x80: b"\0\1"})
TEXTS = st.text(st.characters(codec="ascii"), max_size=OBJECT_BYTES_MAX)
DEVICES = st.builds(
    Identification,
    *[TEXTS] * 7,
    extended=st.dictionaries(st.integers(0x80, 0xFF), st.binary(max_size=OBJECT_BYTES_MAX), max_size=8),
)


def ask(device: Identification, code: int, object_id: int = 0) -> IdentificationPiece:
    request = parse(encode(ask_identification(ReadDeviceId(code), object_id)))
    reply = identify(request, device)
    assert len(reply) <= 253
    piece = parse_answer(request, reply).identification
    assert piece
    return piece


def ask_all(device: Identification, code: int) -> dict[int, bytes]:
    """Objects of a category, asked for until no more follow."""
    objects, next_object_id = dict[int, bytes](), 0
    while True:
        piece = ask(device, code, next_object_id)
        assert piece.objects
        assert not objects.keys() & piece.objects.keys()
        objects |= piece.objects
        if piece.next_object_id is None:
            return objects
        next_object_id = piece.next_object_id


@pytest.mark.parametrize(
    ("device", "level", "basic", "regular", "extended"),
    [
        (BASIC, 0x81, [0, 1, 2], [0, 1, 2], [0, 1, 2]),
        (REGULAR, 0x82, [0, 1, 2], [0, 1, 2, 4, 6], [0, 1, 2, 4, 6]),
        (EXTENDED, 0x83, [0, 1, 2], [0, 1, 2, 5], [0, 1, 2, 5, 0x80, 0xFF]),
    ],
    ids=["basic", "regular", "extended"],
)
def test_a_category_has_those_before_it(
    device: Identification, level: int, basic: list[int], regular: list[int], extended: list[int]
) -> None:
    for code, numbers in enumerate((basic, regular, extended), 1):
        piece = ask(device, code)
        assert (list(piece.objects), piece.next_object_id) == (numbers, None)
        assert (piece.read_device_id_code, piece.conformity_level) == (code, level)


def test_a_stream_begins_where_it_is_asked_for_or_at_the_first() -> None:
    assert list(ask(EXTENDED, 3, 2).objects) == [2, 5, 0x80, 0xFF]
    assert list(ask(EXTENDED, 3, 0xFF).objects) == [0xFF]
    for unknown in (3, 7, 0x7F, 0x81):
        assert list(ask(EXTENDED, 3, unknown).objects) == [0, 1, 2, 5, 0x80, 0xFF]
    assert list(ask(EXTENDED, 1, 5).objects) == [0, 1, 2], "it is there, and not in this category"


def test_a_single_object() -> None:
    assert ask(EXTENDED, 4, 0x80) == (4, 0x83, None, {0x80: b"\0\1"})
    assert ask(BASIC, 4, 2) == (4, 0x81, None, {2: b"1.0"})
    for unknown in (3, 0x81):
        with pytest.raises(Refused, match=f"no object {unknown}") as refused:
            ask(EXTENDED, 4, unknown)
        assert refused.value.code == Code.ILLEGAL_DATA_ADDRESS


@given(DEVICES)
def test_all_objects_come_however_long_they_are(device: Identification) -> None:
    assert ask_all(device, 3) == device.objects
    assert list(ask_all(device, 3)) == sorted(device.objects)
    for number, value in device.objects.items():
        assert ask(device, 4, number).objects == {number: value}


def test_a_piece_is_as_full_as_it_can_be() -> None:
    room = OBJECT_BYTES_MAX - 2 * 2
    """Of three objects: two more have numbers and lengths of their own."""
    for size, numbers, next_object_id in [(room, [0, 1, 2], 5), (room + 1, [0, 1], 2)]:
        piece = ask(Identification("a" * (size - 2), "b", "c", model_name="d"), 2)
        assert (list(piece.objects), piece.next_object_id) == (numbers, next_object_id)


@pytest.mark.parametrize(
    ("device", "why"),
    [
        ({"vendor_name": "é"}, "ascii"),
        ({"vendor_name": "a" * 245}, "object 0 has 245 bytes; 244 fit"),
        ({"extended": {0x7F: b""}}, r"128 to 255, not \[127\]"),
        ({"extended": {256: b""}}, r"128 to 255, not \[256\]"),
    ],
)
def test_what_cannot_be_said_is_refused_at_once(device: dict[str, str], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        Identification(**{"vendor_name": "", "product_code": "", "revision": "", **device})  # type: ignore[arg-type]
