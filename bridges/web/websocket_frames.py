"""Frames of WebSockets, as RFC 6455 has them: what the HTTP library lets pass and a server has to refuse, and
long messages in fragments, so that no more than one waits for a page. Pure."""

from collections.abc import Iterable, Iterator
from struct import Struct

FRAGMENT_BYTES = 1 << 16
_TEXT, _CLOSE = 1, 8
_FIN, _MASK = 0x80, 0x80
_REFUSED = bytes((_FIN | 3, _MASK, 0, 0, 0, 0))
"""Frame of a reserved kind: the library ends the connection with 1002, as is due to a frame that is wrong."""
_LENGTHS = {126: Struct(">H"), 127: Struct(">Q")}
_SHORTEST = {126: 126, 127: 1 << 16}
"""Smallest lengths that are written so: a shorter form has to be used for less (5.2)."""


class FrameCheck:
    """Check of the frames that a page sends, in any pieces: each has a mask (5.1), the shortest length (5.2)
    and its turn among the fragments of a message (5.4), and a close has a code that may be sent (7.4)."""

    def __init__(self) -> None:
        self._held = bytearray()
        """Begin of a frame."""
        self._payload_left = 0
        self._is_in_message = self._is_over = False

    def passed(self, data: bytes) -> bytes:
        """Bytes that may go on to the library."""
        if self._is_over:
            return b""
        checked, at = [], min(self._payload_left, len(data))
        self._payload_left -= at
        checked.append(data[:at])
        self._held += data[at:]
        while not self._payload_left and (head := _head_size(self._held)):
            kind, length = self._held[0] & 0x0F, _length(self._held)
            if kind == _CLOSE and len(self._held) < head + min(length, 2):
                break
            if self._is_wrong(head, length):
                self._is_over = True
                return b"".join((*checked, _REFUSED))
            if kind < _CLOSE:
                self._is_in_message = not self._held[0] & _FIN
            taken = min(head + length, len(self._held))
            checked.append(bytes(self._held[:taken]))
            del self._held[:taken]
            self._payload_left = head + length - taken
        return b"".join(checked)

    def _is_wrong(self, head: int, length: int) -> bool:
        kind, form = self._held[0] & 0x0F, self._held[1] & 0x7F
        if not self._held[1] & _MASK or length < _SHORTEST.get(form, 0) or length >> 63:
            return True
        if kind < _CLOSE:
            return self._is_in_message != (kind == 0)
        if kind == _CLOSE and length >= 2:
            mask = self._held[head - 4 : head]
            code = (self._held[head] ^ mask[0]) << 8 | self._held[head + 1] ^ mask[1]
            return not (1000 <= code <= 1003 or 1007 <= code <= 1014 or 3000 <= code <= 4999)
        return False


def _head_size(frame: bytearray) -> int:
    """Length of a frame's head, 0 if it is not whole."""
    if len(frame) < 2:
        return 0
    form = frame[1] & 0x7F
    size = 2 + (_LENGTHS[form].size if form in _LENGTHS else 0) + (4 if frame[1] & _MASK else 0)
    return size if len(frame) >= size else 0


def _length(frame: bytearray) -> int:
    form = frame[1] & 0x7F
    return int(_LENGTHS[form].unpack_from(frame, 2)[0]) if form in _LENGTHS else form


def fragments(parts: Iterable[bytes]) -> Iterator[bytes]:
    """Frames of a text, which may be made while it is sent."""
    kind = _TEXT
    for part in parts:
        for at in range(0, len(part), FRAGMENT_BYTES):
            yield _frame(kind, part[at : at + FRAGMENT_BYTES])
            kind = 0
    yield _frame(_FIN | kind, b"")


def _frame(first: int, payload: bytes) -> bytes:
    if len(payload) < 126:
        return bytes((first, len(payload))) + payload
    form = 126 if len(payload) < 1 << 16 else 127
    return bytes((first, form)) + _LENGTHS[form].pack(len(payload)) + payload
