"""Bytes that pass at a terminal, by lines: for people who look at a capture."""

import re
from collections.abc import Iterator

from hil.cli.decoded_item import DecodedItem, DecodedKind
from hil.wire.pcapng import Record, RecordKind

APART_NS = 100_000_000
"""Bytes that come so long after others are a line of their own. Of a bench at speed 20 they come in steps of
20 ms."""
LONGEST = 1024
"""Bytes after which a line is given, whatever follows."""
_CLIENT, _BOARD = "client", "board"
_LINE = re.compile(rb"[^\r\n]{0,%d}[\r\n]{1,%d}|[^\r\n]{1,%d}" % (LONGEST, LONGEST, LONGEST))


class TerminalLines:
    """Splitter of what passes at a port. A line ends behind CR and LF, where the other side begins, and where
    nothing follows for ``APART_NS``."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._raw = b""
        self._event = 0
        self._at_ns = self._last_ns = 0

    def take(self, record: Record) -> Iterator[DecodedItem]:
        """Take bytes of one side; answers the lines that are over."""
        if record.event != self._event:
            yield from self._end()
        self._event, self._last_ns = record.event, record.at_ns
        if not self._raw:
            self._at_ns = record.at_ns
        *over, self._raw = _LINE.findall(self._raw + record.data) or (b"",)
        for line in over:
            yield self._decoded(line)
            self._at_ns = record.at_ns

    def silent(self, now_ns: int) -> Iterator[DecodedItem]:
        """Note that nothing passes until now; answers the line that this ends."""
        if now_ns - self._last_ns >= APART_NS:
            yield from self._end()

    def _end(self) -> Iterator[DecodedItem]:
        raw, self._raw = self._raw, b""
        if raw:
            yield self._decoded(raw)

    def _decoded(self, raw: bytes) -> DecodedItem:
        sides = (_CLIENT, _BOARD) if self._event == RecordKind.TX else (_BOARD, _CLIENT)
        return DecodedItem(
            self._at_ns,
            self._name,
            DecodedKind.BYTES,
            lambda: f"{sides[0]} -> {sides[1]} {repr(raw)[1:]}",
            *sides,
            data=raw,
            stream=self,
        )
