"""Client's side: requests encoded, answers parsed."""

import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from bridges.modbus.protocol.identification import IdentificationPiece, ReadDeviceId, parse_identification
from bridges.modbus.protocol.pdu import (
    DEVICE_IDENTIFICATION,
    OFF,
    ON,
    Code,
    Function,
    Mask,
    Refused,
    Request,
    Span,
    Table,
    Write,
    answer,
    exception_words,
    pack_bits,
    pack_registers,
    parse,
    unpack_bits,
    unpack_registers,
)

_READS = {
    Table.COILS: Function.READ_COILS,
    Table.DISCRETE_INPUTS: Function.READ_DISCRETE_INPUTS,
    Table.HOLDING_REGISTERS: Function.READ_HOLDING_REGISTERS,
    Table.INPUT_REGISTERS: Function.READ_INPUT_REGISTERS,
}
_SINGLE_WRITES = {
    Table.COILS: Function.WRITE_SINGLE_COIL,
    Table.HOLDING_REGISTERS: Function.WRITE_SINGLE_REGISTER,
}
_WRITES = {
    Table.COILS: Function.WRITE_MULTIPLE_COILS,
    Table.HOLDING_REGISTERS: Function.WRITE_MULTIPLE_REGISTERS,
}


class AnswerError(Exception):
    """Error of a PDU that is no answer to the request: ``str(error)`` says why."""


class Answer(NamedTuple):
    """An answer that is no exception."""

    values: tuple[int, ...] = ()
    """Values that were read, one for each address."""
    data: bytes = b""
    """Of function 8, behind the sub-function; of function 17, all that is reported."""
    identification: IdentificationPiece | None = None
    """Of function 43/14."""


def read(table: Table, address: int, count: int = 1) -> Request:
    """Make a request of functions 1 to 4."""
    return Request(_READS[table], Span(table, address, count))


def write_single(table: Table, address: int, value: int) -> Request:
    """Make a request of function 5 or 6; the table is one that can be written."""
    return Request(_SINGLE_WRITES[table], write=Write(table, address, (value,)))


def write(table: Table, address: int, values: Sequence[int]) -> Request:
    """Make a request of function 15 or 16; the table is one that can be written."""
    return Request(_WRITES[table], write=Write(table, address, tuple(values)))


def mask_write(address: int, and_mask: int, or_mask: int) -> Request:
    """Make a request of function 22."""
    return Request(Function.MASK_WRITE_REGISTER, mask=Mask(address, and_mask, or_mask))


def read_write(address: int, count: int, write_address: int, values: Sequence[int]) -> Request:
    """Make a request of function 23: it writes first."""
    table = Table.HOLDING_REGISTERS
    span, written = Span(table, address, count), Write(table, write_address, tuple(values))
    return Request(Function.READ_WRITE_MULTIPLE_REGISTERS, span, written)


def diagnose(sub_function: int, data: bytes = b"\0\0") -> Request:
    """Make a request of function 8."""
    return Request(Function.DIAGNOSTICS, sub_function=sub_function, data=data)


def ask_report() -> Request:
    """Make a request of function 17."""
    return Request(Function.REPORT_SERVER_ID)


def ask_identification(code: ReadDeviceId = ReadDeviceId.BASIC, object_id: int = 0) -> Request:
    """Make a request of function 43/14, from an object on or for it alone."""
    function = Function.ENCAPSULATED_INTERFACE_TRANSPORT
    return Request(function, read_device_id_code=code, object_id=object_id)


def encode(request: Request) -> bytes:
    """Encode a request, the counterpart of ``parse``.

    Raises:
        ValueError: a request that a server would refuse by its form alone.
    """
    try:
        pdu = _ENCODERS[request.function](request)
        parse(pdu, is_serial_line=True)
    except (struct.error, Refused) as error:
        raise ValueError(str(error)) from None
    return pdu


def parse_answer(request: Request, pdu: bytes) -> Answer:
    """Parse what came for a request.

    Raises:
        Refused: the server's exception.
        AnswerError: it is no answer to this request.
    """
    if len(pdu) == 2 and pdu[0] == request.function | 0x80:
        if pdu[1] not in _EXCEPTION_CODES:
            raise AnswerError(f"exception {pdu[1]}, which is unknown")
        raise Refused(Code(pdu[1]), f"function {request.function}: {exception_words(pdu[1])}")
    if not pdu or pdu[0] != request.function:
        raise AnswerError(f"no answer of function {request.function}: {pdu.hex(' ')}")
    if request.read is not None:
        return Answer(_parse_values(request.read, pdu))
    if request.write is not None or request.mask is not None:
        if pdu != (wanted := answer(request)):
            raise AnswerError(f"{pdu.hex(' ')}; {wanted.hex(' ')} says that it is written")
        return Answer()
    return _parse_other(request, pdu)


def _parse_values(span: Span, pdu: bytes) -> tuple[int, ...]:
    is_bits = span.table in (Table.COILS, Table.DISCRETE_INPUTS)
    wanted = (span.count + 7) // 8 if is_bits else 2 * span.count
    if len(pdu) != 2 + wanted or pdu[1] != wanted:
        raise AnswerError(f"{len(pdu)} bytes, {2 + wanted} are {span.count} of the {span.table.value}")
    return unpack_bits(pdu[2:], span.count) if is_bits else unpack_registers(pdu[2:])


def _parse_other(request: Request, pdu: bytes) -> Answer:
    if request.sub_function is not None:
        if int.from_bytes(pdu[1:3], "big") != request.sub_function or len(pdu) < 3:
            raise AnswerError(f"no answer of sub-function {request.sub_function}: {pdu.hex(' ')}")
        return Answer(data=pdu[3:])
    if request.read_device_id_code is not None:
        try:
            piece = parse_identification(pdu)
        except ValueError as error:
            raise AnswerError(str(error)) from None
        return Answer(identification=piece)
    if len(pdu) < 2 or len(pdu) != 2 + pdu[1]:
        raise AnswerError(f"a report whose length is wrong: {pdu.hex(' ')}")
    return Answer(data=pdu[2:])


def _encode_read(request: Request) -> bytes:
    assert request.read
    return struct.pack(">BHH", request.function, request.read.address, request.read.count)


def _encode_single(request: Request) -> bytes:
    assert request.write
    value = request.write.values[0]
    if request.write.table is Table.COILS:
        value = ON if value else OFF
    return struct.pack(">BHH", request.function, request.write.address, value)


def _encode_write(request: Request) -> bytes:
    assert request.write
    head = struct.pack(">BHH", request.function, request.write.address, len(request.write.values))
    return head + _packed(request.write)


def _encode_mask(request: Request) -> bytes:
    assert request.mask
    return struct.pack(">BHHH", request.function, *request.mask)


def _encode_read_write(request: Request) -> bytes:
    assert request.read
    assert request.write
    span, written = request.read, request.write
    head = struct.pack(">HHH", span.count, written.address, len(written.values))
    return struct.pack(">BH", request.function, span.address) + head + _packed(written)


def _packed(written: Write) -> bytes:
    """Values behind their byte count."""
    is_bits = written.table is Table.COILS
    packed = pack_bits(written.values) if is_bits else pack_registers(b"", written.values)
    return struct.pack("B", len(packed)) + packed


def _encode_diagnostics(request: Request) -> bytes:
    assert request.sub_function is not None
    return struct.pack(">BH", request.function, request.sub_function) + request.data


def _encode_report(request: Request) -> bytes:
    return bytes((request.function,))


def _encode_identification(request: Request) -> bytes:
    code, first = request.read_device_id_code, request.object_id
    return struct.pack("4B", request.function, DEVICE_IDENTIFICATION, code, first)


_EXCEPTION_CODES = frozenset(Code)
_ENCODERS: dict[int, Callable[[Request], bytes]] = {
    **dict.fromkeys(_READS.values(), _encode_read),
    **dict.fromkeys(_SINGLE_WRITES.values(), _encode_single),
    **dict.fromkeys(_WRITES.values(), _encode_write),
    Function.MASK_WRITE_REGISTER: _encode_mask,
    Function.READ_WRITE_MULTIPLE_REGISTERS: _encode_read_write,
    Function.DIAGNOSTICS: _encode_diagnostics,
    Function.REPORT_SERVER_ID: _encode_report,
    Function.ENCAPSULATED_INTERFACE_TRANSPORT: _encode_identification,
}
