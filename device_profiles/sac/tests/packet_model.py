"""A second reader of packets, written for the tests: it looks at a whole stream at once, by position, where
the codec goes byte by byte. It shares no code with the codec; its CRC is the polynomial's definition."""

import re

_BODY = re.compile(rb"[^\0\2\3]{0,81}")
_HELD = 86


def crc(data: bytes) -> int:
    """x^8 + x^5 + x^4 + 1 as a division of the message's bits, least significant first."""
    register = 0
    for bit in (byte >> place & 1 for byte in data for place in range(8)):
        register ^= bit
        register = register >> 1 ^ (0x8C if register & 1 else 0)
    return register


def read(stream: bytes) -> tuple[list[tuple[str, bytes, int]], bytes]:
    """(kind, raw, end) of each item, "" being the kind of a packet; and what is not part of one yet."""
    items: list[tuple[str, bytes, int]] = []
    at = 0
    while at < len(stream):
        found = _packet(stream, at) if stream[at] == 2 else _noise(stream, at)
        if found is None:
            break
        kind, end = found
        raw = stream[at:end]
        items.append((kind, raw, end))
        is_unchecked = kind == "" and raw[-3:-2] != b"\3"  # of a checked one ETX is there
        at = end + (is_unchecked and stream[end : end + 1] == b"\0")
    return items, stream[at:]


def _noise(stream: bytes, at: int) -> tuple[str, int] | None:
    end = stream.find(b"\2", at, at + _HELD)
    if end >= 0:
        return "noise", end
    return ("noise", at + _HELD) if len(stream) - at >= _HELD else None


def _packet(stream: bytes, at: int) -> tuple[str, int] | None:
    for place in (at + 1, at + 2):
        address = stream[place : place + 1]
        if address in (b"", b"\2"):
            return ("cut", place) if address else None
        if address == b"\3":
            return "address", place + 1
    match = _BODY.match(stream, at + 3)
    assert match
    body_end = match.end()
    if body_end - at == 3 + 81:
        return "too long", body_end
    stop, check, last = (stream[place : place + 1] for place in range(body_end, body_end + 3))
    if stop in (b"", b"\2"):
        return ("cut", body_end) if stop else None
    if stop == b"\0":
        return "no ETX", body_end + 1
    if check == b"\0":
        return "", body_end + 2
    if not last:
        return None
    if last == b"\0":
        return "", body_end + 3
    if last == b"\2":
        return "no NUL", body_end + 2
    return "no NUL", body_end + (1 if check == b"\2" and last != b"\3" else 3)
