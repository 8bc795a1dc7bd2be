"""Packets of GDB's remote protocol: ``$payload#checksum``, acknowledged by + or -; byte 03h interrupts."""

from collections.abc import Iterator
from enum import Enum, auto

MOST_BYTES = 4096
"""Maximum length of a packet that is taken; GDB is told of it."""
_INTERRUPT, _BEGIN, _END, _ESCAPE, _MASK = 0x03, ord("$"), ord("#"), ord("}"), 0x20
_ESCAPED = frozenset(b"$#}*")


class Interrupt(Enum):
    """Wish to stop, outside all packets: Ctrl-C in GDB."""

    CTRL_C = auto()


def packed(payload: bytes) -> bytes:
    """Pack an answer."""
    escaped = bytearray()
    for byte in payload:
        escaped += bytes((_ESCAPE, byte ^ _MASK)) if byte in _ESCAPED else bytes((byte,))
    return b"$%b#%02x" % (bytes(escaped), sum(escaped) & 0xFF)


def _unescaped(content: bytes) -> bytes:
    plain, is_escaped = bytearray(), False
    for byte in content:
        if byte == _ESCAPE and not is_escaped:
            is_escaped = True
        else:
            plain.append(byte ^ _MASK if is_escaped else byte)
            is_escaped = False
    return bytes(plain)


class PacketReader:
    """Reader of what GDB sends. ``answer``: what is to be sent because of it, the acknowledgements."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.has_acks = True
        """False once GDB has asked for none."""
        self._last = b""

    def sent(self, payload: bytes) -> bytes:
        """Bytes of an answer; it is sent again where GDB says that it came damaged."""
        self._last = packed(payload)
        return self._last

    def read(self, data: bytes, answer: bytearray) -> Iterator[bytes | Interrupt]:
        """Payloads of packets, and interrupts, in their order. Bytes between packets mean nothing."""
        self._buffer += data
        buffer = self._buffer
        while buffer:
            first = buffer[0]
            if first != _BEGIN:
                del buffer[0]
                if first == _INTERRUPT:
                    yield Interrupt.CTRL_C
                elif first == ord("-") and self.has_acks:
                    answer += self._last
                continue
            end = buffer.find(_END)
            if end < 0 or len(buffer) < end + 3:
                if len(buffer) > 2 * MOST_BYTES + 4:  # each byte of one may be escaped
                    del buffer[0]
                    continue
                return
            content, checksum = bytes(buffer[1:end]), bytes(buffer[end + 1 : end + 3])
            del buffer[: end + 3]
            is_right = checksum.lower() == b"%02x" % (sum(content) & 0xFF)
            if self.has_acks:
                answer += b"+" if is_right else b"-"
            if is_right:
                yield _unescaped(content)
