"""ELF files of avr-gcc: what is loaded, where, and the symbols.

A reader of its own: headers, segments and one table of symbols are all that is wanted, and each error has to
say what the file is not.

Source: Tool Interface Standard, Executable and Linking Format (ELF) Specification, version 1.2, 1995; GNU
binutils, include/elf/avr.h (flags, the note of the device).
"""

import struct
from collections.abc import Iterator
from typing import NamedTuple, NoReturn

from hil.sketch.intel_hex import FilePiece
from hil.sketch.program_error import program_error

MAGIC = b"\x7fELF"
AVR = 83
"""Number of the machine, EM_AVR."""
_CLASS_32, _LITTLE_ENDIAN, _EXECUTABLE = 1, 1, 2
_MACHINES = {
    3: "Arm",
    8: "MIPS",
    40: "Arm",
    62: "x86-64",
    94: "Xtensa",
    105: "MSP430",
    183: "Arm",
    243: "RISC-V",
}
"""Other machines that people build for, by their numbers."""

_HEADER = struct.Struct("<16x HHIIIIIHHHHHH")
_SEGMENT = struct.Struct("<8I")
_SECTION = struct.Struct("<10I")
_SYMBOL = struct.Struct("<IIIBBH")
_NOTE = struct.Struct("<III4s")
_DEVICE = struct.Struct("<7I")
_LOADED, _SYMBOLS, _NO_BYTES, _ALLOCATED = 1, 2, 8, 2
_NOWHERE, _ABSOLUTE = 0, 0xFFF1
_KINDS = {0: "", 1: "object", 2: "function"}
_ARCHITECTURE = 0x7F
_DEVICE_NOTE = ".note.gnu.avr.deviceinfo"
_CUT = "build or copy the file again: it is cut or damaged"
_MOST_SECTIONS = 4096
_MOST_NAME_BYTES = 256
"""Length from which on a name is cut."""


class Symbol(NamedTuple):
    """Name in a program. ``address``: as avr-gcc has it, RAM from 800000h on; ``kind``: "function", "object",
    or empty for one of the linker's or of assembler's."""

    name: str
    address: int
    size: int
    kind: str


class Section(NamedTuple):
    """Section of a file that is in the processor's memory. ``is_stored``: its bytes are in the file."""

    name: str
    address: int
    size: int
    is_stored: bool


class ElfFile(NamedTuple):
    """Content of a file. ``pieces``: what is loaded, at the addresses where it is kept without power;
    ``architecture``: 5 for avr5; ``device``: as avr-gcc has it, as atmega328p, empty where the file does not
    say; ``symbols``: empty for a file that was stripped."""

    pieces: list[FilePiece]
    sections: list[Section]
    symbols: list[Symbol]
    architecture: int
    device: str


class _Header(NamedTuple):
    kind: int
    name: int
    flags: int
    address: int
    offset: int
    size: int
    link: int


def read_elf(name: str, content: bytes) -> ElfFile:
    """Read a file for an AVR. ``name``: of the file, for the error.

    Raises:
        ProgramError: it is no executable for an AVR, or damaged.
    """
    return _Reader(name, content).read()


class _Reader:
    def __init__(self, name: str, content: bytes) -> None:
        self._name, self._content = name, content

    def read(self) -> ElfFile:
        content = self._content
        if content[:4] != MAGIC:
            self._refuse("it is no ELF file", "give the .elf that avr-gcc links")
        if len(content) < _HEADER.size:
            self._cut("the header", 0, _HEADER.size)
        if content[4] != _CLASS_32 or content[5] != _LITTLE_ENDIAN:
            bits = "64" if content[4] == 2 else "32"
            order = "big" if content[5] == 2 else "little"
            self._refuse(
                f"it is an ELF file of {bits} bits, {order} endian; an AVR's has 32 bits, little endian"
            )
        kind, machine, _, _, segments_at, sections_at, flags, _, _, segments, _, sections, _ = (
            _HEADER.unpack_from(content)
        )
        if machine != AVR:
            other = _MACHINES.get(machine)
            self._refuse(f"it is built for {other or f'machine {machine}'}, not for an AVR")
        if kind != _EXECUTABLE:
            self._refuse(
                "it is no executable: it is not linked", "give the .elf that avr-gcc links, no .o or .a"
            )
        headers = self._sections(sections_at, min(sections, _MOST_SECTIONS))
        names = self._names(headers, _HEADER.unpack_from(content)[-1])
        return ElfFile(
            pieces=list(self._pieces(segments_at, segments)),
            sections=[
                Section(each, header.address, header.size, header.kind != _NO_BYTES)
                for each, header in zip(names, headers, strict=True)
                if header.flags & _ALLOCATED and header.size
            ],
            symbols=self._symbols(headers),
            architecture=flags & _ARCHITECTURE,
            device=self._device(headers, names),
        )

    def _refuse(self, message: str, remedy: str = "build it with -mmcu=atmega328p") -> NoReturn:
        raise program_error(self._name, message, remedy)

    def _cut(self, what: str, start: int, end: int) -> NoReturn:
        message = f"{what} is at byte {start} to {end - 1}, and the file has {len(self._content)}"
        self._refuse(message, _CUT)

    def _bytes(self, what: str, start: int, size: int) -> bytes:
        if start + size > len(self._content):
            self._cut(what, start, start + size)
        return self._content[start : start + size]

    def _pieces(self, start: int, number: int) -> Iterator[FilePiece]:
        table = self._bytes("the table of segments", start, number * _SEGMENT.size)
        left = len(self._content)
        for kind, offset, _, kept_at, size, *_ in _SEGMENT.iter_unpack(table):
            if kind == _LOADED and size:
                left -= size
                if left < 0:
                    self._refuse("its segments have more bytes than the file", _CUT)
                yield FilePiece(kept_at, self._bytes("a segment", offset, size))

    def _sections(self, start: int, number: int) -> list[_Header]:
        table = self._bytes("the table of sections", start, number * _SECTION.size)
        return [
            _Header(kind, name, flags, address, offset, size, link)
            for name, kind, flags, address, offset, size, link, *_ in _SECTION.iter_unpack(table)
        ]

    def _names(self, headers: list[_Header], index: int) -> list[str]:
        if index >= len(headers):
            return [""] * len(headers)
        strings = self._content_of(headers[index])
        return [_text(strings, header.name) for header in headers]

    def _content_of(self, header: _Header) -> bytes:
        return b"" if header.kind == _NO_BYTES else self._bytes("a section", header.offset, header.size)

    def _symbols(self, headers: list[_Header]) -> list[Symbol]:
        table = next((header for header in headers if header.kind == _SYMBOLS), None)
        if table is None or table.link >= len(headers):
            return []
        packed, strings = self._content_of(table), self._content_of(headers[table.link])
        rows = _SYMBOL.iter_unpack(packed[: len(packed) // _SYMBOL.size * _SYMBOL.size])
        found = []
        for name_at, address, size, info, _, section in rows:
            binding, kind, name = info >> 4, _KINDS.get(info & 0xF), _text(strings, name_at)
            is_constant = section == _ABSOLUTE and not binding  # as __SP_L__, a register
            if kind is not None and section != _NOWHERE and name and name[0] != "." and not is_constant:
                found.append(Symbol(name, address, size, kind))
        return sorted(found, key=lambda symbol: (symbol.address, symbol.name))

    def _device(self, headers: list[_Header], names: list[str]) -> str:
        """Name of the device that it was linked for; empty where the file does not say."""
        if _DEVICE_NOTE not in names:
            return ""
        note = self._content_of(headers[names.index(_DEVICE_NOTE)])
        if len(note) < _NOTE.size + _DEVICE.size:
            return ""
        rest = _NOTE.size + _DEVICE.size
        table_bytes: int = _DEVICE.unpack_from(note, _NOTE.size)[-1]
        strings = note[rest + table_bytes - 4 :]
        return _text(strings, struct.unpack_from("<I", note, rest)[0]) if len(note) >= rest + 4 else ""


def _text(strings: bytes, start: int) -> str:
    end = strings.find(b"\0", start, start + _MOST_NAME_BYTES)
    return strings[start : end if end >= 0 else start + _MOST_NAME_BYTES].decode("ascii", "replace")
