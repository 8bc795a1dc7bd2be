"""Link types of captures that have serial lines or CAN, and the way to what is in their packets.

Sources: the registry of link types at tcpdump.org; what tshark 4.0 shows of CAN in Linux's cooked captures
(``tcpdump -i any``), whose identifiers are in the order of the computer that wrote the file.
"""

import struct

LINKTYPE_RTAC_SERIAL, LINKTYPE_CAN_SOCKETCAN = 250, 227
_COOKED = {113: (16, 14), 276: (20, 0)}
"""Linux's cooked captures, of two versions: length of the header, and where in it the protocol stands."""
_COOKED_CAN = (0x0C, 0x0D, 0x0E)
"""Protocols of cooked captures: CAN, CAN FD, CAN XL."""
CAN_LINKS = (LINKTYPE_CAN_SOCKETCAN, *_COOKED)
_SERIAL_HEAD = 12
_ENDS = {3: 1, 4: 2}
"""Events that other programs have for data, too: the end of what was sent and received."""


def unwrapped(link: int, payload: bytes, order: str) -> tuple[bytes, int]:
    """Take the packet of a link type apart: its bytes, and which event of a serial line it is, 0 of CAN.
    ``order``: of the file's numbers, ``<`` or ``>``.

    Raises:
        ValueError: it is of something else, or too short.
    """
    if link == LINKTYPE_CAN_SOCKETCAN:
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
