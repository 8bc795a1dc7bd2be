"""SDO server of a node: clients read and write its entries, in one frame, by segments or by blocks.

Source: CiA 301 version 4.2.0, 7.2.4.
"""

from collections.abc import Callable
from functools import partial
from typing import Protocol

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.node.application import Entry, PendingWrite, SdoAbort
from bridges.can.canopen.node.data_types import check_length, size_of
from bridges.can.canopen.node.object_dictionary import ObjectDictionary
from bridges.can.canopen.node.served_transfers import (
    BlockDownload,
    BlockUpload,
    SegmentDownload,
    SegmentUpload,
)
from bridges.can.canopen.node.timers import Timers
from bridges.can.canopen.sdo_frames import (
    ABORT_BYTE,
    EXPEDITED_BYTES,
    FRAME_BYTES,
    MOST_IN_BLOCK,
    BlockStep,
    SdoAnswer,
    SdoRequest,
)
from hil.vocab.time import NS_PER_S

TIME_OUT_NS = NS_PER_S
"""Silence of the client after which a transfer is aborted. The standard leaves it to the device; decision:
longer than clients wait for an answer."""


class Transfer(Protocol):
    """Transfer that takes more than one frame each way."""

    index: int
    subindex: int

    @property
    def is_in_block(self) -> bool:
        """True while frames of the client are segments without a command."""

    def feed(self, data: bytes, now_ns: int) -> bool:
        """Take a frame of the client, eight bytes; True if the transfer is over. Raises SdoAbort."""


class SdoServer:
    """Server of one channel. ``send`` takes the eight bytes of an answer.

    While a write takes time, as that of a memory, the server begins nothing else: it refuses what comes, as
    of now, and the answer to the write still follows.
    """

    def __init__(self, dictionary: ObjectDictionary, timers: Timers, send: Callable[[bytes], None]) -> None:
        self._dictionary = dictionary
        self._send = send
        self._timer = timers.make(self._give_up)
        self._transfer: Transfer | None = None
        self._written: PendingWrite | None = None
        """Write whose end the client is to be told."""
        self._starts = {
            SdoRequest.DOWNLOAD: self._start_download,
            SdoRequest.UPLOAD: self._start_upload,
            SdoRequest.BLOCK_DOWNLOAD: self._start_block_download,
            SdoRequest.BLOCK_UPLOAD: self._start_block_upload,
        }

    def reset(self) -> None:
        """Forget the transfer that is under way. A write that takes time goes on; nobody is told its end."""
        self._written = None
        self._end_transfer()

    def _end_transfer(self) -> None:
        self._transfer = None
        self._timer.stop()

    def hear(self, data: bytes, now_ns: int) -> None:
        """Take a frame of the client."""
        if self._written:
            self._turn_away(data)
            return
        transfer = self._transfer
        index, subindex = (transfer.index, transfer.subindex) if transfer else (0, 0)
        try:
            if len(data) != FRAME_BYTES:
                raise SdoAbort(AbortCode.COMMAND, "a frame of SDO has 8 bytes")
            kind, is_start = sdo_frames.specifier(data), _is_start(data)
            if kind == SdoRequest.ABORT and (
                data[0] == ABORT_BYTE or not (transfer and transfer.is_in_block)
            ):
                self.reset()
                return
            if transfer and (transfer.is_in_block or not is_start):
                if transfer.feed(data, now_ns):
                    self._end_transfer()
                else:
                    self._timer.start(now_ns + TIME_OUT_NS)
                return
            self.reset()
            if not is_start:
                raise SdoAbort(AbortCode.COMMAND)
            index, subindex = sdo_frames.object_of(data)
            self._transfer = self._starts[SdoRequest(kind)](data, index, subindex, now_ns)
            if self._transfer:
                self._timer.start(now_ns + TIME_OUT_NS)
        except SdoAbort as abort:
            self._abort(index, subindex, abort.code)

    def _abort(self, index: int, subindex: int, code: int) -> None:
        self.reset()
        self._send(sdo_frames.abort(index, subindex, code))

    def _turn_away(self, data: bytes) -> None:
        """Refuse what comes before the end of a write; the client's abort alone is taken."""
        data = data.ljust(FRAME_BYTES, b"\0")
        if data[0] == ABORT_BYTE:
            self.reset()
        else:
            self._send(sdo_frames.abort(*sdo_frames.object_of(data), AbortCode.NOT_NOW))

    def _write(self, entry: Entry, data: bytes, answer: bytes, now_ns: int) -> None:
        """Write a value. The answer follows when it is written. Raises SdoAbort: it was not."""
        pending = self._dictionary.download(entry, data, now_ns)
        if pending is None:
            self._send(answer)
        else:
            self._written = pending
            pending.then(partial(self._tell, pending, entry, answer))

    def _tell(self, pending: PendingWrite, entry: Entry, answer: bytes, code: int, now_ns: int) -> None:
        if self._written is not pending:
            return  # the client has given it up, or the node was reset
        self._written = None
        if code:
            self._send(sdo_frames.abort(entry.index, entry.subindex, code))
        else:
            self._send(answer)

    def _give_up(self, now_ns: int) -> None:
        if self._transfer:
            self._abort(self._transfer.index, self._transfer.subindex, AbortCode.TIMED_OUT)

    def _start_download(self, data: bytes, index: int, subindex: int, now_ns: int) -> Transfer | None:
        entry = self._dictionary.find_writable(index, subindex)
        answer = sdo_frames.begin(SdoAnswer.DOWNLOAD, index, subindex)
        if sdo_frames.is_expedited(data):
            value = sdo_frames.expedited(data, size_of(entry.data_type) or EXPEDITED_BYTES)
            self._write(entry, value, answer, now_ns)
            return None
        size = sdo_frames.size_told(data)
        if size is not None:
            check_length(entry, size)
        self._send(answer)
        return SegmentDownload(entry, size, self._write, self._send)

    def _start_upload(self, data: bytes, index: int, subindex: int, now_ns: int) -> Transfer | None:
        return self._upload(self._dictionary.upload(index, subindex, now_ns), index, subindex)

    def _upload(self, value: bytes, index: int, subindex: int) -> Transfer | None:
        if 1 <= len(value) <= EXPEDITED_BYTES:
            self._send(sdo_frames.begin(SdoAnswer.UPLOAD, index, subindex, value))
            return None
        self._send(sdo_frames.begin_segments(SdoAnswer.UPLOAD, index, subindex, len(value)))
        return SegmentUpload(index, subindex, value, self._send)

    def _start_block_download(self, data: bytes, index: int, subindex: int, now_ns: int) -> Transfer:
        entry = self._dictionary.find_writable(index, subindex)
        size = sdo_frames.size_told(data)
        if size is not None:
            check_length(entry, size)
        return BlockDownload(entry, size, self._write, self._send, has_crc=sdo_frames.has_crc(data))

    def _start_block_upload(self, data: bytes, index: int, subindex: int, now_ns: int) -> Transfer | None:
        block_size, threshold = data[4], data[5]
        if not 1 <= block_size <= MOST_IN_BLOCK:
            raise SdoAbort(AbortCode.BLOCK_SIZE)
        value = self._dictionary.upload(index, subindex, now_ns)
        if threshold and len(value) <= threshold:  # the client would rather have it without blocks
            return self._upload(value, index, subindex)
        return BlockUpload(index, subindex, value, block_size, self._send, has_crc=sdo_frames.has_crc(data))


def _is_start(data: bytes) -> bool:
    """True if a frame begins a transfer, whatever was before."""
    kind = sdo_frames.specifier(data)
    if kind == SdoRequest.BLOCK_DOWNLOAD:
        return not sdo_frames.is_block_end(data)
    if kind == SdoRequest.BLOCK_UPLOAD:
        return sdo_frames.block_step(data) == BlockStep.BEGIN
    return kind in (SdoRequest.DOWNLOAD, SdoRequest.UPLOAD)
