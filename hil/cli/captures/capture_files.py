"""Files into which a capture goes: pcapng, or a log of a bus by the end of its name."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, Protocol

from hil.discovery.named_kinds import find_logs
from hil.host.new_file import begin_file
from hil.vocab.bus import LogKind
from hil.wire.outside_text import LeftOut
from hil.wire.pcapng import (
    SECTION_MARK,
    CaptureError,
    Interface,
    Record,
    cut_off,
    header_length,
    read,
    split_blocks,
    whole_blocks,
)

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
    if kind := log_kind(write):
        return _Log(Path(write), kind)
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


def log_kind(name: str) -> LogKind | None:
    """Kind of log that a file is by its name; None: it is none."""
    ending = Path(name).suffix.lower()
    return next((kind for kind in find_logs() if ending in kind.endings), None)


def check_line(line: Interface, kind: LogKind) -> None:
    """Check that such a log can have what is on a line. Raises CaptureError."""
    if not kind.has(line):
        raise CaptureError(f"{line.name} is no {kind.wire}; name the file .pcapng")


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


class _Log:
    """Log of a bus."""

    def __init__(self, path: Path, kind: LogKind) -> None:
        self._path, self._kind = path, kind
        self._writer = kind.writer(path.suffix.lower(), begin_file(path))
        self._records = Records()

    def write(self, blocks: bytes) -> None:
        self._writer.write(map(self._checked, self._records.feed(blocks)))

    def _checked(self, record: Record) -> Record:
        check_line(record.line, self._kind)
        return record

    def close(self) -> None:
        self._writer.close()

    def told(self) -> str:
        return _told(str(self._path))


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
