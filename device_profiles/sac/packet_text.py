"""Packets as text, a line each: for captures and people."""

from collections.abc import Iterator

from device_profiles.sac.packet import Malformed, Packet

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
