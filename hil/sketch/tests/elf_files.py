"""ELF files for tests, made byte by byte."""

import struct
from collections.abc import Sequence

SEGMENT, SECTION, SYMBOL = struct.Struct("<8I"), struct.Struct("<10I"), struct.Struct("<IIIBBH")
HEADER_BYTES = 52


def elf_file(
    segments: Sequence[tuple[int, bytes]],
    symbols: Sequence[tuple[str, int, int, int]] = (),
    *,
    machine: int = 83,
    flags: int = 5,
    kind: int = 2,
    word_class: int = 1,
    device: str = "",
) -> bytes:
    """Make a file. ``segments``: addresses and bytes; ``symbols``: name, address, size, type."""
    strings = b"\0" + b"".join(name.encode() + b"\0" for name, *_ in symbols)
    starts = [1 + sum(len(name) + 1 for name, *_ in symbols[:index]) for index in range(len(symbols))]
    table = SYMBOL.pack(0, 0, 0, 0, 0, 0) + b"".join(
        SYMBOL.pack(start, address, size, 0x10 | type_, 0, 1)
        for start, (_, address, size, type_) in zip(starts, symbols, strict=True)
    )
    note = b""
    if device:
        names = b"\0" + device.encode() + b"\0"
        rows = struct.pack("<8I", 0, 32768, 0x100, 2048, 0, 1024, 8, 1) + names
        note = struct.pack("<III4s", 4, len(rows), 1, b"AVR\0") + rows
    section_names = b"\0.symtab\0.strtab\0.shstrtab\0.note.gnu.avr.deviceinfo\0"
    bodies = [*(data for _, data in segments), table, strings, section_names, note]
    first = HEADER_BYTES + SEGMENT.size * len(segments)
    places = [first + sum(map(len, bodies[:index])) for index in range(len(bodies))]
    rows = [
        (0,) * 10,
        *(
            (section_names.index(name), type_, 0, 0, place, len(body), link, 0, 0, 0)
            for name, type_, link, place, body in zip(
                (b".symtab", b".strtab", b".shstrtab", b".note.gnu"),
                (2, 3, 3, 7),
                (2, 0, 0, 0),
                places[-4:],
                bodies[-4:],
                strict=True,
            )
        ),
    ]
    head = b"\x7fELF" + bytes((word_class, 1, 1)) + bytes(9)
    head += struct.pack(
        "<HHIIIIIHHHHHH",
        *(kind, machine, 1, 0, HEADER_BYTES, places[-1] + len(note), flags, HEADER_BYTES),
        *(SEGMENT.size, len(segments), SECTION.size, len(rows), 3),
    )
    loads = (
        SEGMENT.pack(1, place, address, address, len(data), len(data), 5, 1)
        for place, (address, data) in zip(places, segments, strict=False)
    )
    return b"".join((head, *loads, *bodies, *(SECTION.pack(*row) for row in rows)))
