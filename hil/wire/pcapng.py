"""Captures as pcapng with LINKTYPE_RTAC_SERIAL (250), which Wireshark and tshark read. Pure.

Sources: the pcapng specification (IETF draft-ietf-opsawg-pcapng); Wireshark's dissector of the link type, for
its 12-byte header: seconds and microseconds (big-endian), event, control lines, two bytes of footer. What
the link type says of its payloads is about other protocols; here they are a line's bytes.
"""

import struct
from collections.abc import Sequence
from enum import IntEnum

LINKTYPE_RTAC_SERIAL = 250
_SECTION, _INTERFACE, _PACKET = 0x0A0D0D0A, 1, 6
_MAGIC = 0x1A2B3C4D
_OPTION_END, _COMMENT, _IF_NAME, _USER_APPLICATION, _EPB_FLAGS, _IF_TSRESOL = 0, 1, 2, 4, 2, 9
_NANOSECONDS = 9
_INBOUND, _OUTBOUND = 1, 2


class Event(IntEnum):
    """What a record is, as the link type numbers it. TX is what goes to a board, RX what a board sends."""

    TX = 1
    RX = 2
    LOST = 5
    FRAMING_ERROR = 7
    PARITY_ERROR = 8
    BREAK = 9
    OVERFLOW = 10


def header(program: str, interfaces: Sequence[str]) -> bytes:
    """The beginning of a capture: a section, and an interface for each name; numbers count from 0."""
    section = struct.pack("<IHHq", _MAGIC, 1, 0, -1) + _options((_USER_APPLICATION, program.encode()))
    blocks = [_block(_SECTION, section)]
    for name in interfaces:
        options = _options((_IF_NAME, name.encode()), (_IF_TSRESOL, bytes((_NANOSECONDS,))))
        blocks.append(_block(_INTERFACE, struct.pack("<HHI", LINKTYPE_RTAC_SERIAL, 0, 0) + options))
    return b"".join(blocks)


def record(interface: int, at_ns: int, event: Event, data: bytes = b"", comment: str = "") -> bytes:
    """One event. ``at_ns``: nanoseconds since 1970."""
    seconds, rest_ns = divmod(at_ns, 10**9)
    payload = struct.pack(">IIBBH", seconds & 0xFFFFFFFF, rest_ns // 1000, event, 0, 0) + data
    head = struct.pack(
        "<IIIII", interface, at_ns >> 32 & 0xFFFFFFFF, at_ns & 0xFFFFFFFF, len(payload), len(payload)
    )
    direction = _OUTBOUND if event == Event.TX else _INBOUND
    options = [(_EPB_FLAGS, struct.pack("<I", direction))]
    if comment:
        options.append((_COMMENT, comment.encode()))
    return _block(_PACKET, head + _padded(payload) + _options(*options))


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def _options(*options: tuple[int, bytes]) -> bytes:
    packed = b"".join(struct.pack("<HH", code, len(value)) + _padded(value) for code, value in options)
    return packed + struct.pack("<HH", _OPTION_END, 0)


def _block(kind: int, body: bytes) -> bytes:
    size = len(body) + 12
    return struct.pack("<II", kind, size) + body + struct.pack("<I", size)
