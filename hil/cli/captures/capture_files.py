"""Files into which a capture goes: pcapng, or a log of CAN by the end of its name.

``.log`` is candump's, ``.asc`` and ``.blf`` are Vector's, by python-can. Those keep something back until they
are closed.
"""

import io
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, Protocol

from bridges.can.frames.candump_log import LoggedFrame, candump_line
from bridges.can.frames.socketcan import CanError, SocketCanError, error_parts, unpack
from hil.host.new_file import begin_file
from hil.wire.outside_text import LeftOut
from hil.wire.pcapng import (
    SECTION_MARK,
    CaptureError,
    Record,
    cut_off,
    header_length,
    read,
    split_blocks,
    whole_blocks,
)

LOG_ENDINGS = (".log", ".asc", ".blf")
Receive = Callable[[int], bytes | None]
"""Receives at most so many bytes, and none at the end; None: nothing has come for a while."""


class CaptureFile(Protocol):
    """File for whole blocks of pcapng, as they come."""

    def write(self, blocks: bytes) -> None:
        """Write blocks. Raises CaptureError: they do not belong here."""

    def close(self) -> None: ...

    def told(self) -> str:
        """Say where it is, and how large; after ``close``."""


def capture_file(write: str, rotate_bytes: int, files: int) -> CaptureFile:
    """Begin a file, by the end of its name; "-" is the standard output, as pcapng."""
    if is_log(write):
        return _CanLog(Path(write))
    if write == "-":
        return Stream(sys.stdout.buffer, "the standard output")
    return _Pcapng(write, rotate_bytes, files)


class Stream:
    """Stream of pcapng: the standard output, or a program's input."""

    def __init__(self, out: BinaryIO, name: str) -> None:
        self._out, self._name, self._written = out, name, 0

    def write(self, blocks: bytes) -> None:
        self._out.write(blocks)
        self._out.flush()
        self._written += len(blocks)

    def close(self) -> None:
        """Leave it open: it is somebody else's."""

    def told(self) -> str:
        return f"{self._written} bytes to {self._name}"


def is_log(name: str) -> bool:
    """True if a file is a log of CAN by its name."""
    return Path(name).suffix.lower() in LOG_ENDINGS


def _told(name: str) -> str:
    path = Path(name)
    return f"{path.stat().st_size} bytes in {name}" if path.is_file() else name


class _Pcapng:
    """Files of pcapng, each with the header at its beginning."""

    def __init__(self, write: str, rotate_bytes: int, files: int) -> None:
        self._write, self._rotate_bytes, self._files = write, rotate_bytes, files
        self._out = begin_file(Path(write))
        self._head, self._written, self._number = b"", 0, 0

    def write(self, blocks: bytes) -> None:
        if self._written == len(self._head):  # no record yet
            self._head += blocks[: header_length(blocks)]
        # However many have come at once, no file is longer than it may be.
        for piece in split_blocks(blocks) if self._rotate_bytes else (blocks,):
            if self._rotate_bytes and self._written + len(piece) > self._rotate_bytes:
                self._rotate()
            self._out.write(piece)
            self._written += len(piece)
        self._out.flush()

    def _rotate(self) -> None:
        if self._written <= len(self._head):  # a record that is longer than a file may be
            return
        self._number += 1
        self._out.close()
        # With its header from its first moment on, whenever this is ended.
        self._out = begin_file(Path(self._name(self._number)), self._head)
        self._written = len(self._head)
        if self._number >= self._files:
            Path(self._name(self._number - self._files)).unlink(missing_ok=True)

    def close(self) -> None:
        self._out.close()

    def told(self) -> str:
        first = max(self._number - self._files + 1, 0)
        if first == self._number:
            return _told(self._name(first))
        return f"{self._number - first + 1} files, {self._name(first)} to {self._name(self._number)}"

    def _name(self, number: int) -> str:
        path = Path(self._write)
        return self._write if number == 0 else str(path.with_name(f"{path.stem}-{number}{path.suffix}"))


class Records:
    """Records of a capture whose blocks come in pieces."""

    def __init__(self, left_out: LeftOut | None = None) -> None:
        self._head, self._is_complete = b"", False
        self._left_out = left_out

    def feed(self, blocks: bytes) -> Iterator[Record]:
        """Take whole blocks; gives the records among them."""
        size = 0 if self._is_complete else header_length(blocks)
        self._head += blocks[:size]
        self._is_complete = self._is_complete or size < len(blocks)
        if self._is_complete:
            yield from read(self._head + blocks[size:], self._left_out)


class _CanLog:
    """Log of CAN buses."""

    def __init__(self, path: Path) -> None:
        self._path, self._ending = path, path.suffix.lower()
        self._out: BinaryIO = begin_file(path)
        self._writer = _writer(self._ending, self._out)
        self._channels: list[str] = []
        """Buses, in the order of their first frames: those logs have numbers for them."""
        self._records = Records()

    def write(self, blocks: bytes) -> None:
        for record in self._records.feed(blocks):
            self._put(logged(record))
        if self._ending != ".blf":
            self._out.flush()

    def close(self) -> None:
        if self._writer:
            self._writer.stop()
        self._out.close()

    def told(self) -> str:
        return _told(str(self._path))

    def _put(self, frame: LoggedFrame) -> None:
        if not self._writer:
            self._out.write(f"{candump_line(frame)}\n".encode())
            return
        if frame.bus not in self._channels:
            self._channels.append(frame.bus)
        self._writer.on_message_received(_message(frame, self._channels.index(frame.bus)))


def logged(record: Record) -> LoggedFrame:
    """Frame of a record. Raises CaptureError: it is of no CAN bus, or none of classic CAN."""
    if not record.line.is_can:
        raise CaptureError(f"{record.interface} is no CAN bus; name the file .pcapng")
    try:
        return LoggedFrame(record.at_ns, record.interface, unpack(record.data))
    except SocketCanError as error:
        raise CaptureError(f"{error}, at byte {record.offset}") from None


def _writer(ending: str, out: BinaryIO) -> Any:
    """Writer of python-can; None for candump's log."""
    if ending == ".log":
        return None  # python-can's leaves out how much a remote frame asks for, and which error one is
    from can import ASCWriter, BLFWriter

    # The first channel of both is 1; those that python-can is given count from 0.
    if ending == ".asc":
        return ASCWriter(io.TextIOWrapper(out, encoding="utf-8", write_through=True))
    return BLFWriter(out)


def _message(each: LoggedFrame, channel: int) -> Any:
    from can import Message

    frame, at_s = each.frame, each.at_ns / 1e9
    if isinstance(frame, CanError):
        error_class, data = error_parts(frame)
        return Message(at_s, error_class, is_error_frame=True, data=data, channel=channel)
    return Message(
        at_s,
        frame.id,
        is_extended_id=frame.is_extended,
        is_remote_frame=frame.is_remote,
        dlc=frame.dlc,
        data=None if frame.is_remote else frame.data,
        channel=channel,
    )


def records_of(receive: Receive, left_out: LeftOut | None = None) -> Iterator[Record | None]:
    """Records of a capture that is still being written, each as it comes; None where nothing has come for a
    while.

    Raises:
        CaptureError: it is no capture of hil's, or cut off at its end.
    """
    records = Records(left_out)
    for blocks in blocks_of(receive, has_end=True):
        yield from records.feed(blocks) if blocks else (None,)


def blocks_of(receive: Receive, *, has_end: bool = False) -> Iterator[bytes]:
    """Whole blocks of pcapng as hil writes it, until there is nothing more; b"" where none have come for some
    time. ``has_end``: it ends with one.

    Raises:
        CaptureError: it is none, or cut off where it has to end with a block.
    """
    held, is_first, at = b"", True, 0
    while (data := receive(65536)) != b"":
        if data is None:
            yield b""
            continue
        held += data
        if is_first and len(held) >= len(SECTION_MARK) and not held.startswith(SECTION_MARK):
            raise CaptureError("this is no pcapng")
        is_first = is_first and len(held) < len(SECTION_MARK)
        if size := whole_blocks(held):
            yield held[:size]
            held = held[size:]
            at += size
    if held and has_end:
        raise CaptureError(cut_off(at))
