"""SDO dialogues in words: what is read and written, in one frame, in segments or in blocks.

Source: CiA 301, 7.2.4.3.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from bridges.can.canopen import sdo_frames
from bridges.can.canopen.abort_codes import ABORTS
from bridges.can.canopen.sdo_frames import (
    ABORT_BYTE,
    FRAME_BYTES,
    BlockStep,
    SdoAnswer,
    SdoRequest,
    object_of,
)
from bridges.can.canopen.words.object_words import ObjectWords

_KEPT_BYTES = 1 << 16
"""Maximum that is kept of a transfer to be said at its end."""

Moved = Callable[[int, int, bytes], None]
"""Called with what an object had or was given: index, sub-index, bytes."""


@dataclass
class _Transfer:
    """Transfer that is under way."""

    index: int
    subindex: int
    is_write: bool
    data: bytearray = field(default_factory=bytearray)
    seen: int = 0
    """Bytes that were moved, of which ``data`` may be the first ones."""
    block: list[bytes] = field(default_factory=list)
    """Segments since the last acknowledgement."""
    has_last: bool = False
    """True if the last of these ends the transfer."""
    is_in_block: bool = False
    """True while the next frames of the one that sends are segments of blocks, without a command."""
    is_whole: bool = False
    """True if all was sent, and a write only has to be taken."""

    def add(self, data: bytes) -> None:
        self.seen += len(data)
        self.data += data[: _KEPT_BYTES - len(self.data)]


class SdoWords:
    """Dialogue with one node's SDO server. ``moved`` is told of each transfer that has ended well."""

    def __init__(self, objects: ObjectWords, moved: Moved) -> None:
        self._objects, self._moved = objects, moved
        self._transfer: _Transfer | None = None

    def request(self, data: bytes) -> str:
        """Describe a frame of the client."""
        if len(data) != FRAME_BYTES:
            return _wrong_length(data)
        transfer = self._transfer
        if transfer and transfer.is_write and transfer.is_in_block and data[0] != ABORT_BYTE:
            return self._block_segment(transfer, data)
        match sdo_frames.specifier(data):
            case SdoRequest.DOWNLOAD | SdoRequest.UPLOAD as command:
                return self._initiate(data, is_write=command == SdoRequest.DOWNLOAD)
            case SdoRequest.DOWNLOAD_SEGMENT:
                return self._segment(data, is_write=True)
            case SdoRequest.UPLOAD_SEGMENT:
                return f"next segment of {self._name(transfer)}"
            case SdoRequest.BLOCK_UPLOAD:
                return self._block_upload_request(data)
            case SdoRequest.BLOCK_DOWNLOAD:
                return self._block_download_request(data)
            case SdoRequest.ABORT:
                return self._abort(data)
            case command:
                return f"unknown command {command}"

    def response(self, data: bytes) -> str:
        """Describe a frame of the server."""
        if len(data) != FRAME_BYTES:
            return _wrong_length(data)
        transfer = self._transfer
        if transfer and not transfer.is_write and transfer.is_in_block and data[0] != ABORT_BYTE:
            return self._block_segment(transfer, data)
        match sdo_frames.specifier(data):
            case SdoAnswer.UPLOAD_SEGMENT:
                return self._segment(data, is_write=False)
            case SdoAnswer.DOWNLOAD_SEGMENT:
                return self._taken("written") if transfer and transfer.is_whole else self._taken("")
            case SdoAnswer.UPLOAD:
                return self._uploaded(data)
            case SdoAnswer.DOWNLOAD:
                return self._written(data)
            case SdoAnswer.BLOCK_DOWNLOAD:
                return self._block_download_response(data)
            case SdoAnswer.BLOCK_UPLOAD:
                return self._block_upload_response(data)
            case SdoAnswer.ABORT:
                return self._abort(data)
            case command:
                return f"unknown command {command}"

    def is_in_block(self, *, is_request: bool) -> bool:
        """True if a frame of this side is a segment of a block."""
        transfer = self._transfer
        return bool(transfer and transfer.is_in_block and transfer.is_write == is_request)

    # ---- one frame, or segments ----

    def _initiate(self, data: bytes, *, is_write: bool) -> str:
        index, subindex = object_of(data)
        transfer = self._transfer = _Transfer(index, subindex, is_write)
        name = self._objects.name(index, subindex)
        if not is_write:
            return f"read {name}"
        if sdo_frames.is_expedited(data):
            transfer.add(sdo_frames.expedited(data))
            transfer.is_whole = True
            return f"write {name} = {self._value(transfer)}"
        return f"write {name}, {_size(data)}in segments"

    def _uploaded(self, data: bytes) -> str:
        index, subindex = object_of(data)
        transfer = self._transfer = _Transfer(index, subindex, False)
        name = self._objects.name(index, subindex)
        if sdo_frames.is_expedited(data):
            transfer.add(sdo_frames.expedited(data))
            return self._ended()
        return f"{name} has {_size(data)}in segments"

    def _written(self, data: bytes) -> str:
        index, subindex = object_of(data)
        transfer, name = self._transfer, self._objects.name(index, subindex)
        if transfer is None or (index, subindex) != (transfer.index, transfer.subindex):
            return f"{name} written, which nobody has asked for"
        return self._taken("written") if transfer.is_whole else f"{name} can be written"

    def _taken(self, what: str) -> str:
        """Say that a server has taken a segment, or all: what it was given counts from now on."""
        transfer, name = self._transfer, self._name(self._transfer)
        if not what or not transfer:
            return f"segment of {name} taken"
        self._transfer = None
        self._moved(transfer.index, transfer.subindex, bytes(transfer.data))
        return f"{name} written"

    def _segment(self, data: bytes, *, is_write: bool) -> str:
        transfer = self._transfer
        if transfer is None or transfer.is_write != is_write:
            return "a segment of nothing"
        transfer.add(sdo_frames.part_of(data))
        if not sdo_frames.is_last(data):
            return f"segment of {self._name(transfer)}, {transfer.seen} bytes so far"
        return self._ended()

    # ---- blocks ----

    def _block_segment(self, transfer: _Transfer, data: bytes) -> str:
        number, is_last = sdo_frames.block_segment_number(data)
        if number == len(transfer.block) + 1:
            transfer.block.append(data[1:])
            transfer.has_last = is_last
        return f"segment {number} of a block of {self._name(transfer)}{', the last' if is_last else ''}"

    def _block_taken(self, data: bytes) -> str:
        """Say the acknowledgement of a block. What was not taken is sent again, in the next one."""
        transfer, count = self._transfer, data[1]
        if transfer:
            transfer.is_in_block = not (transfer.has_last and count >= len(transfer.block))
            for segment in transfer.block[:count]:
                transfer.add(segment)
            transfer.block.clear()
        return f"block of {self._name(transfer)} taken up to segment {count}, next of {data[2]}"

    def _block_upload_request(self, data: bytes) -> str:
        what = sdo_frames.block_step(data)
        if what == BlockStep.BEGIN:
            index, subindex = object_of(data)
            self._transfer = _Transfer(index, subindex, False)
            return f"read {self._objects.name(index, subindex)} in blocks of {data[4]}"
        if what == BlockStep.TAKEN:
            return self._block_taken(data)
        if what == BlockStep.SEND:
            if self._transfer:
                self._transfer.is_in_block = True
            return f"begin to send {self._name(self._transfer)}"
        return "the end was taken"

    def _block_upload_response(self, data: bytes) -> str:
        if sdo_frames.is_block_end(data):
            return self._block_end(data)
        index, subindex = object_of(data)
        return f"{self._objects.name(index, subindex)} has {_size(data)}in blocks"

    def _block_download_request(self, data: bytes) -> str:
        if sdo_frames.is_block_end(data):
            return self._block_end(data)
        index, subindex = object_of(data)
        self._transfer = _Transfer(index, subindex, True)
        return f"write {self._objects.name(index, subindex)}, {_size(data)}in blocks"

    def _block_download_response(self, data: bytes) -> str:
        what, transfer = sdo_frames.block_step(data), self._transfer
        if what == BlockStep.END:
            return self._taken("written")
        if what == BlockStep.TAKEN:
            return self._block_taken(data)
        if transfer:
            transfer.is_in_block = True
        index, subindex = object_of(data)
        return f"{self._objects.name(index, subindex)} can be written in blocks of {data[4]}"

    def _block_end(self, data: bytes) -> str:
        if (transfer := self._transfer) is None:
            return "the end of nothing"
        transfer.is_in_block = False
        del transfer.data[max(len(transfer.data) - sdo_frames.block_unused(data), 0) :]
        return self._ended()

    # ---- ends ----

    def _ended(self) -> str:
        transfer = self._transfer
        assert transfer
        value, name = self._value(transfer), self._name(transfer)
        if transfer.is_write:
            transfer.is_whole = True
            return f"{name} = {value}, the end"
        self._transfer = None
        self._moved(transfer.index, transfer.subindex, bytes(transfer.data))
        return f"{name} is {value}"

    def _abort(self, data: bytes) -> str:
        index, subindex = object_of(data)
        code = sdo_frames.abort_code(data)
        self._transfer = None
        why = ABORTS.get(code, "an unknown code")
        return f"abort {self._objects.name(index, subindex)}: {why} ({code:08X}h)"

    def _value(self, transfer: _Transfer) -> str:
        return self._objects.value(transfer.index, transfer.subindex, bytes(transfer.data))

    def _name(self, transfer: _Transfer | None) -> str:
        return self._objects.name(transfer.index, transfer.subindex) if transfer else "nothing"


def _size(data: bytes) -> str:
    size = sdo_frames.size_told(data)
    return "" if size is None else f"{size} bytes "


def _wrong_length(data: bytes) -> str:
    return f"{len(data)} bytes, an SDO has {FRAME_BYTES}"
