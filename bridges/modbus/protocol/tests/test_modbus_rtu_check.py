"""Shipped check of codecs, passed by the framing of Modbus RTU at each side of its fixed silences."""

import pytest

from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.rtu_framing import MODBUS_RTU
from hil.testing import check_codec, framing_reader
from hil.wire.serial_line import character_ns

QUESTION, ANSWER = encode(17, 3, bytes.fromhex("006b0003")), encode(17, 3, bytes.fromhex("06022b00000064"))
UNASKED = "17, function 3: 06 02 2b 00 00 00 64 (function 3 with 8 bytes; it has 5)"
MESSAGES = {
    QUESTION: [("to 17: read holding registers 107 to 109", True, "", None)],
    ANSWER: [(UNASKED, True, "", None)],
    encode(0, 6, b"\0\1\0\3"): [("to all: write holding register 1: 3", True, "", None)],
}


@pytest.mark.parametrize("baud", [9600, 115200])
def test_it_keeps_to_what_codecs_keep_to(baud: int) -> None:
    check_codec(framing_reader(MODBUS_RTU, baud), MESSAGES, character_ns=character_ns(1, baud))
