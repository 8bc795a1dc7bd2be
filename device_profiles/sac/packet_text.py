"""Packets as text, a line each: for captures and people."""

import re
from collections.abc import Iterator

from device_profiles.sac.packet import Malformed, Packet, crc8
from hil.vocab.packet_field import Fields, PacketField

_COMMAND = re.compile(rb"([A-Za-z$?]+)\s*(.*)", re.S)
_SIGNALS = {b"\x06": "ACK", b"\x15": "NAK", b"\x11": "DC1", b"\x12": "DC2"}


def packet_text(item: Packet | Malformed) -> str:
    """Format a packet as one line, as in ``1 -> 85 m3000`` or ``malformed (no ETX): 02 55``."""
    if isinstance(item, Malformed):
        return f"malformed ({item.fault}): {item.raw.hex(' ')}"
    to = "all" if item.destination == 0 else str(item.destination)
    said = _SIGNALS.get(item.data) or "".join(_shown(item.data))
    check = "" if item.is_good else f"  CRC {item.crc:02X} is wrong"
    return f"{item.origin} -> {to} {said}{check}"


def _shown(data: bytes) -> Iterator[str]:
    for byte in data:
        yield chr(byte) if 0x20 <= byte < 0x7F and byte != 0x5C else f"\\x{byte:02x}"


def packet_fields(item: Packet | Malformed) -> Fields:
    """Fields of a packet; none of what has no packet's form."""
    if isinstance(item, Malformed) or len(item.raw) < 5:
        return ()
    raw, data_end = item.raw, 3 + len(item.data)
    fields = [
        PacketField("STX", "02h", 0, 1),
        PacketField("to", "all" if item.destination == 0 else str(item.destination), 1, 2),
        PacketField("from", str(item.origin), 2, 3),
        PacketField("data", _SIGNALS.get(item.data) or "".join(_shown(item.data)), 3, data_end),
    ]
    if command := _COMMAND.fullmatch(item.data):
        for name, number in (("command", 1), ("argument", 2)):
            begin, end = command.span(number)
            if begin < end:
                text = "".join(_shown(command[number]))
                fields.append(PacketField(name, text, 3 + begin, 3 + end, 1))
    fields.append(PacketField("ETX", "03h", data_end, data_end + 1))
    if len(raw) > data_end + 2:
        right = crc8(item.data)
        said = "right" if raw[data_end + 1] == right else f"wrong, {right:02X}h would be right"
        fields.append(PacketField("CRC", f"{raw[data_end + 1]:02X}h, {said}", data_end + 1, data_end + 2))
    fields.append(PacketField("NUL", "00h, the end", len(raw) - 1, len(raw)))
    return fields
