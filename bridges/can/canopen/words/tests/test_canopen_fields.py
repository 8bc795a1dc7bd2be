"""Fields of CANopen frames: names, values and the bytes that they are."""

import pytest

from bridges.can.canopen.words.canopen_words import CanOpenWords
from bridges.can.frames.can_frame import parse_frame


def fields(*frames):
    words = CanOpenWords()
    for text in frames:
        frame = parse_frame(text)
        words.say(frame)
        found = words.fields(frame)
    return [(name, text, begin, end) for name, text, begin, end, _ in found]


def test_an_answer_of_an_sdo_has_its_object_and_value():
    assert fields("605#4000100000000000", "585#4300100092010200") == [
        ("identifier", "585h", 0, 0),
        ("service", "SDO answer", 0, 0),
        ("node", "5", 0, 0),
        ("command", "upload, with its value", 0, 1),
        ("index", "1000h", 1, 3),
        ("sub-index", "0", 3, 4),
        ("object", "1000h Device type", 1, 4),
        ("value", "00020192h", 4, 8),
    ]


def test_a_pdo_has_what_is_mapped():
    mapping = ("585#4F001A0002000000", "585#43001A0110004160", "585#43001A0220006460")
    (_, _, _, *values) = fields(*mapping, "185#370410270000")
    assert [(name.partition(" ")[0], begin, end) for name, _, begin, end in values] == [
        ("6041h", 0, 2),
        ("6064h", 2, 6),
    ]


@pytest.mark.parametrize(
    ("frame", "last"),
    [
        ("000#0105", ("node", "5", 1, 2)),
        ("705#05", ("state", "operational", 0, 1)),
        ("085#2081110000000000", ("manufacturer's own", "00 00 00 00 00", 3, 8)),
        ("080#", ("service", "SYNC", 0, 0)),
        ("0000CAFE#0102", ("bytes", "01 02", 0, 2)),
        ("123#R2", ("remote", "asks for 2 bytes", 0, 0)),
        ("605#40", ("bytes", "40", 0, 1)),
        ("585#8099990100000206", ("reason", "06020000h", 4, 8)),
        ("605#2110200005000000", ("size", "5 bytes in segments", 4, 8)),
        ("7E5#0401000000000000", ("data", "01 00 00 00 00 00 00", 1, 8)),
    ],
)
def test_each_service_has_fields(frame, last):
    name, text, begin, end = fields(frame)[-1]
    assert (name, begin, end) == (last[0], *last[2:])
    assert text.startswith(last[1])


def test_fields_cover_every_byte_of_whatever_comes():
    for identifier in range(0x000, 0x800, 0x11):
        for first in range(0, 256, 5):
            found = fields(f"{identifier:03X}#{first:02X}00100092010200")
            covered = {at for _, _, begin, end in found for at in range(begin, end)}
            assert covered <= set(range(8))
            assert covered
