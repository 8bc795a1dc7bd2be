"""Frames of SDO: eight bytes each way, built and taken apart.

The highest three bits of the first byte are its specifier; most frames have index and sub-index behind it.

Source: CiA 301 version 4.2.0, 7.2.4.3.
"""

from enum import IntEnum
from struct import Struct

FRAME_BYTES = 8
EXPEDITED_BYTES = 4
"""Most bytes of a value that the first frame carries."""
SEGMENT_BYTES = 7
MOST_IN_BLOCK = 127
"""Segments that a block may have."""
TOGGLE = 0x10
"""Bit that changes with each segment."""
ABORT_BYTE = 0x80
"""First byte of an abort. In a block it alone is one: segments have no specifier there."""
_LAST, _EXPEDITED, _SIZED = 0x01, 0x02, 0x01
_BLOCK_SIZED, _BLOCK_CRC, _BLOCK_LAST = 0x02, 0x04, 0x80
_HEAD, _NUMBER, _BLOCK_END = Struct("<BHB"), Struct("<I"), Struct("<BH5x")


class SdoRequest(IntEnum):
    """Specifier of a client's frame."""

    DOWNLOAD_SEGMENT, DOWNLOAD, UPLOAD, UPLOAD_SEGMENT, ABORT, BLOCK_UPLOAD, BLOCK_DOWNLOAD = range(7)


class SdoAnswer(IntEnum):
    """Specifier of a server's frame."""

    UPLOAD_SEGMENT, DOWNLOAD_SEGMENT, UPLOAD, DOWNLOAD, ABORT, BLOCK_DOWNLOAD, BLOCK_UPLOAD = range(7)


class BlockStep(IntEnum):
    """Step of a block transfer, bits 0 and 1 of a frame that is no segment. Of the one who sends the segments
    bit 1 means something else: ``is_block_end``."""

    BEGIN, END, TAKEN, SEND = range(4)


def specifier(frame: bytes) -> int:
    return frame[0] >> 5


def object_of(frame: bytes) -> tuple[int, int]:
    """Index and sub-index that a frame names."""
    return int.from_bytes(frame[1:3], "little"), frame[3]


def begin(kind: int, index: int, subindex: int, value: bytes = b"") -> bytes:
    """First frame of an upload; answer to that of a download; or, with 1 to 4 bytes, the value as a whole."""
    bits = EXPEDITED_BYTES - len(value) << 2 | _EXPEDITED | _SIZED if value else 0
    return _named(kind << 5 | bits, index, subindex, value)


def begin_segments(kind: int, index: int, subindex: int, size: int) -> bytes:
    """Frame before the segments of a value of ``size`` bytes."""
    return _named(kind << 5 | _SIZED, index, subindex, _NUMBER.pack(size))


def is_expedited(frame: bytes) -> bool:
    """True if a first frame carries the value."""
    return bool(frame[0] & _EXPEDITED)


def expedited(frame: bytes, unsized: int = EXPEDITED_BYTES) -> bytes:
    """Value in a first frame; ``unsized``: its number of bytes where the frame has none."""
    if frame[0] & _SIZED:
        unsized = EXPEDITED_BYTES - (frame[0] >> 2 & 3)
    return frame[4 : 4 + unsized]


def size_told(frame: bytes) -> int | None:
    """Number of bytes that a first frame of segments, or of blocks of the one who sends, tells."""
    is_block = specifier(frame) == SdoRequest.BLOCK_DOWNLOAD
    is_told = frame[0] & (_BLOCK_SIZED if is_block else _SIZED)
    return int.from_bytes(frame[4:], "little") if is_told else None


def segment(toggle: int, part: bytes, *, is_last: bool) -> bytes:
    """Segment of a value, of either side."""
    return bytes((toggle | SEGMENT_BYTES - len(part) << 1 | is_last,)) + part.ljust(SEGMENT_BYTES, b"\0")


def segment_answer(kind: int, toggle: int) -> bytes:
    """Answer to a segment, or request of one."""
    return bytes((kind << 5 | toggle, *bytes(7)))


def toggle_of(frame: bytes) -> int:
    return frame[0] & TOGGLE


def is_last(frame: bytes) -> bool:
    """True if a segment ends its value."""
    return bool(frame[0] & _LAST)


def part_of(frame: bytes) -> bytes:
    """Bytes of the value in a segment."""
    return frame[1 : 1 + SEGMENT_BYTES - (frame[0] >> 1 & 7)]


def abort(index: int, subindex: int, code: int) -> bytes:
    return _named(ABORT_BYTE, index, subindex, _NUMBER.pack(code))


def abort_code(frame: bytes) -> int:
    return int.from_bytes(frame[4:], "little")


def begin_block_answer(index: int, subindex: int, block_size: int, *, has_crc: bool) -> bytes:
    """Answer to a download by blocks, which asks for blocks of so many segments."""
    command = SdoAnswer.BLOCK_DOWNLOAD << 5 | _BLOCK_CRC * has_crc
    return _named(command, index, subindex, bytes((block_size,)))


def begin_block_upload_answer(index: int, subindex: int, size: int, *, has_crc: bool) -> bytes:
    command = SdoAnswer.BLOCK_UPLOAD << 5 | _BLOCK_CRC * has_crc | _BLOCK_SIZED
    return _named(command, index, subindex, _NUMBER.pack(size))


def has_crc(frame: bytes) -> bool:
    """True if who begins a transfer by blocks can check its value."""
    return bool(frame[0] & _BLOCK_CRC)


def block_step(frame: bytes) -> int:
    return frame[0] & 3


def is_block_end(frame: bytes) -> bool:
    """True if a frame of the one who sends the segments ends them."""
    return bool(frame[0] & BlockStep.END)


def block_segment(number: int, part: bytes, *, is_last: bool) -> bytes:
    """Segment of a block; ``number``: from 1 on."""
    return bytes((number | _BLOCK_LAST * is_last,)) + part.ljust(SEGMENT_BYTES, b"\0")


def block_segment_number(frame: bytes) -> tuple[int, bool]:
    """Number of a segment in its block, and True if it is the last of all."""
    return frame[0] & ~_BLOCK_LAST, bool(frame[0] & _BLOCK_LAST)


def block_taken(number: int, block_size: int) -> bytes:
    """Server's acknowledgement of a block up to a segment; the next block is to have so many."""
    return bytes((SdoAnswer.BLOCK_DOWNLOAD << 5 | BlockStep.TAKEN, number, block_size, *bytes(5)))


def block_end(unused: int, crc: int) -> bytes:
    """Server's end of its segments, of whose last so many bytes mean nothing."""
    return _BLOCK_END.pack(SdoAnswer.BLOCK_UPLOAD << 5 | unused << 2 | BlockStep.END, crc)


def block_unused(frame: bytes) -> int:
    """Number of bytes of the last segment that mean nothing, of the end of all blocks."""
    return frame[0] >> 2 & 7


def block_crc(frame: bytes) -> int:
    return int.from_bytes(frame[1:3], "little")


def block_end_answer() -> bytes:
    return bytes((SdoAnswer.BLOCK_DOWNLOAD << 5 | BlockStep.END, *bytes(7)))


def _named(command: int, index: int, subindex: int, data: bytes) -> bytes:
    return _HEAD.pack(command, index, subindex) + data.ljust(4, b"\0")
