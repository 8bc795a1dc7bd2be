"""Intel HEX: text of records, each a ":" and pairs of digits, to bytes at their addresses.

A record is its length, an address of 16 bits, a type, its data and a checksum. Types: 0 data, 1 the end, 2
and 4 where the addresses that follow count from, 3 and 5 where a program starts, which no AVR needs.

Source: Intel, Hexadecimal Object File Format Specification, revision A, 1988.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from hil.sketch.program_error import program_error

DATA, END, SEGMENT, START_SEGMENT, LINEAR, START_LINEAR = range(6)
_LENGTHS = {END: 0, SEGMENT: 2, START_SEGMENT: 4, LINEAR: 2, START_LINEAR: 4}
"""Number of data bytes of a record, by the types that have always the same."""
_HEAD_BYTES = 4
_FIRST_DATA_COLUMN = 2 + 2 * _HEAD_BYTES
"""Column of the first digit of a record's data; columns count from 1."""
_DIGITS = frozenset(b"0123456789abcdefABCDEF")
_BLANKS = b" \t\r"
_AGAIN = "build or copy the file again: it is damaged"
_64_K = 0x10000
_4_G = 1 << 32


class FilePiece(NamedTuple):
    """Bytes of a file that lie together. ``line`` and ``column``: place of the first, from 1 on; 0 in a
    binary file."""

    at: int
    data: bytes
    line: int = 0
    column: int = 0

    @property
    def end(self) -> int:
        return self.at + len(self.data)

    def place(self, address: int) -> tuple[int, int]:
        """Line and column of the byte at an address of the piece."""
        return (self.line, self.column + 2 * (address - self.at)) if self.line else (0, 0)


class _Record(NamedTuple):
    kind: int
    offset: int
    data: bytes


def read_hex(name: str, content: bytes) -> list[FilePiece]:
    """Read the bytes of a file, a piece for each record, by their addresses. ``name``: of the file, for the
    error.

    Raises:
        ProgramError: it is damaged.
    """
    return sorted(_pieces(name, content), key=lambda piece: (piece.at, piece.line))


def write_hex(pieces: Iterable[tuple[int, bytes]], record_bytes: int = 16) -> bytes:
    """Write bytes at their addresses, in records of at most so many."""
    lines, base = [], 0
    for at, data in pieces:
        start = 0
        while start < len(data):
            address = at + start
            if address >> 16 != base:
                base = address >> 16
                lines.append(_line(LINEAR, 0, base.to_bytes(2, "big")))
            room = min(record_bytes, _64_K - address % _64_K)
            lines.append(_line(DATA, address % _64_K, data[start : start + room]))
            start += room
    lines.append(_line(END, 0, b""))
    return b"".join(lines)


def _line(kind: int, offset: int, data: bytes) -> bytes:
    body = bytes((len(data),)) + offset.to_bytes(2, "big") + bytes((kind,)) + data
    return b":" + (body + bytes((_checksum(body),))).hex().upper().encode() + b"\n"


def _checksum(body: bytes) -> int:
    return -sum(body) & 0xFF


def _pieces(name: str, content: bytes) -> Iterator[FilePiece]:
    base, wraps, end_line, number = 0, True, 0, 0
    for number, text in enumerate(content.split(b"\n"), 1):
        line = text.rstrip(_BLANKS)
        if not line:
            continue
        if end_line:
            message = f"a line follows the record of the end, which is line {end_line}"
            raise program_error(name, message, "leave one program in the file", number, 1)
        record = _record(name, number, line)
        if record.kind == END:
            end_line = number
        elif record.kind in (SEGMENT, LINEAR):
            wraps = record.kind == SEGMENT
            base = int.from_bytes(record.data, "big") << (4 if wraps else 16)
        elif record.kind == DATA and record.data:
            yield from _placed(record, number, base, wraps=wraps)
    if not end_line:
        message = "the record of the end (:00000001FF) is missing, so the file may be cut"
        raise program_error(name, message, _AGAIN, number, 1)


def _placed(record: _Record, number: int, base: int, *, wraps: bool) -> Iterator[FilePiece]:
    """Place a record's data: addresses that count from a segment begin again after 64 kB."""
    size = _64_K if wraps else _4_G
    start = record.offset if wraps else base + record.offset
    origin = base if wraps else 0
    room = size - start
    for skipped, at, data in ((0, start, record.data[:room]), (room, 0, record.data[room:])):
        if data:
            yield FilePiece(origin + at, data, number, _FIRST_DATA_COLUMN + 2 * skipped)


def _record(name: str, number: int, line: bytes) -> _Record:
    if line[:1] != b":":
        message = "a record begins with a colon"
        remedy = "give an Intel HEX file, as avr-objcopy -O ihex makes it" if number == 1 else _AGAIN
        raise program_error(name, message, remedy, number, 1)
    digits = line[1:]
    for column, digit in enumerate(digits, 2):
        if digit not in _DIGITS:
            message = f"the byte {digit:#04x} is no hexadecimal digit"
            raise program_error(name, message, _AGAIN, number, column)
    length = int(digits[:2], 16) if len(digits) >= 2 else 0
    wanted = 2 * (_HEAD_BYTES + length + 1)
    if len(digits) != wanted:
        message = f"the record has {len(digits)} digits; for its length of {length} bytes it has {wanted}"
        raise program_error(name, message, _AGAIN, number, min(len(digits), wanted) + 2)
    body = bytes.fromhex(digits.decode("ascii"))
    if (said := body[-1]) != (made := _checksum(body[:-1])):
        message = f"the checksum is {said:02X}, and the record's bytes make {made:02X}"
        raise program_error(name, message, _AGAIN, number, wanted)
    kind = body[3]
    if kind > START_LINEAR:
        raise program_error(name, f"there is no record of type {kind:02X}", _AGAIN, number, 8)
    if length != _LENGTHS.get(kind, length):
        message = f"a record of type {kind:02X} has {_LENGTHS[kind]} bytes of data, not {length}"
        raise program_error(name, message, _AGAIN, number, 2)
    return _Record(kind, int.from_bytes(body[1:3], "big"), body[_HEAD_BYTES:-1])


def check_overlaps(name: str, pieces: Sequence[FilePiece]) -> None:
    """Check that pieces, in the order of their addresses, agree where they overlap.

    Raises:
        ProgramError: they do not.
    """
    known = FilePiece(0, b"")
    for piece in pieces:
        if piece.at < known.end:
            _compare(name, known, piece)
        if piece.end > known.end:
            known = piece


def _compare(name: str, one: FilePiece, other: FilePiece) -> None:
    first, later = sorted((one, other), key=lambda piece: (piece.line, piece.column))
    for address in range(other.at, min(one.end, other.end)):
        was, now = first.data[address - first.at], later.data[address - later.at]
        if was != now:
            place = f"here, and {was:02X} in line {first.line}" if first.line else f"and also {was:02X}"
            message = f"0x{address:04X} is {now:02X} {place}"
            raise program_error(name, message, "leave one program in the file", *later.place(address))
