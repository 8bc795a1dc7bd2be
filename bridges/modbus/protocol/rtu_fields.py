"""Fields of frames of Modbus RTU, with their bytes. Source: MODBUS Application Protocol V1.1b3, 6."""

from collections.abc import Iterator

from bridges.modbus.protocol._crc16 import crc16
from bridges.modbus.protocol.frame import TO_ALL
from bridges.modbus.protocol.pdu import Function, Refused, Request, Table, exception_words, parse, unpack_bits
from hil.vocab.packet_field import Fields, PacketField

_EXCEPTION = 0x80
_ONE = {
    Table.COILS: "coil",
    Table.DISCRETE_INPUTS: "discrete input",
    Table.INPUT_REGISTERS: "input register",
    Table.HOLDING_REGISTERS: "holding register",
}
_BITS = (Table.COILS, Table.DISCRETE_INPUTS)


def frame_fields(raw: bytes, asked: bytes) -> Fields:
    """Fields of a frame. ``asked``: the frame that it answers; empty: it is a question."""
    unit, number = raw[0], raw[1] & ~_EXCEPTION
    known = {each.value: each.name.lower().replace("_", " ") for each in Function}
    name = known.get(number, "unknown")
    fields = [
        PacketField("unit", "all" if unit == TO_ALL else str(unit), 0, 1),
        PacketField("function", f"{number} ({name}){', exception' if raw[1] & _EXCEPTION else ''}", 1, 2),
        *_body(raw, asked),
    ]
    end = max([2, *(field.end for field in fields)])
    if end < len(raw) - 2:
        fields.append(PacketField("data", raw[end:-2].hex(" "), end, len(raw) - 2))
    right = crc16(raw[:-2]).to_bytes(2, "little")
    said = "right" if raw[-2:] == right else f"wrong, {right.hex(' ')} would be right"
    return [*fields, PacketField("CRC", f"{raw[-2:].hex(' ')}, {said}", len(raw) - 2, len(raw))]


def _body(raw: bytes, asked: bytes) -> Iterator[PacketField]:
    if raw[1] & _EXCEPTION:
        if len(raw) > 4:
            yield PacketField("exception", f"{raw[2]:02} ({exception_words(raw[2])})", 2, 3)
        return
    try:
        request = parse((asked or raw)[1:-2], is_serial_line=True)
    except Refused as refused:
        if len(raw) > 4:
            yield PacketField("data", f"{raw[2:-2].hex(' ')} ({refused})", 2, len(raw) - 2)
        return
    yield from _answer(raw, request) if asked else _question(raw, request)


def _word(raw: bytes, name: str, at: int) -> PacketField:
    return PacketField(name, str(int.from_bytes(raw[at : at + 2], "big")), at, at + 2)


def _question(raw: bytes, request: Request) -> Iterator[PacketField]:
    if request.sub_function is not None:
        yield _word(raw, "sub-function", 2)
    elif request.read_device_id_code is not None:
        yield PacketField("MEI type", str(raw[2]), 2, 3)
        yield PacketField("category", str(raw[3]), 3, 4)
        yield PacketField("object", str(raw[4]), 4, 5)
    elif request.mask:
        yield _word(raw, "holding register", 2)
        yield PacketField("and", f"{request.mask.and_mask:04x}h", 4, 6)
        yield PacketField("or", f"{request.mask.or_mask:04x}h", 6, 8)
    else:
        yield from _spans(raw, request)


def _spans(raw: bytes, request: Request) -> Iterator[PacketField]:
    at = 2
    if request.read:
        yield _word(raw, f"first {_ONE[request.read.table]}", 2)
        yield _word(raw, "how many", 4)
        at = 6
    if (write := request.write) is None:
        return
    yield _word(raw, f"{'' if _is_single(request) else 'first '}{_ONE[write.table]}", at)
    if _is_single(request):
        yield PacketField("value", str(write.values[0]), at + 2, at + 4)
        return
    yield _word(raw, "how many", at + 2)
    yield PacketField("bytes of the values", str(raw[at + 4]), at + 4, at + 5)
    yield from _values(raw, write.table, write.address, len(write.values), at + 5)


def _answer(raw: bytes, request: Request) -> Iterator[PacketField]:
    if request.read:
        yield PacketField("bytes of the values", str(raw[2]), 2, 3)
        yield from _values(raw, request.read.table, request.read.address, request.read.count, 3)
    elif request.write and not _is_single(request):
        yield _word(raw, f"first {_ONE[request.write.table]}", 2)
        yield _word(raw, "how many", 4)
    elif request.write or request.mask or request.sub_function is not None:
        yield from _question(raw, request)
    elif request.function == Function.REPORT_SERVER_ID:
        yield PacketField("bytes of the server ID", str(raw[2]), 2, 3)
        yield PacketField("server ID", repr(raw[3:-2])[1:], 3, len(raw) - 2)


def _values(raw: bytes, table: Table, first: int, count: int, at: int) -> Iterator[PacketField]:
    end = len(raw) - 2
    if table in _BITS:
        bits = unpack_bits(raw[at:end], min(count, 8 * (end - at)))
        for place, bit in enumerate(bits):
            byte = at + place // 8
            yield PacketField(f"{_ONE[table]} {first + place}", str(bit), byte, byte + 1, 1)
        return
    for place in range(min(count, (end - at) // 2)):
        begin = at + 2 * place
        value = int.from_bytes(raw[begin : begin + 2], "big")
        text = f"{value} ({value:04x}h)"
        yield PacketField(f"{_ONE[table]} {first + place}", text, begin, begin + 2, 1)


def _is_single(request: Request) -> bool:
    return request.function in (Function.WRITE_SINGLE_COIL, Function.WRITE_SINGLE_REGISTER)
