"""Framing of the command port: lines that CR ends. ``hil.vocab.framing.Framing``."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hil.vocab.framing import BurstItems, Item, Party, Transform
from hil.vocab.packet_field import Fields, PacketField
from hil.vocab.time import FOREVER, SimTimeNs

CR = 0x0D
_WORD = re.compile(rb"[^\s,;]+")
_LONGEST = 1024
"""Bytes after which a piece is given that no CR has ended; the firmware drops what is behind the 128th."""


@dataclass(frozen=True)
class EndedLine:
    """A line that has ended, with its CR; or a piece of one that does not end, which is no packet."""

    at_ns: int
    raw: bytes
    is_packet: bool = True
    fault: str = ""
    origin: int | None = None


class LineSplitter:
    """Splitter of what is typed into lines."""

    def __init__(self, held: bytes = b"") -> None:
        self._held = held

    def burst(self, data: bytes, start_ns: SimTimeNs, baud: int) -> BurstItems:
        *lines, self._held = (self._held + data).split(bytes((CR,)))
        items = [EndedLine(start_ns, line + bytes((CR,))) for line in lines]
        if len(self._held) >= _LONGEST:
            items.append(EndedLine(start_ns, self._held, is_packet=False))
            self._held = b""
        return BurstItems(items, None, False, FOREVER)

    def characters(self, data: bytes, times_ns: Sequence[int], baud: int) -> BurstItems:
        return self.burst(data, SimTimeNs(times_ns[0]) if times_ns else SimTimeNs(0), baud)

    def silence(self, now_ns: SimTimeNs) -> Sequence[Item]:
        return ()

    @property
    def pending(self) -> bytes:
        return self._held

    def copy(self) -> "LineSplitter":
        return LineSplitter(self._held)


class LineFraming:
    """Lines without addresses, checksums or faults of their own."""

    name = "walter"
    faults: tuple[str, ...] = ()
    has_ends = True

    def splitter(self) -> LineSplitter:
        return LineSplitter()

    def ends(self, data: bytes, before: bytes | None) -> list[int]:
        return [place for place, byte in enumerate(data) if byte == CR]

    def may_end(self, data: bytes) -> bool:
        return CR in data

    def text(self, item: Item) -> str:
        return item.raw.decode("latin-1").rstrip("\r")

    def fields(self, item: Item) -> Fields:
        """Fields of a line: its words, and the CR that ends it."""
        ended = item.raw[-1:] == bytes((CR,))
        line = item.raw[:-1] if ended else item.raw
        fields = [PacketField("line", line.decode("latin-1"), 0, len(line))]
        for number, word in enumerate(_WORD.finditer(line)):
            name = f"argument {number}" if number else "command"
            fields.append(PacketField(name, word[0].decode("latin-1"), *word.span(), 1))
        return [*fields, PacketField("CR", "the end", len(line), len(line) + 1)] if ended else fields

    def parties(self, item: Item) -> tuple[Party, Party]:
        return None, None

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        raise ValueError(f"lines have no fault {kind}")

    def answers(self, burst: bytes, address: int) -> Iterable[tuple[int, bytes]]:
        return ()


LINES = LineFraming()
