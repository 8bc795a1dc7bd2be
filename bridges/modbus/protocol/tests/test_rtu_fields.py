"""Fields of frames of Modbus RTU: names, values and the bytes that they are."""

import pytest

from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.rtu_fields import frame_fields


def fields(function, data, asked=b""):
    raw = encode(17, function, bytes.fromhex(data))
    found = frame_fields(raw, asked)
    ends = [field for field in found if not field.level or field.begin < field.end]
    covered = [False] * len(raw)
    for field in ends:
        covered[field.begin : field.end] = [True] * (field.end - field.begin)
    assert all(covered)
    return {name: (text, begin, end) for name, text, begin, end, _ in found}


def test_a_read_and_its_answer():
    question = encode(17, 3, bytes.fromhex("006b0002"))
    assert fields(3, "006b0002")["first holding register"] == ("107", 2, 4)
    answer = fields(3, "04022b0064", question)
    assert answer["function"] == ("3 (read holding registers)", 1, 2)
    assert answer["holding register 107"] == ("555 (022bh)", 3, 5)
    assert answer["holding register 108"] == ("100 (0064h)", 5, 7)
    assert answer["CRC"][0].endswith("right")


def test_a_wrong_crc_says_which_is_right():
    raw = encode(17, 3, bytes.fromhex("006b0002"))
    (*_, check) = frame_fields(raw[:-2] + b"\0\0", b"")
    assert check.text == f"00 00, wrong, {raw[-2:].hex(' ')} would be right"


@pytest.mark.parametrize(
    ("function", "data", "asked", "name", "value"),
    [
        (5, "00acff00", "", "value", ("1", 4, 6)),
        (15, "0013000a02cd01", "", "coil 19", ("1", 7, 8)),
        (15, "0013000a", "0013000a02cd01", "how many", ("10", 4, 6)),
        (16, "00010002040000000a", "", "holding register 2", ("10 (000ah)", 9, 11)),
        (22, "000400f20025", "", "and", ("00f2h", 4, 6)),
        (23, "00030006000e00010200ff", "", "holding register 14", ("255 (00ffh)", 11, 13)),
        (0x83, "02", "006b0002", "exception", ("02 (illegal data address)", 2, 3)),
        (8, "0000a537", "", "sub-function", ("0", 2, 4)),
        (99, "0102", "", "data", ("01 02 (function 99 is not known)", 2, 4)),
        (17, "0261ff", "", "data", None),
    ],
)
def test_each_function_has_fields(function, data, asked, name, value):
    found = fields(function, data, encode(17, function & 0x7F, bytes.fromhex(asked)) if asked else b"")
    assert value is None or found[name] == value
