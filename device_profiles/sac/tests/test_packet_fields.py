"""Fields of a SAC's packets: names, values and the bytes that they are."""

import pytest

from device_profiles.sac.framing import FRAMING
from device_profiles.sac.packet import encode
from hil.wire.packet_fields import fields_of


def fields(raw):
    (item,) = FRAMING.splitter().burst(raw, 0, 38400).items
    return {name: (text, begin, end) for name, text, begin, end, _ in fields_of(FRAMING, item)}


def test_a_command_has_its_argument_and_its_crc():
    found = fields(encode(85, 1, b"m3000"))
    assert found["to"] == ("85", 1, 2)
    assert found["from"] == ("1", 2, 3)
    assert found["command"] == ("m", 3, 4)
    assert found["argument"] == ("3000", 4, 8)
    assert found["CRC"] == ("3Ch, right", 9, 10) or found["CRC"][0].endswith("h, right")
    assert found["NUL"][1:] == (10, 11)


@pytest.mark.parametrize(
    ("raw", "name", "text"),
    [
        (encode(0, 85, b"m1", crc=False), "to", "all"),
        (encode(1, 85, b"\x06"), "data", "ACK"),
        (encode(1, 85, b"m1")[:-2] + b"\x01\0", "CRC", "01h, wrong"),
        (b"\x02\x55\x01m\0", "bytes", "02 55 01 6d 00"),
    ],
)
def test_what_is_short_or_wrong_has_fields(raw, name, text):
    assert fields(raw)[name][0].startswith(text)
