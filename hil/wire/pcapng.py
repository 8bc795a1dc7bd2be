"""Captures as pcapng, which Wireshark and tshark read: serial lines with LINKTYPE_RTAC_SERIAL (250), CAN
buses with LINKTYPE_CAN_SOCKETCAN (227). Pure.

Sources: the pcapng specification (IETF draft-ietf-opsawg-pcapng); Wireshark's dissector of the link type, for
its 12-byte header: seconds and microseconds (big-endian), event, control lines, two bytes of footer. What
the link type says of its payloads is about other protocols; here they are a line's bytes.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from hil.vocab.line_format import EIGHT_N_1, FORMATS, LineFormat

LINKTYPE_RTAC_SERIAL, LINKTYPE_CAN_SOCKETCAN = 250, 227
_SECTION, _INTERFACE, _PACKET = 0x0A0D0D0A, 1, 6
_MAGIC = 0x1A2B3C4D
_OPTION_END, _COMMENT, _IF_NAME, _IF_DESCRIPTION, _USER_APPLICATION = 0, 1, 2, 3, 4
_EPB_FLAGS, _EPB_DROPS, _IF_SPEED, _IF_TSRESOL = 2, 4, 8, 9
_NANOSECONDS = 9
_INBOUND, _OUTBOUND = 1, 2
_BLOCK_MAX = 1 << 24
RAW = "raw"
"""Framing of bytes that are no packets: what passes at a terminal."""


class RecordKind(IntEnum):
    """Kinds of records, as the link type numbers them. TX goes to a board, RX comes from it."""

    TX = 1
    RX = 2
    LOST = 5
    FRAMING_ERROR = 7
    PARITY_ERROR = 8
    BREAK = 9
    OVERFLOW = 10


EVENT_NAMES = {event.value: event.name.lower().replace("_", " ") for event in RecordKind}


@dataclass(frozen=True)
class Interface:
    """Source of records."""

    name: str
    framing: str = ""
    """Name of the framing of its bytes; ``RAW``: they are no packets; "": it is not known."""
    baud: int = 0
    """Speed of the line, in bits per second; 0: it is not known."""
    line_format: LineFormat = EIGHT_N_1
    """Format of its characters; written behind the framing, as in ``modbus_rtu 8E1``, where it is not 8N1."""
    is_can: bool = False
    """True for a CAN bus, whose ``baud`` is its bit rate."""

    @property
    def description(self) -> str:
        return self.framing + ("" if self.line_format is EIGHT_N_1 else f" {self.line_format.name}")


def header(program: str, interfaces: Sequence[Interface]) -> bytes:
    """Encode the beginning of a capture: a section, and its interfaces; their numbers count from 0."""
    section = struct.pack("<IHHq", _MAGIC, 1, 0, -1) + _options((_USER_APPLICATION, program.encode()))
    blocks = [_block(_SECTION, section)]
    for each in interfaces:
        options = [(_IF_NAME, each.name.encode())]
        if each.description:
            options.append((_IF_DESCRIPTION, each.description.encode()))
        if each.baud:
            options.append((_IF_SPEED, struct.pack("<Q", each.baud)))
        options.append((_IF_TSRESOL, bytes((_NANOSECONDS,))))
        link = LINKTYPE_CAN_SOCKETCAN if each.is_can else LINKTYPE_RTAC_SERIAL
        body = struct.pack("<HHI", link, 0, 0) + _options(*options)
        blocks.append(_block(_INTERFACE, body))
    return b"".join(blocks)


def record(
    interface: int, at_ns: int, event: RecordKind, data: bytes = b"", comment: str = "", lost: int = 0
) -> bytes:
    """Encode one event of a serial line. ``at_ns``: nanoseconds since 1970. ``lost``: number of records that
    were lost before it."""
    seconds, rest_ns = divmod(at_ns, 10**9)
    payload = struct.pack(">IIBBH", seconds & 0xFFFFFFFF, rest_ns // 1000, event, 0, 0) + data
    direction = _OUTBOUND if event == RecordKind.TX else _INBOUND
    return _packet(interface, at_ns, payload, comment, lost, (_EPB_FLAGS, struct.pack("<I", direction)))


def can_record(interface: int, at_ns: int, packed: bytes, comment: str = "", lost: int = 0) -> bytes:
    """Encode a frame of a CAN bus, packed by ``hil.wire.can.socketcan``, or nothing, with a comment.
    ``at_ns``: nanoseconds since 1970. ``lost``: number of records that were lost before it."""
    return _packet(interface, at_ns, packed, comment, lost)


def _packet(
    interface: int, at_ns: int, payload: bytes, comment: str, lost: int, *options: tuple[int, bytes]
) -> bytes:
    head = struct.pack(
        "<IIIII", interface, at_ns >> 32 & 0xFFFFFFFF, at_ns & 0xFFFFFFFF, len(payload), len(payload)
    )
    said = [(_EPB_DROPS, struct.pack("<Q", lost))] if lost else []
    said += [(_COMMENT, comment.encode())] if comment else []
    return _block(_PACKET, head + _padded(payload) + _options(*options, *said))


@dataclass(frozen=True)
class Record:
    """One event as read back; ``offset`` is where its block begins in the file. Of a CAN bus ``event`` is 0
    and ``data`` a frame as ``hil.wire.can.socketcan`` packs it."""

    line: Interface
    at_ns: int
    event: int
    data: bytes
    comment: str
    offset: int
    lost: int = 0
    """Number of records that were lost before it."""

    @property
    def interface(self) -> str:
        """Name of the record's interface."""
        return self.line.name


class CaptureBytes(Protocol):
    """Bytes of a capture, in memory or in a file that is mapped."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice, /) -> bytes: ...


class CaptureError(Exception):
    """Error of a file that is no capture of this kind, or ends in the middle: ``str(error)`` says where."""


def read(data: CaptureBytes) -> Iterator[Record]:
    """The records of a capture that ``header`` and ``record`` wrote, or that has the same link type.

    Raises:
        CaptureError: after all whole records, where the file is cut off or not what it should be.
    """
    if not data:
        raise CaptureError("the file is empty")
    if data[:4] != b"\x0a\x0d\x0d\x0a"[: len(data)]:
        raise CaptureError("this is no pcapng file")
    at, order, lines, units = 0, "<", list[Interface](), list[int]()
    while at < len(data):
        if len(data) - at < 12:
            raise CaptureError(cut_off(at))
        if data[at : at + 4] == b"\x0a\x0d\x0d\x0a":
            order = "<" if data[at + 8 : at + 12] == struct.pack("<I", _MAGIC) else ">"
            lines, units = [], []
        kind, size = struct.unpack(f"{order}II", data[at : at + 8])
        if size < 12 or size % 4 or size > _BLOCK_MAX:
            raise CaptureError(f"a block of {size} bytes at byte {at} cannot be")
        if at + size > len(data):
            raise CaptureError(cut_off(at))
        body = data[at + 8 : at + size - 4]
        if kind == _INTERFACE:
            if len(body) < 8:
                raise CaptureError(f"an interface at byte {at} that this does not read")
            (link,) = struct.unpack_from(f"{order}H", body)
            if link not in (LINKTYPE_RTAC_SERIAL, LINKTYPE_CAN_SOCKETCAN):
                known = f"{LINKTYPE_RTAC_SERIAL} and {LINKTYPE_CAN_SOCKETCAN}"
                raise CaptureError(f"link type {link} at byte {at}; this reads {known}")
            options = dict(_read_options(body[8:], order))
            lines.append(_interface(options, order, len(lines), link == LINKTYPE_CAN_SOCKETCAN))
            units.append(int.from_bytes(options.get(_IF_TSRESOL, b"\x06")[:1]))
        elif kind == _PACKET and len(body) >= 20:
            yield _record(body, order, lines, units, at)
        at += size


def cut_off(at: int) -> str:
    """Say of a capture that its last block, which begins at this byte, is not whole."""
    return f"cut off in the middle of a block at byte {at}: what is whole ends there"


def whole_blocks(data: bytes) -> int:
    """Number of bytes at the front that are whole blocks."""
    return max((end for _, _, end in _blocks(data)), default=0)


def split_blocks(data: bytes) -> Iterator[bytes]:
    """Whole blocks, one by one."""
    for _, begin, end in _blocks(data):
        yield data[begin:end]


def header_length(data: bytes) -> int:
    """Number of bytes of whole blocks before the first record, all of them where there is none."""
    return next((at for kind, at, _ in _blocks(data) if kind == _PACKET), whole_blocks(data))


def interfaces_in(header: bytes) -> list[Interface]:
    """Interfaces of a capture, in the order of their numbers. ``header``: as the function of that name writes
    it, whatever follows."""
    found: list[Interface] = []
    for kind, begin, end in _blocks(header):
        if kind == _INTERFACE:
            options = dict(_read_options(header[begin + 16 : end - 4], "<"))
            (link,) = struct.unpack_from("<H", header, begin + 8)
            found.append(_interface(options, "<", len(found), link == LINKTYPE_CAN_SOCKETCAN))
    return found


def _blocks(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Whole blocks that ``_block`` wrote: kind, begin and end."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        if at + size > len(data):
            return
        yield kind, at, at + size
        at += size


def bursts(data: bytes, interface: str | None) -> list[tuple[int, str]]:
    """The bursts of a line, for a tap to play: nanoseconds since the first, and hexadecimal digits.

    Raises:
        CaptureError: it is no capture, it is cut off, or has nothing of that interface.
    """
    records = list(read(data))
    found = [each for each in records if each.event in (RecordKind.TX, RecordKind.RX) and each.data]
    if not found and any(each.line.is_can for each in records):
        raise CaptureError("it has frames of CAN alone; canplayer plays a .log of them at a channel")
    names = list(dict.fromkeys(each.interface for each in found))
    if interface is None and len(names) > 1:
        raise CaptureError(f"it has several lines; choose one with --source: {', '.join(names)}")
    wanted = interface or (names[0] if names else None)
    rows = [each for each in found if each.interface == wanted]
    if not rows:
        known = ", ".join(names) or "nothing"
        raise CaptureError(f"there is nothing of {interface or 'a line'} in it; it has {known}")
    return [(each.at_ns - rows[0].at_ns, each.data.hex()) for each in rows]


def _interface(options: Mapping[int, bytes], order: str, number: int, is_can: bool) -> Interface:
    name, about = (options.get(code, b"").decode("utf-8", "replace") for code in (_IF_NAME, _IF_DESCRIPTION))
    framing, _, line_format = about.partition(" ")
    speed = options.get(_IF_SPEED, b"")
    baud = int.from_bytes(speed, "little" if order == "<" else "big") if len(speed) == 8 else 0
    if is_can:
        return Interface(name or f"can{number}", "", baud, is_can=True)
    return Interface(name or str(number), framing, baud, FORMATS.get(line_format, EIGHT_N_1))


def _record(body: bytes, order: str, lines: list[Interface], units: list[int], at: int) -> Record:
    interface, high, low, captured, _ = struct.unpack_from(f"{order}IIIII", body)
    payload = body[20 : 20 + captured]
    if interface >= len(lines) or units[interface] > _NANOSECONDS:
        raise CaptureError(f"a record at byte {at} that this does not read")
    line = lines[interface]
    if len(payload) < (0 if line.is_can else 12):
        raise CaptureError(f"a record at byte {at} that this does not read")
    options = dict(_read_options(body[20 + captured + -captured % 4 :], order))
    at_ns = (high << 32 | low) * 10 ** (_NANOSECONDS - units[interface])
    comment = options.get(_COMMENT, b"").decode("utf-8", "replace")
    drops = options.get(_EPB_DROPS, b"")
    lost = int.from_bytes(drops, "little" if order == "<" else "big") if len(drops) == 8 else 0
    if line.is_can:
        return Record(line, at_ns, 0, payload, comment, at, lost)
    return Record(line, at_ns, payload[8], payload[12:], comment, at, lost)


def _read_options(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at + 4 <= len(data):
        code, size = struct.unpack_from(f"{order}HH", data, at)
        if code == _OPTION_END:
            return
        yield code, data[at + 4 : at + 4 + size]
        at += 4 + size + -size % 4


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _options(*options: tuple[int, bytes]) -> bytes:
    packed = b"".join(struct.pack("<HH", code, len(value)) + _padded(value) for code, value in options)
    return packed + struct.pack("<HH", _OPTION_END, 0)


def _block(kind: int, body: bytes) -> bytes:
    size = len(body) + 12
    return struct.pack("<II", kind, size) + body + struct.pack("<I", size)
