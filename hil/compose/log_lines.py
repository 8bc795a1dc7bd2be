"""Lines of a log's file, plain or gzip, as far as they are there: it may be cut, damaged, or still grow."""

import os
import zlib
from codecs import BOM_UTF8
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, Self

from hil.compose.bundles import BOARDS, LOG, Trusts, UnpackedBundle, is_bundle, trusts_nobody
from hil.host.regular_file import open_regular
from hil.sim.input_log import InputLog, place
from hil.sim.inputs import InputLogError
from hil.sim.log_reading import REMEDY, read_input_log

LONGEST_LINE_BYTES = 64 * 1024 * 1024
"""Maximum length of a line: the longest header, of 512 boards with their tables, has two thirds."""
GZIP_MAGIC = b"\x1f\x8b"
_PIECE_BYTES = 1 << 16
_UNPACKED_BYTES = 1 << 20
"""Maximum that is unpacked at once: a file made for it has a thousand times its length."""


class LogLines:
    """Whole lines of a log that is open: each call of ``more`` gives those that are there since the one
    before. Use it as a context. A copy of the process reads on from a place of its own."""

    def __init__(self, path: Path) -> None:
        """Open the file.

        Raises:
            OSError: it cannot be read, or is no regular file.
        """
        self._file: BinaryIO = open_regular(path)
        self._at = 0
        self._name = str(path)
        self._number = 0
        self._rest: list[bytes] = []
        self._rest_bytes = 0
        self._is_begun = False
        self._gzip: zlib._Decompress | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def fileno(self) -> int:
        return self._file.fileno()

    def more(self) -> Iterator[bytes]:
        """Read the whole lines that are there, with their ends.

        Raises:
            InputLogError: a line has no end, or the file is no gzip from some place on.
        """
        while packed := os.pread(self._file.fileno(), _PIECE_BYTES, self._at):
            self._at += len(packed)
            if not self._is_begun:
                self._is_begun = True
                if packed.startswith(GZIP_MAGIC):
                    self._gzip = zlib.decompressobj(wbits=31)
                packed = packed.removeprefix(BOM_UTF8)  # an editor's mark
            for data in self._unpacked(packed):
                yield from self._whole(data)

    def _whole(self, data: bytes) -> Iterator[bytes]:
        first, *others = data.split(b"\n")
        self._rest.append(first)
        self._rest_bytes += len(first)
        if self._rest_bytes > LONGEST_LINE_BYTES:
            raise InputLogError(f"{place(self._name, self._number + 1)}: a line without end; {REMEDY}")
        for other in others:
            self._number += 1
            yield b"".join(self._rest) + b"\n"
            self._rest, self._rest_bytes = [other], len(other)

    def _unpacked(self, data: bytes) -> Iterator[bytes]:
        if self._gzip is None:
            yield data
            return
        while data:
            before = self._gzip.copy()
            try:
                yield self._gzip.decompress(data, _UNPACKED_BYTES)
            except zlib.error as error:
                yield from _up_to_error(before, data)
                where = place(self._name, self._number + 1)
                raise InputLogError(f"{where}: the file is damaged here ({error}); {REMEDY}") from None
            data = self._gzip.unconsumed_tail
            if self._gzip.eof:  # another member follows
                data = self._gzip.unused_data
                self._gzip = zlib.decompressobj(wbits=31)


def _up_to_error(packer: "zlib._Decompress", data: bytes) -> Iterator[bytes]:
    """Unpack byte by byte: what a call has unpacked before its error is lost."""
    with suppress(zlib.error):
        for at in range(len(data)):
            yield packer.decompress(data[at : at + 1])


def read_log(path: Path, *, strict: bool = True, trusts: Trusts = trusts_nobody) -> InputLog:
    """Read a log's file, or that of a bundle; what is not whole at its end is left out. ``strict``: as
    ``read_input_log``; ``trusts``: asked before code of a bundle's own boards may run.

    Raises:
        InputLogError: it is no input log, or not of a version that is known here; says where.
        OSError: it cannot be read, or is no regular file.
    """
    if is_bundle(path):
        return _of_bundle(path, UnpackedBundle(path, trusts), strict=strict)
    with LogLines(path) as lines:
        return read_input_log(lines.more(), str(path), strict=strict)


def _of_bundle(path: Path, bundle: UnpackedBundle, *, strict: bool) -> InputLog:
    with LogLines(bundle.log) as lines:
        log = read_input_log(lines.more(), f"{path}: {LOG}", strict=strict)
    paths = [str(bundle.folder / BOARDS)] if bundle.manifest.own_boards else []
    own = {"profile_path": paths}
    reloads = [
        place._replace(reload=replace(place.reload, config={**place.reload.config, **own}))
        for place in log.reloads
    ]
    return replace(log, config=log.config | own, reloads=reloads, unpacked=bundle)
