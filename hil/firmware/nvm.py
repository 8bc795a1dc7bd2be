"""The file format of a board's non-volatile memory.

All versions begin with the same header, little-endian: magic (8 bytes), version (16 bit), CRC-32 over the
whole file but the CRC itself. Version 2 goes on with the profile's name, a write counter (64 bit), the number
of sections (16 bit), and each section's name and data. Names are UTF-8 after one byte of length, data comes
after four. In version 1 the rest of the file is one section without a name.
"""

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

MAGIC = b"hil-nvm\n"
FORMAT_VERSION = 2

_HEADER = struct.Struct("<8sHI")
_SIGNED = struct.Struct("<8sH")
_COUNTER_AND_SECTIONS = struct.Struct("<QH")
_NAME_LENGTH = struct.Struct("<B")
_DATA_LENGTH = struct.Struct("<I")


@dataclass(frozen=True)
class Content:
    """The non-volatile memory of a board."""

    profile: str
    """The profile whose firmware wrote it, at most 255 bytes; "" if the file did not say."""
    counter: int
    """Number of commits, 0 to 2**64 - 1, which the committer increments."""
    sections: Mapping[str, bytes]
    """Sections, at most 65,535, with names of at most 255 bytes. A version 1 file's only one is named ""."""


@dataclass(frozen=True)
class Decoded:
    """A file's content, and the format version it had if that was not the current one."""

    content: Content
    migrated_from: int | None = None


class NvmError(Exception):
    """Error of a file that cannot be used: ``str(error)`` is the reason, in one line."""


class NvmNewer(NvmError):
    """Error of a file that is whole, and of a version that this program does not know."""


def encode(content: Content) -> bytes:
    """Encode a file of the current version; equal contents give equal bytes.

    Raises:
        ValueError: a name, a section, the counter or the number of sections is too large to store.
    """
    try:
        body = _name(content.profile) + _COUNTER_AND_SECTIONS.pack(content.counter, len(content.sections))
        for name, data in sorted(content.sections.items()):
            body += _name(name) + _DATA_LENGTH.pack(len(data)) + data
    except struct.error as error:
        raise ValueError(f"memory content cannot be stored: {error}") from error
    return _HEADER.pack(MAGIC, FORMAT_VERSION, _checksum(FORMAT_VERSION, body)) + body


def decode(data: bytes) -> Decoded:
    """Decode a file of the current version or an older one.

    Raises:
        NvmNewer: it is of a later version.
        NvmError: it is foreign or damaged.
    """
    if data[: len(MAGIC)] != MAGIC:
        raise NvmError("not a memory file")
    if len(data) < _HEADER.size:
        raise NvmError("damaged: too short")
    _, version, checksum = _HEADER.unpack_from(data)
    body = data[_HEADER.size :]
    # First the checksum, so that a damaged version number is not taken for a newer format.
    if checksum != _checksum(version, body):
        raise NvmError("damaged: the checksum is wrong")
    if version == 1:
        return Decoded(Content(profile="", counter=0, sections={"": body}), migrated_from=1)
    if version != FORMAT_VERSION:
        unknown = NvmNewer if version > FORMAT_VERSION else NvmError
        raise unknown(f"format version {version} is unknown: this program reads 1 to {FORMAT_VERSION}")
    return Decoded(_Body(body).content())


def _name(name: str) -> bytes:
    encoded = name.encode()
    return _NAME_LENGTH.pack(len(encoded)) + encoded


def _checksum(version: int, body: bytes) -> int:
    return zlib.crc32(body, zlib.crc32(_SIGNED.pack(MAGIC, version)))


class _Body:
    """A version 2 body, read from front to back."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def content(self) -> Content:
        profile = self._name()
        counter, count = _COUNTER_AND_SECTIONS.unpack(self._take(_COUNTER_AND_SECTIONS.size))
        sections = {self._name(): self._bytes(_DATA_LENGTH) for _ in range(count)}
        if len(sections) != count:
            raise NvmError("damaged: two sections have the same name")
        if self._at != len(self._data):
            raise NvmError("damaged: bytes after the last section")
        return Content(profile, counter, sections)

    def _name(self) -> str:
        try:
            return self._bytes(_NAME_LENGTH).decode()
        except UnicodeDecodeError as error:
            raise NvmError("damaged: a name is not UTF-8") from error

    def _bytes(self, length: struct.Struct) -> bytes:
        (size,) = length.unpack(self._take(length.size))
        return self._take(size)

    def _take(self, size: int) -> bytes:
        taken = self._data[self._at : self._at + size]
        if len(taken) != size:
            raise NvmError("damaged: it ends too early")
        self._at += size
        return taken
