"""The same messages from another hand: pymodbus's classes read what is made here, and the other way round."""

from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymodbus.framer import FramerRTU, FramerSocket
from pymodbus.pdu import DecodePDU, ModbusPDU, bit_message, diag_message, mei_message, register_message

from bridges.modbus.protocol import client_side, frame, mbap
from bridges.modbus.protocol.client_side import encode, parse_answer
from bridges.modbus.protocol.diagnostics import Diagnostics, SubFunction
from bridges.modbus.protocol.identification import Identification, ReadDeviceId, identify
from bridges.modbus.protocol.pdu import Code, Request, Table, answer, exception, parse

SERVER, CLIENT = DecodePDU(is_server=True), DecodePDU(is_server=False)
WORDS = st.integers(0, 0xFFFF)
READS: list[tuple[Table, type[ModbusPDU], type[ModbusPDU], int]] = [
    (Table.COILS, bit_message.ReadCoilsRequest, bit_message.ReadCoilsResponse, 2000),
    (
        Table.DISCRETE_INPUTS,
        bit_message.ReadDiscreteInputsRequest,
        bit_message.ReadDiscreteInputsResponse,
        2000,
    ),
    (
        Table.HOLDING_REGISTERS,
        register_message.ReadHoldingRegistersRequest,
        register_message.ReadHoldingRegistersResponse,
        125,
    ),
    (
        Table.INPUT_REGISTERS,
        register_message.ReadInputRegistersRequest,
        register_message.ReadInputRegistersResponse,
        125,
    ),
]


def pdu_of(message: ModbusPDU) -> bytes:
    """PDU that pymodbus makes of a message."""
    return bytes((message.function_code,)) + message.encode()


def read_by(decoder: DecodePDU, pdu: bytes) -> Any:
    message = decoder.decode(pdu)
    assert message is not None
    return message


def both_ways(request: Request, theirs: ModbusPDU, *names: str) -> None:
    """Check that a request is the same bytes for both, and that each reads the other's."""
    assert encode(request) == pdu_of(theirs)
    assert parse(pdu_of(theirs), is_serial_line=True) == request
    message = read_by(SERVER, encode(request))
    assert type(message) is type(theirs)
    for name in names:
        assert getattr(message, name) == getattr(theirs, name)


def bools(values: Sequence[int], size: int | None = None) -> list[bool]:
    """Values as pymodbus has them, filled up to whole bytes where it does not know how many there are."""
    size = -(-len(values) // 8) * 8 if size is None else size
    return [bool(value) for value in values] + [False] * (size - len(values))


@pytest.mark.long
@pytest.mark.parametrize(("table", "ask", "reply", "most"), READS, ids=[each[0].value for each in READS])
@given(data=st.data())
def test_reads(
    table: Table, ask: type[ModbusPDU], reply: type[ModbusPDU], most: int, data: st.DataObject
) -> None:
    count = data.draw(st.integers(1, most))
    address = data.draw(st.integers(0, 65536 - count))
    request = client_side.read(table, address, count)
    both_ways(request, ask(address=address, count=count), "address", "count")
    if most == 125:
        values = data.draw(st.lists(WORDS, min_size=count, max_size=count))
        theirs, wanted = pdu_of(reply(registers=values)), values
        got = read_by(CLIENT, answer(request, values)).registers
    else:
        values = data.draw(st.lists(st.integers(0, 1), min_size=count, max_size=count))
        theirs, wanted = pdu_of(reply(bits=bools(values, count))), bools(values)
        got = read_by(CLIENT, answer(request, values)).bits
    assert answer(request, values) == theirs
    assert parse_answer(request, theirs).values == tuple(values)
    assert list(got) == wanted


@given(WORDS, WORDS, st.integers(0, 1))
def test_single_writes(address: int, value: int, bit: int) -> None:
    coil = client_side.write_single(Table.COILS, address, bit)
    register = client_side.write_single(Table.HOLDING_REGISTERS, address, value)
    their_coil = bit_message.WriteSingleCoilRequest(address=address, bits=[bool(bit)])
    their_register = register_message.WriteSingleRegisterRequest(address=address, registers=[value])
    both_ways(coil, their_coil, "address", "bits")
    both_ways(register, their_register, "address", "registers")
    assert answer(coil) == pdu_of(bit_message.WriteSingleCoilResponse(address=address, bits=[bool(bit)]))
    assert answer(register) == pdu_of(
        register_message.WriteSingleRegisterResponse(address=address, registers=[value])
    )


@given(st.integers(0, 65536 - 1968), st.lists(st.integers(0, 1), min_size=1, max_size=1968))
def test_writes_of_coils(address: int, values: list[int]) -> None:
    request = client_side.write(Table.COILS, address, values)
    theirs = bit_message.WriteMultipleCoilsRequest(address=address, bits=bools(values, len(values)))
    both_ways(request, theirs, "address", "count", "bits")
    reply = bit_message.WriteMultipleCoilsResponse(address=address, count=len(values))
    assert answer(request) == pdu_of(reply)


@given(st.integers(0, 65536 - 123), st.lists(WORDS, min_size=1, max_size=123))
def test_writes_of_registers(address: int, values: list[int]) -> None:
    request = client_side.write(Table.HOLDING_REGISTERS, address, values)
    theirs = register_message.WriteMultipleRegistersRequest(address=address, registers=values)
    both_ways(request, theirs, "address", "count", "registers")
    reply = register_message.WriteMultipleRegistersResponse(address=address, count=len(values))
    assert answer(request) == pdu_of(reply)


@given(WORDS, WORDS, WORDS)
def test_masks(address: int, and_mask: int, or_mask: int) -> None:
    request = client_side.mask_write(address, and_mask, or_mask)
    both_ways(
        request,
        register_message.MaskWriteRegisterRequest(address, and_mask, or_mask),
        *("address", "and_mask", "or_mask"),
    )
    assert answer(request) == pdu_of(register_message.MaskWriteRegisterResponse(address, and_mask, or_mask))


@given(
    st.integers(0, 65536 - 125),
    st.lists(WORDS, min_size=1, max_size=125),
    st.integers(0, 65536 - 121),
    st.lists(WORDS, min_size=1, max_size=121),
)
def test_reading_and_writing(address: int, values: list[int], start: int, written: list[int]) -> None:
    request = client_side.read_write(address, len(values), start, written)
    theirs = register_message.ReadWriteMultipleRegistersRequest(address, len(values), start, written)
    both_ways(request, theirs, "read_address", "read_count", "write_address", "write_registers")
    reply = pdu_of(register_message.ReadWriteMultipleRegistersResponse(registers=values))
    assert answer(request, values) == reply
    assert parse_answer(request, reply).values == tuple(values)


@pytest.mark.parametrize(
    ("sub_function", "theirs"),
    [
        (SubFunction.RETURN_QUERY_DATA, diag_message.ReturnQueryDataRequest),
        (SubFunction.RETURN_DIAGNOSTIC_REGISTER, diag_message.ReturnDiagnosticRegisterRequest),
        (SubFunction.FORCE_LISTEN_ONLY_MODE, diag_message.ForceListenOnlyModeRequest),
        (SubFunction.CLEAR_COUNTERS, diag_message.ClearCountersRequest),
        (SubFunction.BUS_MESSAGES, diag_message.ReturnBusMessageCountRequest),
        (SubFunction.BUS_ERRORS, diag_message.ReturnBusCommunicationErrorCountRequest),
        (SubFunction.EXCEPTIONS, diag_message.ReturnBusExceptionErrorCountRequest),
        (SubFunction.SERVER_MESSAGES, diag_message.ReturnDeviceMessageCountRequest),
        (SubFunction.NO_RESPONSES, diag_message.ReturnDeviceNoResponseCountRequest),
        (SubFunction.NEGATIVE_ACKNOWLEDGES, diag_message.ReturnDeviceNAKCountRequest),
        (SubFunction.BUSY, diag_message.ReturnDeviceBusyCountRequest),
        (SubFunction.OVERRUNS, diag_message.ReturnDeviceBusCharacterOverrunCountRequest),
        (SubFunction.CLEAR_OVERRUNS, diag_message.ClearOverrunCountRequest),
    ],
)
def test_diagnostics(sub_function: SubFunction, theirs: type[ModbusPDU]) -> None:
    request = client_side.diagnose(sub_function)
    message = read_by(SERVER, encode(request))
    assert type(message) is theirs
    assert parse(pdu_of(theirs()), is_serial_line=True).sub_function == sub_function
    reply = Diagnostics().answer(request)
    if reply is not None:
        assert read_by(CLIENT, reply).sub_function_code == sub_function


def test_identification() -> None:
    device = Identification("Acme", "M1", "1.0", product_name="x" * 200, model_name="y" * 50)
    for code, first, numbers in [(1, 0, [0, 1, 2]), (2, 0, [0, 1, 2, 4]), (2, 5, [5]), (4, 5, [5])]:
        request = client_side.ask_identification(ReadDeviceId(code), first)
        theirs = mei_message.ReadDeviceInformationRequest(read_code=code, object_id=first)
        both_ways(request, theirs, "read_code", "object_id")
        reply = read_by(CLIENT, identify(request, device))
        assert reply.information == {number: device.objects[number] for number in numbers}
        assert (reply.conformity, reply.number_of_objects) == (0x82, len(numbers))
        assert (reply.more_follows, reply.next_object_id) == ((0xFF, 5) if 4 in numbers else (0, 0))


def test_exceptions() -> None:
    for code in Code:
        message = read_by(CLIENT, exception(3, code))
        assert message.isError()
        assert message.exception_code == code


@given(st.integers(0, 255), st.binary(min_size=1, max_size=253), WORDS)
def test_packets(node: int, pdu: bytes, transaction: int) -> None:
    assert frame.encode(node, pdu[0], pdu[1:]) == FramerRTU(SERVER).encode(pdu, node, 0)
    packet = mbap.encode(transaction, node, pdu)
    assert packet == FramerSocket(SERVER).encode(pdu, node, transaction)
    if len(pdu) > 1:  # of a function alone theirs says that it has a byte more
        assert FramerSocket(SERVER).decode(packet) == (len(packet), node, transaction, pdu)
