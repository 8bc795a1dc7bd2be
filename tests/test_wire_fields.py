"""Fields of packets, as a page asks for them."""

from types import SimpleNamespace

import pytest

from bridges.can.cards.bench_bus import FRAMES
from bridges.modbus.protocol.frame import encode
from bridges.modbus.protocol.rtu_framing import MODBUS_RTU
from bridges.web.wire_fields import wire_fields
from hil.vocab.verbs import VerbRefused

LINE = SimpleNamespace(framing=MODBUS_RTU, baud=19200)
HERE = SimpleNamespace(segments={"line": LINE}, buses={"can0": FRAMES})
DESK = SimpleNamespace(describe=lambda: HERE)


def fields(wire, *packets):
    found = wire_fields(DESK, {"wire": wire, "packets": list(packets)})["fields"]
    return {row["name"]: (row["text"], row["begin"], row["end"]) for row in found}


def test_an_answer_is_known_by_its_question():
    question, answer = encode(1, 3, bytes.fromhex("006b0001")), encode(1, 3, bytes.fromhex("02022b"))
    found = fields("line", f"1.5 {question.hex()}", f"1.507 {answer.hex()}")
    assert found["holding register 107"] == ("555 (022bh)", 3, 5)


def test_a_frame_and_bytes_that_are_no_packet():
    assert fields("can0", "705#05")["state"] == ("operational", 0, 1)
    assert fields("line", "1 02") == {"bytes": ("02", 0, 1)}


@pytest.mark.parametrize(
    ("wire", "packets", "why"),
    [
        ("nosuch", ["1 02"], "there is no wire 'nosuch'; there are line, can0"),
        ("can0", ["705"], "packets: '705' is no frame"),
        ("line", ["soon 02"], "write seconds and hexadecimal digits"),
        ("line", ["inf 02"], "write seconds and hexadecimal digits"),
        ("line", [], "packets: write a list of 1 to 256 texts"),
        ("line", ["1 0" * 9999], "packets: write a list"),
    ],
)
def test_what_is_no_packet_is_refused(wire, packets, why):
    with pytest.raises(VerbRefused, match=why):
        fields(wire, *packets)
