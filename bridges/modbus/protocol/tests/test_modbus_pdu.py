"""Requests by the flow charts of the application protocol: each limit on both sides, and any bytes at all."""

import os
import random
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bridges.modbus.protocol import client_side
from bridges.modbus.protocol.client_side import AnswerError, encode, parse_answer
from bridges.modbus.protocol.pdu import (
    ADDRESSES,
    Code,
    Function,
    Mask,
    Refused,
    Request,
    Table,
    answer,
    exception,
    parse,
    unpack_bits,
)

BITS = (Table.COILS, Table.DISCRETE_INPUTS)
EXAMPLES = 10_000
FUNCTIONS = st.one_of(st.sampled_from(sorted(Function)), st.integers(0, 255))
HEADS = st.lists(st.sampled_from([0, 1, 2, 4, 5, 123, 125, 126, 2000, 0xFF00, 0xFFFF]), max_size=5)
NEARLY = st.builds(
    lambda function, head, rest: bytes((function,)) + struct.pack(f">{len(head)}H", *head) + rest,
    *(FUNCTIONS, HEADS, st.binary(max_size=260)),
)
REGISTERS = st.integers(0, 0xFFFF)
GOOD = (
    "01 0013 0013",
    "05 00ac ff00",
    "06 0001 0003",
    "08 0000 a537",
    "0f 0013 000a 02 cd01",
    "10 0001 0002 04 000a 0102",
    "11",
    "16 0004 00f2 0025",
    "17 0003 0006 000e 0003 06 00ff 00ff 00ff",
    "2b 0e 01 00",
)
"""Requests to be damaged."""


def refusal(pdu: bytes, *, is_serial_line: bool = False) -> Code | None:
    try:
        parse(pdu, is_serial_line=is_serial_line)
    except Refused as refused:
        return refused.code
    return None


def of_some(table: Table, count: int) -> st.SearchStrategy[tuple[int, ...]]:
    one = st.integers(0, 1) if table in BITS else REGISTERS
    return st.lists(one, min_size=count, max_size=count).map(tuple)


@st.composite
def requests(draw: st.DrawFn) -> Request:
    """Requests within the limits, of the functions that read and write."""
    table = draw(st.sampled_from(Table))
    count = draw(st.integers(1, 2000 if table in BITS else 125))
    address = draw(st.integers(0, ADDRESSES - count))
    writable = draw(st.sampled_from([Table.COILS, Table.HOLDING_REGISTERS]))
    written = draw(st.integers(1, 1968 if writable is Table.COILS else 121))
    start = draw(st.integers(0, ADDRESSES - written))
    values = draw(of_some(writable, written))
    made = [
        client_side.read(table, address, count),
        client_side.write_single(writable, start, values[0]),
        client_side.write(writable, start, values),
        client_side.mask_write(start, draw(REGISTERS), draw(REGISTERS)),
    ]
    if table is writable is Table.HOLDING_REGISTERS:
        made.append(client_side.read_write(address, count, start, values))
    return draw(st.sampled_from(made))


@pytest.mark.long
@given(requests(), st.data())
def test_requests_and_answers_go_both_ways(request: Request, data: st.DataObject) -> None:
    assert parse(encode(request)) == request
    values = data.draw(of_some(request.read.table, request.read.count)) if request.read else ()
    reply = answer(request, values)
    assert len(reply) <= 253
    assert parse_answer(request, reply).values == values
    assert reply[0] == request.function
    with pytest.raises(Refused) as refused:
        parse_answer(request, exception(request.function, Code.SERVER_DEVICE_BUSY))
    assert refused.value.code == Code.SERVER_DEVICE_BUSY


@pytest.mark.parametrize(
    ("function", "most"), [(1, 2000), (2, 2000), (3, 125), (4, 125)], ids=["coils", "inputs", "3", "4"]
)
def test_limits_of_a_read(function: int, most: int) -> None:
    for address, count, code in [
        (0, 0, 3),
        (0, 1, None),
        (0, most, None),
        (0, most + 1, 3),
        (0, 0xFFFF, 3),
        (ADDRESSES - most, most, None),
        (ADDRESSES - most + 1, most, 2),
        (0xFFFF, 1, None),
        (0xFFFF, 2, 2),
        (0xFFFF, most + 1, 3),  # both are wrong: the count is looked at first
    ]:
        assert refusal(struct.pack(">BHH", function, address, count)) == code, (address, count)


@pytest.mark.parametrize(("function", "most", "bits"), [(15, 1968, 1), (16, 123, 16)])
def test_limits_of_a_write(function: int, most: int, bits: int) -> None:
    def refused(address: int, count: int, said: int | None = None, sent: int | None = None) -> Code | None:
        size = (count * bits + 7) // 8
        said, sent = size if said is None else said, size if sent is None else sent
        return refusal(struct.pack(">BHHB", function, address, count, said & 0xFF) + bytes(sent))

    assert refused(0, 0) == 3
    assert refused(0, 1) is None
    assert refused(0, most) is None
    assert refused(0, most + 1) == 3
    assert refused(ADDRESSES - most, most) is None
    assert refused(ADDRESSES - most + 1, most) == 2
    assert refused(0, 9, said=1) == 3
    assert refused(0, 9, sent=1) == 3
    assert refused(0, 9, sent=30) == 3
    assert refused(0xFFFF, 9, said=1) == 3


def test_limits_of_reading_and_writing() -> None:
    def refused(address: int, count: int, start: int, written: int, rest: int = 0) -> Code | None:
        head = struct.pack(">BHHHHB", 23, address, count, start, written, 2 * written & 0xFF)
        return refusal(head + bytes(2 * written + rest))

    assert refused(0, 125, 0, 121) is None
    assert refused(0xFFFF, 1, 0xFFFF, 1) is None
    for wrong in [(0, 126, 0, 1), (0, 0, 0, 1), (0, 1, 0, 0), (0, 1, 0, 122), (0, 1, 0, 1, 1)]:
        assert refused(*wrong) == 3
    assert refused(0xFFFF, 2, 0, 1) == refused(0, 1, 0xFFFF, 2) == 2


@pytest.mark.parametrize(
    ("pdu", "code"),
    [
        ("", 1),
        ("00", 1),
        ("07", 1),
        ("81 00", 1),
        ("ff", 1),
        ("2b 0d 00", 1),
        ("2b", 3),
        ("2b 0e 01", 3),
        ("2b 0e 00 00", 3),
        ("2b 0e 05 00", 3),
        ("2b 0e 04 00 00", 3),
        ("2b 0e 04 ff", None),
        ("01 0000 00", 3),
        ("03 0000 0001 00", 3),
        ("05 0000 0000", None),
        ("05 0000 ff01", 3),
        ("05 0000 0100", 3),
        ("05 ffff ff00", None),
        ("06 ffff ffff", None),
        ("06 0000 00", 3),
        ("0f 0000 0001", 3),
        ("10 0000 0001", 3),
        ("16 0000 0000 00", 3),
        ("16 ffff 0000 0000", None),
        ("17 0000 0001 0000 0001", 3),
    ],
)
def test_what_is_wrong_with_a_request(pdu: str, code: int | None) -> None:
    assert refusal(bytes.fromhex(pdu)) == code


@pytest.mark.parametrize(
    ("pdu", "code"),
    [("08 0000 1234", None), ("08 00", 3), ("08 0000" + "00" * 251, 3), ("11", None), ("11 00", 3)],
)
def test_functions_of_a_serial_line_are_unknown_elsewhere(pdu: str, code: int | None) -> None:
    raw = bytes.fromhex(pdu)
    assert refusal(raw) == Code.ILLEGAL_FUNCTION
    assert refusal(raw, is_serial_line=True) == code


def test_a_refusal_says_why() -> None:
    for pdu, why in [
        ("2c", "function 44 is not known"),
        ("03 0000 007e", "126 of them; 1 to 125 may be asked for"),
        ("03 ffff 0002", "2 from 65535 on end beyond 65535"),
        ("05 0000 0001", "a coil is 0x0000 or 0xFF00, not 0x0001"),
        ("10 0000 0001 03 0000", "a byte count of 3; the values have 2"),
        ("06 00", "function 6 with 2 bytes; it has 5"),
    ]:
        with pytest.raises(Refused) as refused:
            parse(bytes.fromhex(pdu))
        assert str(refused.value) == why


@pytest.mark.thorough
@pytest.mark.long
@settings(max_examples=EXAMPLES, deadline=None)
@given(st.one_of(st.binary(max_size=300), NEARLY), st.booleans())
def test_any_bytes_are_a_request_or_refused(pdu: bytes, is_serial_line: bool) -> None:
    look_at(pdu, is_serial_line)


def test_fuzz_any_bytes_are_a_request_or_refused() -> None:
    """Requests with some bytes changed: ``HIL_FUZZ`` of them."""
    chance = random.Random(int(os.environ.get("HIL_FUZZ_SEED", "1")))
    seeds = [bytes.fromhex(pdu) for pdu in GOOD]
    for _ in range(int(os.environ.get("HIL_FUZZ", "10000"))):
        pdu = bytearray(chance.choice(seeds))
        for _ in range(chance.randrange(4)):
            at = chance.randrange(len(pdu))
            pdu[at : at + chance.randrange(3)] = chance.randbytes(chance.randrange(3))
            pdu = pdu or bytearray(1)
        look_at(bytes(pdu), chance.random() < 0.5)


def look_at(pdu: bytes, is_serial_line: bool) -> None:
    """Check that a PDU is refused with a code of the flow charts, or is a request that says what it says."""
    code = refusal(pdu, is_serial_line=is_serial_line)
    assert code in (None, 1, 2, 3)
    if code is None:
        request = parse(pdu, is_serial_line=is_serial_line)
        if request.function != Function.WRITE_MULTIPLE_COILS:  # bits that fill the last byte may be anything
            assert encode(request) == pdu
        if request.read or request.write or request.mask:
            assert 2 <= len(answer(request, (0,) * (request.read.count if request.read else 0))) <= 253


@given(REGISTERS, REGISTERS, REGISTERS)
def test_a_mask_keeps_or_sets_each_bit(value: int, and_mask: int, or_mask: int) -> None:
    changed = Mask(0, and_mask, or_mask).applied(value)
    for place in range(16):
        source = value if and_mask >> place & 1 else or_mask
        assert changed >> place & 1 == source >> place & 1


@given(st.binary(max_size=250), st.data())
def test_bits_are_unpacked_lowest_first(packed: bytes, data: st.DataObject) -> None:
    count = data.draw(st.integers(0, 8 * len(packed)))
    assert unpack_bits(packed, count) == tuple(packed[at // 8] >> at % 8 & 1 for at in range(count))


def test_an_answer_has_the_values_that_were_asked_for() -> None:
    coils, registers = client_side.read(Table.COILS, 0, 2), client_side.read(Table.HOLDING_REGISTERS, 0, 2)
    for request, values, why in [
        (coils, (1,), "1 values; 2 were asked for"),
        (coils, (1, 2), "invalid literal"),
        (registers, (1, 65536), "registers are 0 to 65535"),
        (client_side.ask_report(), (), "function 17 has no answer here"),
    ]:
        with pytest.raises(ValueError, match=why):
            answer(request, values)


def test_a_client_makes_no_request_that_cannot_be() -> None:
    for request in (
        client_side.read(Table.COILS, 0, 2001),
        client_side.read(Table.COILS, 65535, 2),
        client_side.read(Table.COILS, -1, 2),
        client_side.write(Table.HOLDING_REGISTERS, 0, [0] * 200),
        client_side.write(Table.HOLDING_REGISTERS, 0, [-1]),
        client_side.write(Table.COILS, 0, []),
        client_side.write_single(Table.HOLDING_REGISTERS, 0, 65536),
        client_side.ask_identification(5, 0),  # type: ignore[arg-type]
        client_side.diagnose(0, bytes(260)),
    ):
        with pytest.raises(ValueError, match=r"."):
            encode(request)


@pytest.mark.parametrize(
    "reply", ["", "03", "03 04 0000 00", "03 02 0000", "04 04 0000 0000", "83", "83 02 00", "83 63"]
)
def test_what_is_no_answer_is_said(reply: str) -> None:
    with pytest.raises(AnswerError):
        parse_answer(client_side.read(Table.HOLDING_REGISTERS, 0, 2), bytes.fromhex(reply))


@pytest.mark.long
@given(st.one_of(st.binary(max_size=260), NEARLY), requests())
def test_any_bytes_are_an_answer_or_none(reply: bytes, request: Request) -> None:
    for one in (
        request,
        client_side.ask_report(),
        client_side.diagnose(11),
        client_side.ask_identification(),
    ):
        try:
            parse_answer(one, reply)
        except (AnswerError, Refused) as error:
            assert str(error)  # noqa: PT017
