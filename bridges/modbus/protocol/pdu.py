"""Requests of Modbus parsed, and answered, by the flow charts of the application protocol.

A PDU is a function code and its data, without an address, a CRC or TCP's header. What is wrong with a request
is found in the order of the flow charts: the function (exception 01), its quantities and length (03), its
addresses (02). Bits are the numbers 0 and 1, registers 0 to 65535.
"""

import struct
from collections.abc import Callable, Sequence
from enum import Enum, IntEnum
from typing import NamedTuple

PDU_BYTES_MAX = 253
"""Size of a serial line's frame without address and CRC (4.1)."""
ADDRESSES = 65536
"""Number of elements of a table (4.4)."""
READ_BITS_MAX, READ_REGISTERS_MAX = 2000, 125
"""Limits of a read (6.1 to 6.4, 6.17)."""
WRITE_BITS_MAX, WRITE_REGISTERS_MAX = 1968, 123
"""Limits of a write (6.11, 6.12)."""
READ_WRITE_REGISTERS_MAX = 121
"""Limit of what function 23 writes (6.17)."""
ON, OFF = 0xFF00, 0x0000
"""Values of a coil that is written alone (6.5)."""
DEVICE_IDENTIFICATION = 14
"""The MEI type, within function 43, that is known here (6.21)."""


class Function(IntEnum):
    """Functions known here (5.1)."""

    READ_COILS = 1
    READ_DISCRETE_INPUTS = 2
    READ_HOLDING_REGISTERS = 3
    READ_INPUT_REGISTERS = 4
    WRITE_SINGLE_COIL = 5
    WRITE_SINGLE_REGISTER = 6
    DIAGNOSTICS = 8
    WRITE_MULTIPLE_COILS = 15
    WRITE_MULTIPLE_REGISTERS = 16
    REPORT_SERVER_ID = 17
    MASK_WRITE_REGISTER = 22
    READ_WRITE_MULTIPLE_REGISTERS = 23
    ENCAPSULATED_INTERFACE_TRANSPORT = 43


class Table(Enum):
    """Tables of a server's data (4.3)."""

    COILS = "coils"
    DISCRETE_INPUTS = "discrete inputs"
    INPUT_REGISTERS = "input registers"
    HOLDING_REGISTERS = "holding registers"


class Code(IntEnum):
    """Exception codes (7). ``NEGATIVE_ACKNOWLEDGE`` is of older editions; function 8 still counts it."""

    ILLEGAL_FUNCTION = 1
    ILLEGAL_DATA_ADDRESS = 2
    ILLEGAL_DATA_VALUE = 3
    SERVER_DEVICE_FAILURE = 4
    ACKNOWLEDGE = 5
    SERVER_DEVICE_BUSY = 6
    NEGATIVE_ACKNOWLEDGE = 7
    MEMORY_PARITY_ERROR = 8
    GATEWAY_PATH_UNAVAILABLE = 10
    GATEWAY_TARGET_FAILED = 11


def exception_words(code: int) -> str:
    """Name of an exception code, in words."""
    return Code(code).name.lower().replace("_", " ") if code in frozenset(Code) else "unknown"


class Refused(Exception):
    """Exception answer to a request: ``code`` is sent, one of ``Code`` or a drive's own; ``str(error)`` says
    why in words."""

    def __init__(self, code: int, why: str) -> None:
        super().__init__(why)
        self.code = code


class Span(NamedTuple):
    """Neighbours in a table."""

    table: Table
    address: int
    count: int  # type: ignore[assignment]  # the protocol's word; a tuple's own method is not missed


class Write(NamedTuple):
    """Values for neighbours in a table."""

    table: Table
    address: int
    values: tuple[int, ...]


class Mask(NamedTuple):
    """Change of some bits of a holding register (6.16)."""

    address: int
    and_mask: int
    or_mask: int

    def applied(self, value: int) -> int:
        """New value of a register that has this one."""
        return value & self.and_mask | self.or_mask & ~self.and_mask


class Request(NamedTuple):
    """Request of a client: of each function what it has. A tuple, because one is made for each request.

    Function 23 has both ``write``, which comes first, and ``read``.
    """

    function: int
    read: Span | None = None
    write: Write | None = None
    mask: Mask | None = None
    sub_function: int | None = None
    """Of function 8."""
    data: bytes = b""
    """Of function 8, behind the sub-function."""
    read_device_id_code: int | None = None
    """Of function 43/14: 1 to 4."""
    object_id: int | None = None
    """Of function 43/14."""


_Parser = Callable[[bytes], Request]
_HEAD = struct.Struct(">BHH")
_MULTIPLE = struct.Struct(">BHHB")
_MASK = struct.Struct(">BHHH")
_READ_WRITE = struct.Struct(">BHHHHB")


WRITES = {
    Function.WRITE_SINGLE_COIL,
    Function.WRITE_SINGLE_REGISTER,
    Function.WRITE_MULTIPLE_COILS,
    Function.WRITE_MULTIPLE_REGISTERS,
    Function.MASK_WRITE_REGISTER,
    Function.READ_WRITE_MULTIPLE_REGISTERS,
}


def is_write(pdu: bytes) -> bool:
    """True if a request is one of a function that writes."""
    return pdu[0] in WRITES


def parse(pdu: bytes, *, is_serial_line: bool = False) -> Request:
    """Parse a request. Functions 8 and 17 are known on a serial line alone (5.1).

    Raises:
        Refused: the function is not known (01), a quantity or the length is wrong (03), or addresses end
            beyond the table (02).
    """
    parser = _PARSERS.get(pdu[0]) if pdu else None
    if parser is None and is_serial_line and pdu:
        parser = _SERIAL_PARSERS.get(pdu[0])
    if parser is None:
        raise Refused(Code.ILLEGAL_FUNCTION, f"function {pdu[0]} is not known" if pdu else "an empty PDU")
    return parser(pdu)


def answer(request: Request, values: Sequence[int] = ()) -> bytes:
    """Make the answer to a request of functions 1 to 6, 15, 16, 22 and 23. ``values``: what was read.

    Raises:
        ValueError: other values than were asked for, or another function.
    """
    if (span := request.read) is not None:
        if len(values) != span.count:
            raise ValueError(f"{len(values)} values; {span.count} were asked for")
        if request.function in _READS_OF_BITS:
            packed = pack_bits(values)
            return bytes((request.function, len(packed))) + packed
        return pack_registers(struct.pack("BB", request.function, 2 * span.count), values)
    if (write := request.write) is not None:
        said = len(write.values)
        if request.function == Function.WRITE_SINGLE_REGISTER:
            said = write.values[0]
        elif request.function == Function.WRITE_SINGLE_COIL:
            said = ON if write.values[0] else OFF
        return _HEAD.pack(request.function, write.address, said)
    if (mask := request.mask) is not None:
        return _MASK.pack(request.function, *mask)
    raise ValueError(f"function {request.function} has no answer here")


def exception(function: int, code: int) -> bytes:
    """Make an exception answer (7)."""
    return bytes((function | 0x80, code))


def pack_bits(values: Sequence[int]) -> bytes:
    """Pack bits, eight to a byte, the first one lowest; those that fill the last byte are 0 (6.1).

    Raises:
        ValueError: a value that is neither 0 nor 1.
    """
    if not values:
        return b""
    digits = bytes(values)[::-1].translate(_DIGITS)
    return int(digits, 2).to_bytes((len(values) + 7) // 8, "little")


def unpack_bits(data: bytes, count: int) -> tuple[int, ...]:
    """Unpack the first bits of ``data``; the rest is not looked at."""
    digits = f"{int.from_bytes(data, 'little'):0{8 * len(data)}b}"
    return tuple(digits.encode().translate(_BITS)[: -count - 1 : -1])


def pack_registers(head: bytes, values: Sequence[int]) -> bytes:
    """Pack registers, the high byte first (4.2), behind ``head``.

    Raises:
        ValueError: a value that is none of a register.
    """
    try:
        return head + struct.pack(f">{len(values)}H", *values)
    except struct.error as error:
        raise ValueError(f"registers are 0 to 65535: {error}") from None


def unpack_registers(data: bytes) -> tuple[int, ...]:
    """Unpack registers from an even number of bytes."""
    return struct.unpack(f">{len(data) // 2}H", data)


# Bit i of a table for ``translate`` is digit i of its text; what is neither 0 nor 1 becomes no digit.
_DIGITS = b"01" + b"x" * 254
_BITS = bytes(byte & 1 for byte in range(256))
_READS_OF_BITS = frozenset((Function.READ_COILS, Function.READ_DISCRETE_INPUTS))


def _wrong_length(pdu: bytes, wanted: int) -> Refused:
    return Refused(Code.ILLEGAL_DATA_VALUE, f"function {pdu[0]} with {len(pdu)} bytes; it has {wanted}")


def _check_count(count: int, most: int) -> None:
    if not 1 <= count <= most:
        raise Refused(Code.ILLEGAL_DATA_VALUE, f"{count} of them; 1 to {most} may be asked for")


def _check_addresses(address: int, count: int) -> None:
    if address + count > ADDRESSES:
        raise Refused(Code.ILLEGAL_DATA_ADDRESS, f"{count} from {address} on end beyond {ADDRESSES - 1}")


def _check_bytes(pdu: bytes, head_bytes: int, wanted: int) -> None:
    """Check the byte count, which ends the head, and the length. ``wanted``: bytes of the values."""
    if pdu[head_bytes - 1] != wanted:
        why = f"a byte count of {pdu[head_bytes - 1]}; the values have {wanted}"
        raise Refused(Code.ILLEGAL_DATA_VALUE, why)
    if len(pdu) != head_bytes + wanted:
        raise _wrong_length(pdu, head_bytes + wanted)


def _read(table: Table, most: int) -> _Parser:
    def parse_read(pdu: bytes) -> Request:
        if len(pdu) != _HEAD.size:
            raise _wrong_length(pdu, _HEAD.size)
        function, address, count = _HEAD.unpack(pdu)
        _check_count(count, most)
        _check_addresses(address, count)
        return Request(function, Span(table, address, count))

    return parse_read


def _parse_single_coil(pdu: bytes) -> Request:
    if len(pdu) != _HEAD.size:
        raise _wrong_length(pdu, _HEAD.size)
    function, address, value = _HEAD.unpack(pdu)
    if value not in (ON, OFF):
        raise Refused(Code.ILLEGAL_DATA_VALUE, f"a coil is 0x0000 or 0xFF00, not 0x{value:04X}")
    return Request(function, write=Write(Table.COILS, address, (int(value == ON),)))


def _parse_single_register(pdu: bytes) -> Request:
    if len(pdu) != _HEAD.size:
        raise _wrong_length(pdu, _HEAD.size)
    function, address, value = _HEAD.unpack(pdu)
    return Request(function, write=Write(Table.HOLDING_REGISTERS, address, (value,)))


def _parse_coils(pdu: bytes) -> Request:
    if len(pdu) < _MULTIPLE.size:
        raise _wrong_length(pdu, _MULTIPLE.size)
    function, address, count, _ = _MULTIPLE.unpack_from(pdu)
    _check_count(count, WRITE_BITS_MAX)
    _check_bytes(pdu, _MULTIPLE.size, (count + 7) // 8)
    _check_addresses(address, count)
    values = unpack_bits(pdu[_MULTIPLE.size :], count)
    return Request(function, write=Write(Table.COILS, address, values))


def _parse_registers(pdu: bytes) -> Request:
    if len(pdu) < _MULTIPLE.size:
        raise _wrong_length(pdu, _MULTIPLE.size)
    function, address, count, _ = _MULTIPLE.unpack_from(pdu)
    _check_count(count, WRITE_REGISTERS_MAX)
    _check_bytes(pdu, _MULTIPLE.size, 2 * count)
    _check_addresses(address, count)
    values = unpack_registers(pdu[_MULTIPLE.size :])
    return Request(function, write=Write(Table.HOLDING_REGISTERS, address, values))


def _parse_mask(pdu: bytes) -> Request:
    if len(pdu) != _MASK.size:
        raise _wrong_length(pdu, _MASK.size)
    function, *mask = _MASK.unpack(pdu)
    return Request(function, mask=Mask(*mask))


def _parse_read_write(pdu: bytes) -> Request:
    if len(pdu) < _READ_WRITE.size:
        raise _wrong_length(pdu, _READ_WRITE.size)
    function, address, count, write_address, write_count, _ = _READ_WRITE.unpack_from(pdu)
    _check_count(count, READ_REGISTERS_MAX)
    _check_count(write_count, READ_WRITE_REGISTERS_MAX)
    _check_bytes(pdu, _READ_WRITE.size, 2 * write_count)
    _check_addresses(address, count)
    _check_addresses(write_address, write_count)
    table = Table.HOLDING_REGISTERS
    values = unpack_registers(pdu[_READ_WRITE.size :])
    return Request(function, Span(table, address, count), Write(table, write_address, values))


def _parse_device_identification(pdu: bytes) -> Request:
    if len(pdu) > 1 and pdu[1] != DEVICE_IDENTIFICATION:
        raise Refused(Code.ILLEGAL_FUNCTION, f"MEI type {pdu[1]} is not known")
    if len(pdu) != 4:
        raise _wrong_length(pdu, 4)
    function, _, read_device_id_code, object_id = pdu
    if not 1 <= read_device_id_code <= 4:
        raise Refused(Code.ILLEGAL_DATA_VALUE, f"read device ID code {read_device_id_code}; there are 1 to 4")
    return Request(function, read_device_id_code=read_device_id_code, object_id=object_id)


def _parse_diagnostics(pdu: bytes) -> Request:
    """Parse the form; what a sub-function's data may be is known where it is answered."""
    if len(pdu) < 3 or len(pdu) > PDU_BYTES_MAX:
        raise _wrong_length(pdu, 5)
    return Request(pdu[0], sub_function=pdu[1] << 8 | pdu[2], data=pdu[3:])


def _parse_report(pdu: bytes) -> Request:
    if len(pdu) != 1:
        raise _wrong_length(pdu, 1)
    return Request(pdu[0])


_PARSERS: dict[int, _Parser] = {
    Function.READ_COILS: _read(Table.COILS, READ_BITS_MAX),
    Function.READ_DISCRETE_INPUTS: _read(Table.DISCRETE_INPUTS, READ_BITS_MAX),
    Function.READ_HOLDING_REGISTERS: _read(Table.HOLDING_REGISTERS, READ_REGISTERS_MAX),
    Function.READ_INPUT_REGISTERS: _read(Table.INPUT_REGISTERS, READ_REGISTERS_MAX),
    Function.WRITE_SINGLE_COIL: _parse_single_coil,
    Function.WRITE_SINGLE_REGISTER: _parse_single_register,
    Function.WRITE_MULTIPLE_COILS: _parse_coils,
    Function.WRITE_MULTIPLE_REGISTERS: _parse_registers,
    Function.MASK_WRITE_REGISTER: _parse_mask,
    Function.READ_WRITE_MULTIPLE_REGISTERS: _parse_read_write,
    Function.ENCAPSULATED_INTERFACE_TRANSPORT: _parse_device_identification,
}
_SERIAL_PARSERS: dict[int, _Parser] = {
    Function.DIAGNOSTICS: _parse_diagnostics,
    Function.REPORT_SERVER_ID: _parse_report,
}
