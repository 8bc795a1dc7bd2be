"""Intel HEX: what is read, and where a damaged file is said to be damaged."""

from contextlib import suppress
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.sketch.intel_hex import FilePiece, check_overlaps, read_hex, write_hex
from hil.sketch.program_error import ProgramError

END = ":00000001FF\n"


def read(text: str) -> list[tuple[int, bytes]]:
    pieces = read_hex("x.hex", text.encode())
    check_overlaps("x.hex", pieces)
    return [(piece.at, piece.data) for piece in pieces]


def refused(text: str) -> str:
    with pytest.raises(ProgramError) as error:
        read(text)
    return str(error.value)


def test_records_with_any_line_ends_and_digits() -> None:
    assert read(":0200100001 02EB\r\n".replace(" ", "") + END) == [(0x10, b"\1\2")]
    assert read("\n:02001000aBcD76  \n\n" + END.strip()) == [(0x10, b"\xab\xcd")]
    assert read(":00000001FF") == []


def test_addresses_count_from_where_a_record_says() -> None:
    linear = ":020000040001F9\n:01FFFF00AA57\n"
    assert read(linear + END) == [(0x1FFFF, b"\xaa")]
    segment = ":020000021000EC\n:02FFFF00AABB9B\n"  # from 10000h on, and from there again after 64 kB
    assert read(segment + END) == [(0x10000, b"\xbb"), (0x1FFFF, b"\xaa")]


def test_where_a_program_starts_is_read_over() -> None:
    assert read(":0400000300007E007B\n:04000005000000CD2A\n:0100000001FE\n" + END) == [(0, b"\1")]


def test_records_may_say_the_same_twice() -> None:
    assert read(":020000000102FB\n:0100010002FC\n" + END) == [(0, b"\1\2"), (1, b"\2")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "x.hex:1:1: the record of the end (:00000001FF) is missing, so the file may be cut"),
        (":0100000001FE\n", "x.hex:2:1: the record of the end (:00000001FF) is missing"),
        ("\x7fELF", "x.hex:1:1: a record begins with a colon (give an Intel HEX file"),
        (":0100000001FE\n0100000001FE\n" + END, "x.hex:2:1: a record begins with a colon (build or copy"),
        (":01000000g1FE\n" + END, "x.hex:1:10: the byte 0x67 is no hexadecimal digit"),
        (":01000000\u00e91FE\n" + END, "x.hex:1:10: the byte 0xc3 is no hexadecimal digit"),
        (":\n" + END, "x.hex:1:2: the record has 0 digits; for its length of 0 bytes it has 10"),
        (
            ":0200000001FE\n" + END,
            "x.hex:1:14: the record has 12 digits; for its length of 2 bytes it has 14",
        ),
        (":0100000001FE00\n" + END, "x.hex:1:14: the record has 14 digits; for its length of 1 bytes"),
        (":0100000001FE0\n" + END, "x.hex:1:14: the record has 13 digits"),
        (":0100000001FF\n" + END, "x.hex:1:12: the checksum is FF, and the record's bytes make FE"),
        (":0100000601F8\n" + END, "x.hex:1:8: there is no record of type 06"),
        (":0100000401FA\n" + END, "x.hex:1:2: a record of type 04 has 2 bytes of data, not 1"),
        (END + ":0100000001FE\n", "x.hex:2:1: a line follows the record of the end, which is line 1"),
        (
            ":020000000102FB\n:020001000203F8\n:0100020004F9\n" + END,
            "x.hex:3:10: 0x0002 is 04 here, and 03 in line 2 (leave one program",
        ),
        (":0100010004FA\n:020000000102FB\n" + END, "x.hex:2:12: 0x0001 is 02 here, and 04 in line 1"),
    ],
)
def test_a_damaged_file_is_refused_with_the_place(text: str, said: str) -> None:
    assert refused(text).startswith(said)


pieces_of_chance = st.lists(
    st.tuples(st.integers(0, 0x30000), st.binary(min_size=1, max_size=300)), min_size=1, max_size=5
)


@given(pieces_of_chance, st.integers(1, 255))
def test_what_is_written_is_read(pieces: list[tuple[int, bytes]], record_bytes: int) -> None:
    image, at = {}, 0
    written = []
    for gap, data in pieces:
        at += gap
        written.append((at, data))
        image |= {at + place: byte for place, byte in enumerate(data)}
        at += len(data)
    read = read_hex("x.hex", write_hex(written, record_bytes))
    assert {piece.at + place: byte for piece in read for place, byte in enumerate(piece.data)} == image


def test_a_changed_character_never_goes_unseen() -> None:
    random = Random(1)
    whole = write_hex([(0, random.randbytes(400)), (0x10010, random.randbytes(30))])
    good = read_hex("x.hex", whole)
    for at, was in enumerate(whole):
        changed = bytearray(whole)
        changed[at] = random.choice([each for each in b"0123456789ABCDEF:\nx\xff" if each != was])
        try:
            assert read_hex("x.hex", bytes(changed)) == good  # as a line's end that is another
        except ProgramError as error:
            place = error.problem
            line = changed[:at].count(b"\n") + 1
            assert abs(place.line - line) <= 1
            assert place.column >= 1


@given(st.binary(max_size=200))
def test_noise_is_refused_or_read(noise: bytes) -> None:
    for content in (noise, b":" + noise.hex().encode(), END.encode() + noise):
        with suppress(ProgramError):
            assert all(isinstance(piece, FilePiece) for piece in read_hex("x.hex", content))
