"""Client's side of an SDO transfer: what it sends, and what it makes of each answer. CiA 301, 7.2.4.3.

Expedited and segmented transfers, no block transfers: all that is asked of a drive is short.
"""

from dataclasses import dataclass, field

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import ABORTS, AbortCode
from bridges.can.canopen.sdo_frames import (
    ABORT_BYTE,
    EXPEDITED_BYTES,
    FRAME_BYTES,
    SEGMENT_BYTES,
    SdoAnswer,
    SdoRequest,
)

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
            return sdo_frames.begin(SdoRequest.UPLOAD, self.index, self.subindex)
        if self._is_short:
            return sdo_frames.begin(SdoRequest.DOWNLOAD, self.index, self.subindex, self.result)
        return sdo_frames.begin_segments(SdoRequest.DOWNLOAD, self.index, self.subindex, len(self.result))

    def hear(self, answer: bytes) -> bytes | None:
        """Take an answer; the next request, or None when all is done.

        Raises:
            TransferAborted: the drive ends the transfer.
            TransferGarbled: the answer does not fit.
        """
        if len(answer) != FRAME_BYTES:
            why = f"{self} was answered with {len(answer)} bytes, not {FRAME_BYTES}"
            raise self._garbled(why, AbortCode.GENERAL)
        if answer[0] == ABORT_BYTE:
            raise TransferAborted(sdo_frames.abort_code(answer), str(self))
        if not self._is_begun:
            return self._hear_first(answer)
        return self._hear_segment(answer) if self._is_read else self._hear_confirmation(answer)

    def is_for_this(self, answer: bytes) -> bool:
        """True unless an answer names another object, as a late one of the transfer before does."""
        is_segment = self._is_begun and answer[:1] != bytes([ABORT_BYTE])
        return is_segment or len(answer) < 4 or sdo_frames.object_of(answer) == (self.index, self.subindex)

    def abort(self, code: int) -> bytes:
        """Request that ends the transfer."""
        return sdo_frames.abort(self.index, self.subindex, code)

    @property
    def _is_short(self) -> bool:
        return 1 <= len(self.result) <= EXPEDITED_BYTES

    def _garbled(self, why: str, code: int) -> TransferGarbled:
        return TransferGarbled(why, self.abort(code))

    def _hear_first(self, answer: bytes) -> bytes | None:
        self._check_command(answer, SdoAnswer.UPLOAD if self._is_read else SdoAnswer.DOWNLOAD)
        index, subindex = sdo_frames.object_of(answer)
        if (index, subindex) != (self.index, self.subindex):
            raise self._garbled(f"{self} was answered for {index:04X}h:{subindex:02X}", AbortCode.GENERAL)
        self._is_begun = True
        if not self._is_read:
            return self._end() if self._is_short else self._next_segment()
        if sdo_frames.is_expedited(answer):
            self.data = sdo_frames.expedited(answer)
            return self._end()
        self.data = b""
        self._size = sdo_frames.size_told(answer)
        return sdo_frames.segment_answer(SdoRequest.UPLOAD_SEGMENT, self._toggle)

    def _hear_segment(self, answer: bytes) -> bytes | None:
        self._check_segment(answer, SdoAnswer.UPLOAD_SEGMENT)
        self.data = self.result + sdo_frames.part_of(answer)
        if len(self.data) > MOST_BYTES or (self._size is not None and len(self.data) > self._size):
            raise self._garbled(
                f"{self} was answered with more bytes than were announced", AbortCode.TOO_LONG
            )
        if sdo_frames.is_last(answer):
            if self._size not in (None, len(self.data)):
                raise self._garbled(
                    f"{self} was answered with fewer bytes than were announced", AbortCode.TOO_SHORT
                )
            return self._end()
        self._toggle ^= sdo_frames.TOGGLE
        return sdo_frames.segment_answer(SdoRequest.UPLOAD_SEGMENT, self._toggle)

    def _hear_confirmation(self, answer: bytes) -> bytes | None:
        self._check_segment(answer, SdoAnswer.DOWNLOAD_SEGMENT)
        self._toggle ^= sdo_frames.TOGGLE
        return self._end() if self._at >= len(self.result) else self._next_segment()

    def _check_command(self, answer: bytes, wanted: SdoAnswer) -> None:
        if sdo_frames.specifier(answer) != wanted:
            raise self._garbled(f"{self} was answered with command {answer[0]:02X}h", AbortCode.COMMAND)

    def _check_segment(self, answer: bytes, wanted: SdoAnswer) -> None:
        self._check_command(answer, wanted)
        if sdo_frames.toggle_of(answer) != self._toggle:
            raise self._garbled(f"{self}: an answer came twice, or one is missing", AbortCode.TOGGLE)

    def _next_segment(self) -> bytes:
        part = self.result[self._at : self._at + SEGMENT_BYTES]
        self._at += SEGMENT_BYTES
        return sdo_frames.segment(self._toggle, part, is_last=self._at >= len(self.result))

    def _end(self) -> bytes | None:
        self.is_done = True
        return None
