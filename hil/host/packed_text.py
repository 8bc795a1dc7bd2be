"""A text file that grows, plain or gzip, of which all is with the kernel after each flush."""

import os
import zlib
from contextlib import suppress
from typing import BinaryIO

LEVEL = 2
"""Level of compression: of 1 to 3, which cost about the same, the files of 2 and 3 are equally long."""
MEMBER_BYTES = 128 * 1024
"""Text of one gzip member: the last of a file is found and unpacked at once, without those before it."""


class PackedText:
    """Text file. Nothing is written before ``flush``. ``is_packed``: as gzip, as many
    members one behind the other, each begun with a line; a file that is not closed can be unpacked up to its
    last flush."""

    def __init__(self, file: BinaryIO, *, is_packed: bool) -> None:
        self._file = file
        self._packer = _packer() if is_packed else None
        self._kept = self._packer
        self._texts: list[bytes] = []
        self.problem: OSError | None = None
        self._member_bytes = self._kept_member_bytes = 0
        self.length = 0
        """Number of bytes in the file."""

    def write(self, text: str, /) -> None:
        self._texts.append(text.encode())

    def flush(self) -> int:
        """Write what has come since the last flush; answers how many texts of it are in the file: fewer than
        there were, none of them in part, if there was no room. Then ``problem`` says why."""
        texts, self._texts = self._texts, []
        try:
            self._write(texts, zlib.Z_SYNC_FLUSH)
            return len(texts)
        except OSError as error:
            self.problem = error
        written = 0
        with suppress(OSError):
            self._back()
            for written, text in enumerate(texts):  # noqa: B007 - the first that has no room
                self._write([text], zlib.Z_SYNC_FLUSH)
        with suppress(OSError):
            self._back()
        return written

    def close(self) -> None:
        """Write the rest, and close the file. Raises OSError: it cannot be written."""
        try:
            if self._texts or self._member_bytes:
                self._write(self._texts, zlib.Z_FINISH)
        finally:
            self._file.close()

    def _back(self) -> None:
        """Take back what was written in part."""
        self._packer, self._member_bytes = self._kept, self._kept_member_bytes
        os.ftruncate(self._file.fileno(), self.length)
        os.lseek(self._file.fileno(), self.length, os.SEEK_SET)

    def _write(self, texts: list[bytes], mode: int) -> None:
        data = b"".join(texts)
        if self._packer:
            self._kept, self._kept_member_bytes = self._packer.copy(), self._member_bytes
        if not data and mode != zlib.Z_FINISH:
            return
        self._member_bytes += len(data)
        is_over = mode == zlib.Z_FINISH or self._member_bytes >= MEMBER_BYTES
        if self._packer:
            data = self._packer.compress(data)
            data += self._packer.flush(zlib.Z_FINISH if is_over else zlib.Z_SYNC_FLUSH)
        left = memoryview(data)
        while left:
            left = left[os.write(self._file.fileno(), left) :]
        self.length += len(data)
        if is_over:
            self._member_bytes = 0
            self._packer = _packer() if self._packer else None
        self._kept, self._kept_member_bytes = self._packer, self._member_bytes


def _packer() -> "zlib._Compress":
    return zlib.compressobj(LEVEL, wbits=31)
