"""Client's side of an SDO transfer: what it sends, and what it makes of each answer. CiA 301, 7.2.4.3.

Expedited and segmented transfers, no block transfers: all that is asked of a drive is short.
"""

from dataclasses import dataclass, field

from hil.wire.canopen.abort_codes import ABORTS

TOGGLE, TIMED_OUT, NO_COMMAND, GENERAL = 0x0503_0000, 0x0504_0000, 0x0504_0001, 0x0800_0000
"""Abort codes that this client sends. CiA 301, table 22."""
_EXPEDITED, _SIZED, _TOGGLE_BIT, _LAST = 0x02, 0x01, 0x10, 0x01
_ABORT = 4 << 5
_SEGMENT = 7
MOST_BYTES = 4096
"""Maximum length of what is read: a drive that goes on and on is aborted."""


class TransferAborted(Exception):
    """Abort by the drive; ``code`` is its abort code."""

    def __init__(self, code: int, what: str) -> None:
        super().__init__(f"it answered {what} with abort {code:08X}h ({ABORTS.get(code, 'unknown')})")
        self.code = code


class TransferGarbled(Exception):
    """Answer that fits nothing. ``abort``: frame that ends the transfer at the drive's side."""

    def __init__(self, why: str, abort: bytes) -> None:
        super().__init__(why)
        self.abort = abort


@dataclass
class SdoTransfer:
    """Transfer of one object. ``data``: bytes to be written; None: it is read, and they are what was."""

    index: int
    subindex: int = 0
    data: bytes | None = None
    is_done: bool = field(default=False, init=False)
    _is_read: bool = field(init=False, repr=False)
    _at: int = field(default=0, init=False, repr=False)
    _toggle: int = field(default=0, init=False, repr=False)
    _is_begun: bool = field(default=False, init=False, repr=False)
    _size: int | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        self._is_read = self.data is None

    def __str__(self) -> str:
        verb = "a read of" if self._is_read else "a write to"
        return f"{verb} {self.index:04X}h:{self.subindex:02X}"

    @property
    def result(self) -> bytes:
        """Bytes that were read or written."""
        return self.data or b""

    def first(self) -> bytes:
        """First request, 8 bytes; it may be asked for again to begin again."""
        self.is_done = self._is_begun = False
        self._at = self._toggle = 0
        if self._is_read:
            self.data = None
            return self._named(2 << 5)
        data = self.result
        if 0 < len(data) <= 4:
            return self._named(1 << 5 | (4 - len(data)) << 2 | _EXPEDITED | _SIZED, data)
        return self._named(1 << 5 | _SIZED, len(data).to_bytes(4, "little"))

    def hear(self, answer: bytes) -> bytes | None:
        """Take an answer; the next request, or None when all is done.

        Raises:
            TransferAborted: the drive ends the transfer.
            TransferGarbled: the answer does not fit.
        """
        if len(answer) != 8:
            raise self._garbled(f"{self} was answered with {len(answer)} bytes, not 8", GENERAL)
        if answer[0] == _ABORT:
            raise TransferAborted(int.from_bytes(answer[4:], "little"), str(self))
        if not self._is_begun:
            return self._hear_first(answer)
        return self._hear_segment(answer) if self._is_read else self._hear_confirmation(answer)

    def is_for_this(self, answer: bytes) -> bool:
        """True unless an answer names another object, as a late one of the transfer before does."""
        is_segment = self._is_begun and answer[:1] != bytes([_ABORT])
        return is_segment or len(answer) < 4 or answer[1:4] == self._name

    def abort(self, code: int) -> bytes:
        """Request that ends the transfer."""
        return self._named(_ABORT, code.to_bytes(4, "little"))

    @property
    def _name(self) -> bytes:
        return self.index.to_bytes(2, "little") + bytes([self.subindex])

    def _named(self, command: int, data: bytes = b"") -> bytes:
        return bytes([command]) + self._name + data.ljust(4, b"\0")

    def _garbled(self, why: str, code: int) -> TransferGarbled:
        return TransferGarbled(why, self.abort(code))

    def _hear_first(self, answer: bytes) -> bytes | None:
        command, wanted = answer[0], 2 if self._is_read else 3
        if command >> 5 != wanted:
            raise self._garbled(f"{self} was answered with command {command:02X}h", NO_COMMAND)
        if answer[1:4] != self._name:
            index, subindex = int.from_bytes(answer[1:3], "little"), answer[3]
            raise self._garbled(f"{self} was answered for {index:04X}h:{subindex:02X}", GENERAL)
        self._is_begun = True
        if not self._is_read:
            if len(self.result) in range(1, 5):
                return self._end()
            return self._next_segment()
        if command & _EXPEDITED:
            self.data = answer[4 : 8 - (command >> 2 & 3 if command & _SIZED else 0)]
            return self._end()
        self.data = b""
        self._size = int.from_bytes(answer[4:], "little") if command & _SIZED else None
        return bytes([3 << 5]) + bytes(7)

    def _hear_segment(self, answer: bytes) -> bytes | None:
        command = answer[0]
        self._check(command, 0)
        self.data = self.result + answer[1 : 8 - (command >> 1 & 7)]
        if len(self.data) > MOST_BYTES or (self._size is not None and len(self.data) > self._size):
            raise self._garbled(f"{self} was answered with more bytes than were announced", 0x0607_0012)
        if command & _LAST:
            if self._size not in (None, len(self.data)):
                raise self._garbled(f"{self} was answered with fewer bytes than were announced", 0x0607_0013)
            return self._end()
        self._toggle ^= _TOGGLE_BIT
        return bytes([3 << 5 | self._toggle]) + bytes(7)

    def _hear_confirmation(self, answer: bytes) -> bytes | None:
        self._check(answer[0], 1)
        self._toggle ^= _TOGGLE_BIT
        return self._end() if self._at >= len(self.result) else self._next_segment()

    def _check(self, command: int, wanted: int) -> None:
        if command >> 5 != wanted:
            raise self._garbled(f"{self} was answered with command {command:02X}h", NO_COMMAND)
        if command & _TOGGLE_BIT != self._toggle:
            raise self._garbled(f"{self}: an answer came twice, or one is missing", TOGGLE)

    def _next_segment(self) -> bytes:
        part = self.result[self._at : self._at + _SEGMENT]
        self._at += _SEGMENT
        is_last = self._at >= len(self.result)
        command = self._toggle | (_SEGMENT - len(part)) << 1 | (_LAST if is_last else 0)
        return bytes([command]) + part.ljust(_SEGMENT, b"\0")

    def _end(self) -> bytes | None:
        self.is_done = True
        return None
