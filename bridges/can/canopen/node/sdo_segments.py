"""SDO transfers by segments of up to seven bytes, each with its answer.

Source: CiA 301 version 4.2.0, 7.2.4.3.4 and 7.2.4.3.7.
"""

from collections.abc import Callable

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.node.application import Entry, SdoAbort
from bridges.can.canopen.node.data_types import longest
from bridges.can.canopen.sdo_frames import SEGMENT_BYTES, SdoAnswer, SdoRequest

WriteValue = Callable[[Entry, bytes, bytes, int], None]
"""Writes a value that has come whole, at a time, and sends the answer (its third argument) when it is
written. Raises SdoAbort."""


class SegmentDownload:
    """Download by segments. ``size``: what the client has said, or None."""

    is_in_block = False

    def __init__(
        self, entry: Entry, size: int | None, write: WriteValue, send: Callable[[bytes], None]
    ) -> None:
        self.index, self.subindex = entry.index, entry.subindex
        self._write = write
        self._entry = entry
        self._size = size
        self._most = longest(entry) if size is None else size
        self._send = send
        self._data = bytearray()
        self._toggle = 0

    def take(self, data: bytes, now_ns: int) -> bool:
        if sdo_frames.specifier(data) != SdoRequest.DOWNLOAD_SEGMENT:
            raise SdoAbort(AbortCode.COMMAND)
        if sdo_frames.toggle_of(data) != self._toggle:
            raise SdoAbort(AbortCode.TOGGLE)
        self._data += sdo_frames.part_of(data)
        if len(self._data) > self._most:
            raise SdoAbort(AbortCode.TOO_LONG if self._size is None else AbortCode.LENGTH)
        answer = sdo_frames.segment_answer(SdoAnswer.DOWNLOAD_SEGMENT, self._toggle)
        self._toggle ^= sdo_frames.TOGGLE
        if not sdo_frames.is_last(data):
            self._send(answer)
            return False
        if self._size not in (None, len(self._data)):
            raise SdoAbort(AbortCode.LENGTH)
        self._write(self._entry, bytes(self._data), answer, now_ns)
        return True


class SegmentUpload:
    """Upload by segments, of a value as it was when the transfer began."""

    is_in_block = False

    def __init__(self, index: int, subindex: int, value: bytes, send: Callable[[bytes], None]) -> None:
        self.index, self.subindex = index, subindex
        self._value = value
        self._at = 0
        self._send = send
        self._toggle = 0

    def take(self, data: bytes, now_ns: int) -> bool:
        if sdo_frames.specifier(data) != SdoRequest.UPLOAD_SEGMENT:
            raise SdoAbort(AbortCode.COMMAND)
        if sdo_frames.toggle_of(data) != self._toggle:
            raise SdoAbort(AbortCode.TOGGLE)
        part = self._value[self._at : self._at + SEGMENT_BYTES]
        self._at += SEGMENT_BYTES
        is_last = self._at >= len(self._value)
        self._send(sdo_frames.segment(self._toggle, part, is_last=is_last))
        self._toggle ^= sdo_frames.TOGGLE
        return is_last
