"""Items of a capture, in words and for programs: packets, frames, bytes and events, each a line."""

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hil.vocab.framing import Party
from hil.vocab.packet_field import Fields
from hil.vocab.shown_text import printable
from hil.wire.packet_fields import field_lines

KEYS: dict[str, str] = {
    "at_ns": "when it began, in nanoseconds since 1970; in logs as their writer counted",
    "time_s": "seconds since the first of them",
    "source": "the segment, CAN bus, node, tap or port",
    "kind": "`packet`, `frame` (of CAN), `bytes` (at a terminal, or that are no packet), or `event`:"
    " what was wrong on a line or a bus, or what the capture has lost",
    "from": "the sender's address, a CAN node's name, `client` or `board`; null: nobody says",
    "to": 'the receiver\'s address, "all", `client` or `board`; null: nobody says',
    "text": "the line for people, without time and source",
    "error": "what is wrong with it; null: nothing is",
    "data": "its bytes, as hexadecimal digits; of a frame those behind its identifier",
    "can_id": "the identifier of a frame; null of all else",
}
"""Keys of the JSON object of an item, with their meanings."""
_RED, _PLAIN = "\x1b[31m", "\x1b[0m"


class DecodedKind(StrEnum):
    """Kinds of items."""

    PACKET = "packet"
    FRAME = "frame"
    BYTES = "bytes"
    EVENT = "event"


@dataclass(frozen=True)
class DecodedItem:
    """Packet, frame, line of bytes, or event. ``say`` makes its words, in the items' order, where they are
    wanted at all."""

    at_ns: int
    source: str
    kind: DecodedKind
    say: Callable[[], str]
    origin: Party = None
    destination: Party = None
    error: str = ""
    data: bytes = b""
    can_id: int | None = None
    fields: Callable[[], Fields] = tuple
    """Makes its fields, behind ``say``."""
    stream: Hashable = None
    """Key of the sequence that ``data`` is a part of: the splitter of its bytes, or this record itself."""

    def line(self, first_ns: int, *, colours: bool = False) -> str:
        """Format for people: seconds since ``first_ns``, source, words; with an error in red."""
        line = printable(f"{(self.at_ns - first_ns) / 1e9:12.6f} {self.source} {self.say()}")
        return f"{_RED}{line}{_PLAIN}" if colours and self.error else line

    def field_lines(self) -> list[str]:
        """Format its fields for people, after ``line``."""
        return [printable(line) for line in field_lines(self.fields())]

    def as_dict(self, first_ns: int, *, with_fields: bool = False) -> dict[str, Any]:
        """The same for JSON, as in ``KEYS``."""
        values = (
            self.at_ns,
            round((self.at_ns - first_ns) / 1e9, 9),
            self.source,
            str(self.kind),
            self.origin,
            self.destination,
            self.say(),
            self.error or None,
            self.data.hex(),
            self.can_id,
        )
        row: dict[str, Any] = dict(zip(KEYS, values, strict=True))
        return row | {"fields": [field.row() for field in self.fields()]} if with_fields else row


def as_lines(items: Iterable[DecodedItem]) -> Iterator[str]:
    """Format items whose first one is where time begins."""
    first_ns: int | None = None
    for item in items:
        first_ns = item.at_ns if first_ns is None else first_ns
        yield item.line(first_ns)
