"""SDO transfers of more than one frame, as the server has them: by segments of up to seven bytes, each with
its answer; by blocks of up to 127 segments with one answer, and a CRC behind all of them if the client has
said that it can.

Source: CiA 301 version 4.2.0, 7.2.4.3.4 and 7.2.4.3.7 (segments), 7.2.4.3.9 to 7.2.4.3.15 (blocks),
7.2.4.3.16 (the CRC).
"""

from binascii import crc_hqx
from collections.abc import Callable

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.node.application import Entry, SdoAbort
from bridges.can.canopen.node.data_types import longest
from bridges.can.canopen.sdo_frames import MOST_IN_BLOCK, SEGMENT_BYTES, BlockStep, SdoAnswer, SdoRequest

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

    def feed(self, data: bytes, now_ns: int) -> bool:
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

    def feed(self, data: bytes, now_ns: int) -> bool:
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


class BlockDownload:
    """Download by blocks. Making it sends the first answer. ``size``: what the client has said, or None."""

    def __init__(
        self,
        entry: Entry,
        size: int | None,
        write: WriteValue,
        send: Callable[[bytes], None],
        *,
        has_crc: bool,
    ) -> None:
        self.index, self.subindex = entry.index, entry.subindex
        self.is_in_block = True
        self._write = write
        self._entry = entry
        self._size = size
        self._most = longest(entry) if size is None else size
        self._send = send
        self._has_crc = has_crc
        self._data = bytearray()
        self._got = 0
        """Number of the last segment of the block that came in its order."""
        self._has_last = False
        send(sdo_frames.begin_block_answer(entry.index, entry.subindex, MOST_IN_BLOCK, has_crc=has_crc))

    def feed(self, data: bytes, now_ns: int) -> bool:
        if not self.is_in_block:
            return self._end(data, now_ns)
        number, is_last = sdo_frames.block_segment_number(data)
        if number == 0:
            raise SdoAbort(AbortCode.SEQUENCE)
        if number == self._got + 1:
            self._got = number
            self._data += data[1:]
            self._has_last = is_last
            if len(self._data) > self._most + SEGMENT_BYTES:
                raise SdoAbort(AbortCode.TOO_LONG if self._size is None else AbortCode.LENGTH)
        if is_last or number == MOST_IN_BLOCK:
            # What did not come in its order comes again: the answer has the last number that did.
            self.is_in_block = not self._has_last
            self._send(sdo_frames.block_taken(self._got, MOST_IN_BLOCK))
            self._got = 0
        return False

    def _end(self, data: bytes, now_ns: int) -> bool:
        if sdo_frames.specifier(data) != SdoRequest.BLOCK_DOWNLOAD:
            raise SdoAbort(AbortCode.COMMAND)
        value = bytes(self._data[: len(self._data) - sdo_frames.block_unused(data)])
        if self._size not in (None, len(value)):
            raise SdoAbort(AbortCode.LENGTH)
        if self._has_crc and crc_hqx(value, 0) != sdo_frames.block_crc(data):
            raise SdoAbort(AbortCode.CRC)
        self._write(self._entry, value, sdo_frames.block_end_answer(), now_ns)
        return True


class BlockUpload:
    """Upload by blocks, of a value as it was when the transfer began. Making it sends the first answer."""

    is_in_block = False

    def __init__(
        self,
        index: int,
        subindex: int,
        value: bytes,
        block_size: int,
        send: Callable[[bytes], None],
        *,
        has_crc: bool,
    ) -> None:
        self.index, self.subindex = index, subindex
        self._value = value
        self._block_size = block_size
        self._send = send
        self._has_crc = has_crc
        self._at = 0
        """Number of bytes that the client has."""
        self._sent = 0
        """Number of segments of the block; 0 before the first block and behind the last."""
        self._has_started = self._has_ended = False
        send(sdo_frames.begin_block_upload_answer(index, subindex, len(value), has_crc=has_crc))

    def feed(self, data: bytes, now_ns: int) -> bool:
        step = sdo_frames.block_step(data)
        if sdo_frames.specifier(data) != SdoRequest.BLOCK_UPLOAD:
            raise SdoAbort(AbortCode.COMMAND)
        if step == BlockStep.SEND and not self._has_started:
            self._has_started = True
            self._send_block()
        elif step == BlockStep.TAKEN and self._sent:
            self._acknowledge(data[1], data[2])
        elif step == BlockStep.END and self._has_ended:
            return True
        else:
            raise SdoAbort(AbortCode.COMMAND)
        return False

    def _acknowledge(self, number: int, block_size: int) -> None:
        if number > self._sent:
            raise SdoAbort(AbortCode.SEQUENCE)
        if not 1 <= block_size <= MOST_IN_BLOCK:
            raise SdoAbort(AbortCode.BLOCK_SIZE)
        self._block_size = block_size
        is_all = number == self._sent and self._at + SEGMENT_BYTES * number >= len(self._value)
        self._at = min(self._at + SEGMENT_BYTES * number, len(self._value))
        self._sent = 0
        if not is_all:
            self._send_block()
            return
        self._has_ended = True
        unused = -len(self._value) % SEGMENT_BYTES if self._value else SEGMENT_BYTES
        crc = crc_hqx(self._value, 0) if self._has_crc else 0
        self._send(sdo_frames.block_end(unused, crc))

    def _send_block(self) -> None:
        at = self._at
        for number in range(1, self._block_size + 1):
            part = self._value[at : at + SEGMENT_BYTES]
            at += SEGMENT_BYTES
            is_last = at >= len(self._value)
            self._send(sdo_frames.block_segment(number, part, is_last=is_last))
            self._sent = number
            if is_last:
                return
