"""Captures as pcapng, which Wireshark and tshark read: serial lines with LINKTYPE_RTAC_SERIAL (250), CAN
buses with LINKTYPE_CAN_SOCKETCAN (227), other buses with a link type of theirs or one for users. Pure.

Sources: the pcapng specification (IETF draft-ietf-opsawg-pcapng); Wireshark's dissector of the link type, for
its 12-byte header: seconds and microseconds (big-endian), event, control lines, two bytes of footer. What
the link type says of its payloads is about other protocols; here they are a line's bytes.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple, Protocol

from hil.vocab.line_format import EIGHT_N_1, FORMATS, LineFormat
from hil.wire.outside_text import LeftOut

LINKTYPE_RTAC_SERIAL, LINKTYPE_CAN_SOCKETCAN = 250, 227
LINKTYPES_USER = range(147, 163)
"""Link types that nobody else has, for the frames of buses without one."""
_COOKED = {113: (16, 14), 276: (20, 0)}
"""Linux's cooked captures, of two versions: length of the header, and where in it the protocol stands."""
_COOKED_CAN = (0x0C, 0x0D, 0x0E)
"""Protocols of cooked captures: CAN, CAN FD, CAN XL."""
CAN_LINKS = (LINKTYPE_CAN_SOCKETCAN, *_COOKED)
_SERIAL_HEAD = 12
_ENDS = {3: 1, 4: 2}
"""Events that other programs have for data, too: the end of what was sent and received."""


def unwrapped(link: int, payload: bytes, order: str) -> tuple[bytes, int]:
    """Take the packet of a link type apart: its bytes, and which event of a serial line it is, 0 of buses.
    ``order``: of the file's numbers, ``<`` or ``>``.

    Raises:
        ValueError: it is of something else, or too short.
    """
    if link == LINKTYPE_CAN_SOCKETCAN or link in LINKTYPES_USER:
        return payload, 0
    if link in _COOKED:
        return _uncooked(link, payload, order), 0
    if link != LINKTYPE_RTAC_SERIAL:
        raise ValueError(f"of link type {link}, which is no CAN (227) and no serial line (250)")
    if len(payload) < _SERIAL_HEAD:
        raise ValueError("shorter than the head of a serial line's event")
    event, data = payload[8], payload[_SERIAL_HEAD:]
    return data, _ENDS.get(event, event) if data else event


def _uncooked(link: int, payload: bytes, order: str) -> bytes:
    length, at = _COOKED[link]
    if len(payload) < length + 4:
        raise ValueError("shorter than the head of a cooked capture")
    (protocol,) = struct.unpack_from(">H", payload, at)
    if protocol not in _COOKED_CAN:
        raise ValueError(f"of protocol {protocol:04X}h, which is no CAN")
    (word,) = struct.unpack_from(f"{order}I", payload, length)
    return struct.pack(">I", word) + payload[length + 4 :]


_SECTION, _INTERFACE, _PACKET = 0x0A0D0D0A, 1, 6
_MAGIC = 0x1A2B3C4D
SECTION_MARK = b"\x0a\x0d\x0d\x0a"
"""First bytes of pcapng."""
_OPTION_END, _COMMENT, _IF_NAME, _IF_DESCRIPTION, _USER_APPLICATION = 0, 1, 2, 3, 4
_EPB_FLAGS, _EPB_DROPS, _IF_SPEED, _IF_TSRESOL, _IF_TSOFFSET = 2, 4, 8, 9, 14
_NANOSECONDS = 9
_INBOUND, _OUTBOUND = 1, 2
_IN, _OUT = (struct.pack("<HHI", _EPB_FLAGS, 4, way) for way in (_INBOUND, _OUTBOUND))
_EVENT_HEAD, _PACKET_HEAD, _PACKET_END = map(struct.Struct, (">IIBBH", "<7I", "<2I"))
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
    """Name of the framing of its bytes; ``RAW``: they are no packets; "": it is not known. Of a bus whose
    link type is for users: its name."""
    baud: int = 0
    """Speed of the line or bus, in bits per second; 0: it is not known."""
    line_format: LineFormat = EIGHT_N_1
    """Format of its characters; written behind the framing, as in ``modbus_rtu 8E1``, where it is not 8N1."""
    link: int = LINKTYPE_RTAC_SERIAL
    """Link type of its records."""

    @property
    def is_can(self) -> bool:
        return self.link == LINKTYPE_CAN_SOCKETCAN

    @property
    def is_serial(self) -> bool:
        return self.link == LINKTYPE_RTAC_SERIAL

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
        body = struct.pack("<HHI", each.link, 0, 0) + _options(*options)
        blocks.append(_block(_INTERFACE, body))
    return b"".join(blocks)


def record(
    interface: int, at_ns: int, event: RecordKind, data: bytes = b"", comment: str = "", lost: int = 0
) -> bytes:
    """Encode one event of a serial line. ``at_ns``: nanoseconds since 1970. ``lost``: number of records that
    were lost before it."""
    seconds, rest_ns = divmod(at_ns, 10**9)
    payload = _EVENT_HEAD.pack(seconds & 0xFFFFFFFF, rest_ns // 1000, event, 0, 0) + data
    return _packet(interface, at_ns, payload, comment, lost, _OUT if event == RecordKind.TX else _IN)


def frame_record(interface: int, at_ns: int, packed: bytes, comment: str = "", lost: int = 0) -> bytes:
    """Encode a frame of a bus, packed as its link type says, or nothing, with a comment.
    ``at_ns``: nanoseconds since 1970. ``lost``: number of records that were lost before it."""
    return _packet(interface, at_ns, packed, comment, lost)


def _packet(
    interface: int, at_ns: int, payload: bytes, comment: str, lost: int, options: bytes = b""
) -> bytes:
    if lost:
        options += _option(_EPB_DROPS, struct.pack("<Q", lost))
    if comment:
        options += _option(_COMMENT, comment.encode())
    length, at_high, at_low = len(payload), at_ns >> 32 & 0xFFFFFFFF, at_ns & 0xFFFFFFFF
    size = _PACKET_HEAD.size + length + -length % 4 + len(options) + _PACKET_END.size
    head = _PACKET_HEAD.pack(_PACKET, size, interface, at_high, at_low, length, length)
    return head + _padded(payload) + options + _PACKET_END.pack(_OPTION_END, size)


@dataclass(frozen=True)
class Record:
    """One event as read back; ``offset`` is where its block begins in the file. Of a bus ``event`` is 0
    and ``data`` a frame, for CAN as Linux has it on a socket."""

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


def read(data: CaptureBytes, left_out: LeftOut | None = None) -> Iterator[Record]:
    """The records of a capture that ``header`` and ``record`` wrote, or that another program wrote of such
    lines. Others are left out, and counted.

    Raises:
        CaptureError: after all whole records, where the file is cut off or not what it should be.
    """
    if not data:
        raise CaptureError("the file is empty")
    if data[:4] != SECTION_MARK[: len(data)]:
        raise CaptureError("this is no pcapng file; `hil capture -w FILE` writes one")
    left_out = left_out or LeftOut()
    at, order, lines = 0, "<", list[_FileInterface]()
    while at < len(data):
        if len(data) - at < 12:
            raise CaptureError(cut_off(at))
        if data[at : at + 4] == SECTION_MARK:
            order, lines = "<" if data[at + 8 : at + 12] == struct.pack("<I", _MAGIC) else ">", []
        kind, size = struct.unpack(f"{order}II", data[at : at + 8])
        _check_size(size, at)
        if at + size > len(data):
            raise CaptureError(cut_off(at))
        body = data[at + 8 : at + size - 4]
        try:
            if kind == _INTERFACE:
                lines.append(_line(body, order, len(lines)))
            elif kind in _PACKETS:
                yield _record(_PACKETS[kind](body, order), order, lines, at)
        except (struct.error, ValueError) as error:
            left_out.add(
                f"byte {at}", "too short for what it is" if isinstance(error, struct.error) else str(error)
            )
        at += size


def _check_size(size: int, at: int) -> None:
    if size < 12 or size % 4 or size > _BLOCK_MAX:
        raise CaptureError(f"a block of {size} bytes at byte {at} cannot be")


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
            found.append(_interface(options, "<", len(found), link))
    return found


def _blocks(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Whole blocks that ``_block`` wrote: kind, begin and end."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        _check_size(size, at)
        if at + size > len(data):
            return
        yield kind, at, at + size
        at += size


def bursts(capture: Iterable[Record], interface: str | None) -> list[tuple[int, str]]:
    """The bursts of a line, for a tap to play: nanoseconds since the first, and hexadecimal digits.

    Raises:
        CaptureError: as who reads the records; or there is nothing of that interface.
    """
    records = list(capture)
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


def _interface(options: Mapping[int, bytes], order: str, number: int, link: int) -> Interface:
    name, about = (options.get(code, b"").decode("utf-8", "replace") for code in (_IF_NAME, _IF_DESCRIPTION))
    framing, _, line_format = about.partition(" ")
    baud = _number(options.get(_IF_SPEED, b""), order)
    if link in CAN_LINKS:
        return Interface(name or f"can{number}", "", baud, link=LINKTYPE_CAN_SOCKETCAN)
    if link in LINKTYPES_USER:
        return Interface(name or str(number), about, baud, link=link)
    return Interface(name or str(number), framing, baud, FORMATS.get(line_format, EIGHT_N_1))


class _FileInterface(NamedTuple):
    """Interface of a file. ``ticks``: of its times, in a second; they count from ``since_s``."""

    interface: Interface
    link: int
    ticks: int
    since_s: int


def _line(body: bytes, order: str, number: int) -> _FileInterface:
    (link,) = struct.unpack_from(f"{order}H", body)
    options = dict(_read_options(body[8:], order))
    resolution = (options.get(_IF_TSRESOL) or b"\x06")[0]
    ticks = 1 << (resolution & 0x7F) if resolution & 0x80 else 10**resolution
    offset = options.get(_IF_TSOFFSET, b"")
    (since_s,) = struct.unpack(f"{order}q", offset) if len(offset) == 8 else (0,)
    return _FileInterface(_interface(options, order, number, link), link, ticks, since_s)


class _Packet(NamedTuple):
    """Block of a packet. ``captured``: bytes of it that are there."""

    interface: int
    ticks: int
    captured: int
    rest: bytes


def _enhanced(body: bytes, order: str) -> _Packet:
    interface, high, low, captured, _ = struct.unpack_from(f"{order}IIIII", body)
    return _Packet(interface, high << 32 | low, captured, body[20:])


def _obsolete(body: bytes, order: str) -> _Packet:
    interface, _, high, low, captured, _ = struct.unpack_from(f"{order}HHIIII", body)
    return _Packet(interface, high << 32 | low, captured, body[20:])


def _simple(body: bytes, order: str) -> _Packet:
    (length,) = struct.unpack_from(f"{order}I", body)
    return _Packet(0, 0, min(length, len(body) - 4), body[4:])


_PACKETS = {_PACKET: _enhanced, 2: _obsolete, 3: _simple}
"""Kinds of blocks that have a packet: those of today, of version 1.0's drafts, and those without a time."""


def _record(packet: _Packet, order: str, lines: Sequence[_FileInterface], at: int) -> Record:
    if packet.interface >= len(lines):
        raise ValueError("of an interface that the file does not have")
    line = lines[packet.interface]
    options = dict(_read_options(packet.rest[packet.captured + -packet.captured % 4 :], order))
    at_ns = packet.ticks * 10**9 // line.ticks + line.since_s * 10**9
    payload, event = unwrapped(line.link, packet.rest[: packet.captured], order)
    comment = options.get(_COMMENT, b"").decode("utf-8", "replace")
    lost = _number(options.get(_EPB_DROPS, b""), order)
    return Record(line.interface, at_ns, event, payload, comment, at, lost)


def _number(data: bytes, order: str) -> int:
    return int.from_bytes(data, "little" if order == "<" else "big") if len(data) == 8 else 0


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


def _option(code: int, value: bytes) -> bytes:
    return struct.pack("<HH", code, len(value)) + _padded(value)


def _options(*options: tuple[int, bytes]) -> bytes:
    return b"".join(_option(*each) for each in options) + struct.pack("<HH", _OPTION_END, 0)


def _block(kind: int, body: bytes) -> bytes:
    size = len(body) + 12
    return struct.pack("<II", kind, size) + body + struct.pack("<I", size)
