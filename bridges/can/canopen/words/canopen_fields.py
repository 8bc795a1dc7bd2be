"""Fields of CANopen frames, with their bytes. Bytes are those of the data, behind the identifier.

Source: CiA 301, 7.2; CiA 305, chapter 6.
"""

from collections.abc import Iterable, Iterator, Sequence

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import ABORTS
from bridges.can.canopen.canopen_codes import ERROR_REGISTER, NMT_COMMANDS, NMT_STATES, emergency_words
from bridges.can.canopen.sdo_frames import FRAME_BYTES, SdoAnswer, SdoRequest
from bridges.can.canopen.words.object_words import ObjectWords
from bridges.can.canopen.words.pdo_words import MappedObject
from hil.vocab.packet_field import Fields, PacketField
from hil.wire.packet_fields import bytes_field

_TOGGLED, _STATE = 0x80, 0x7F


def identifier_fields(text: str, parts: Sequence[tuple[str, str]] = ()) -> list[PacketField]:
    """Identifier of a frame, which is none of its bytes, with what it says."""
    return [PacketField("identifier", text), *(PacketField(name, said, level=1) for name, said in parts)]


def nmt_fields(data: bytes) -> Fields:
    if len(data) != 2:
        return bytes_field(data)
    command = NMT_COMMANDS.get(data[0], f"unknown command {data[0]}")
    return (
        PacketField("command", command, 0, 1),
        PacketField("node", str(data[1]) if data[1] else "all", 1, 2),
    )


def state_fields(data: bytes) -> Fields:
    """Fields of error control: boot-up, heartbeat and guarding."""
    if len(data) != 1:
        return bytes_field(data)
    state = "boot-up" if data[0] == 0 else NMT_STATES.get(data[0] & _STATE, "unknown state")
    toggled = [PacketField("toggle", "1", 0, 1, 1)] if data[0] & _TOGGLED else []
    return [PacketField("state", state, 0, 1), *toggled]


def emergency_fields(data: bytes) -> Fields:
    if len(data) != 8:
        return bytes_field(data)
    code, register = int.from_bytes(data[:2], "little"), data[2]
    bits = [name for bit, name in enumerate(ERROR_REGISTER) if register >> bit & 1]
    return (
        PacketField("error code", f"{code:04X}h {emergency_words(code)}", 0, 2),
        PacketField("error register", f"{register:02X}h {', '.join(bits)}".rstrip(), 2, 3),
        PacketField("manufacturer's own", data[3:].hex(" "), 3, 8),
    )


def sync_fields(data: bytes) -> Fields:
    return (PacketField("counter", str(data[0]), 0, 1),) if len(data) == 1 else bytes_field(data)


def time_fields(data: bytes) -> Fields:
    if len(data) != 6:
        return bytes_field(data)
    of_day_ms = int.from_bytes(data[:4], "little") & 0x0FFF_FFFF
    return (
        PacketField("time of day", f"{of_day_ms / 1000:.3f} s", 0, 4),
        PacketField("days since 1984", str(int.from_bytes(data[4:], "little")), 4, 6),
    )


def command_fields(data: bytes) -> Fields:
    """Fields of LSS: a command and its data."""
    if len(data) != 8:
        return bytes_field(data)
    return (PacketField("command", f"{data[0]:02X}h", 0, 1), PacketField("data", data[1:].hex(" "), 1, 8))


def sdo_fields(data: bytes, objects: ObjectWords, *, is_request: bool, is_block_segment: bool) -> Fields:
    """Fields of a frame of an SDO. ``is_block_segment``: it is one of a block under way."""
    if len(data) != FRAME_BYTES:
        return bytes_field(data)
    if is_block_segment and data[0] != sdo_frames.ABORT_BYTE:
        number, is_last = sdo_frames.block_segment_number(data)
        head = f"segment {number} of a block{', the last' if is_last else ''}"
        return PacketField("command", head, 0, 1), PacketField("part", data[1:].hex(" "), 1, 8)
    return tuple(_sdo(data, objects, is_request))


def _sdo(data: bytes, objects: ObjectWords, is_request: bool) -> Iterator[PacketField]:
    kind = sdo_frames.specifier(data)
    names = SdoRequest if is_request else SdoAnswer
    name = names(kind).name.lower().replace("_", " ") if kind in set(names) else f"unknown {kind}"
    if data[0] == sdo_frames.ABORT_BYTE:
        name = "abort"
    segments = {SdoRequest.DOWNLOAD_SEGMENT} if is_request else {SdoAnswer.UPLOAD_SEGMENT}
    if kind in segments:
        part, last = sdo_frames.part_of(data), ", the last" if sdo_frames.is_last(data) else ""
        yield PacketField("command", f"{name}{last}, toggle {sdo_frames.toggle_of(data) >> 4}", 0, 1)
        yield PacketField("part", part.hex(" "), 1, 1 + len(part))
        return
    begins = {SdoRequest.DOWNLOAD} if is_request else {SdoAnswer.UPLOAD}
    has_value = kind in begins and sdo_frames.is_expedited(data)
    yield PacketField("command", f"{name}{', with its value' if has_value else ''}", 0, 1)
    if kind in ({SdoRequest.UPLOAD_SEGMENT} if is_request else {SdoAnswer.DOWNLOAD_SEGMENT}):
        return
    index, subindex = sdo_frames.object_of(data)
    yield PacketField("index", f"{index:04X}h", 1, 3)
    yield PacketField("sub-index", str(subindex), 3, 4)
    yield PacketField("object", objects.name(index, subindex), 1, 4, 1)
    if data[0] == sdo_frames.ABORT_BYTE:
        code = sdo_frames.abort_code(data)
        yield PacketField("reason", f"{code:08X}h {ABORTS.get(code, 'an unknown code')}", 4, 8)
    elif has_value:
        value = sdo_frames.expedited(data)
        yield PacketField("value", objects.value(index, subindex, value), 4, 4 + len(value))
    elif kind in begins and (size := sdo_frames.size_told(data)) is not None:
        yield PacketField("size", f"{size} bytes in segments", 4, 8)


def pdo_fields(data: bytes, mapped: Iterable[MappedObject], objects: ObjectWords) -> Fields:
    """Fields of a PDO: the objects that are mapped."""
    fields: list[PacketField] = []
    number, at = int.from_bytes(data, "little"), 0
    for part in mapped:
        if at + part.bits > 8 * len(data):
            break
        value = (number >> at & (1 << part.bits) - 1).to_bytes((part.bits + 7) // 8, "little")
        begin, at = at, at + part.bits
        if part.object_index >= 0x20:  # below are types, which fill a gap
            name = objects.name(part.object_index, part.subindex)
            text = objects.value(part.object_index, part.subindex, value)
            fields.append(PacketField(name, text, begin // 8, (at + 7) // 8))
    return fields or bytes_field(data)
