"""Packets of a line in words, by its framing, as a page shows them."""

from collections.abc import Iterable, Sequence
from typing import Any

from hil.vocab.framing import Item, Splitter
from hil.vocab.segment import SegmentEvent, SegmentView
from hil.vocab.time import FOREVER, SimTimeNs

LINE_BAUD = 38400
"""Speed of a line without a station."""


class PacketWords:
    """Packets of a line in words, by its framing. Events come in their order."""

    def __init__(self, line: SegmentView) -> None:
        self._line = line
        self._splitter: Splitter = line.framing.splitter()
        self._over_ns = FOREVER
        self._by = ""
        self._begun_ns = 0
        """Time at which what is held began."""
        self._is_open = False
        """True if something is held and nobody was told."""

    def say(self, event: SegmentEvent) -> Sequence[dict[str, Any]]:
        """Packets that an event completes, or what was wrong on the line."""
        before = self.silence(event.at_ns)
        self._is_open = True
        if event.is_damaged:
            return [*before, self._item(event.at_ns, event.data, event.about, error=event.about or "damaged")]
        was_held = bool(self._splitter.pending)
        found = self._splitter.burst(event.data, event.at_ns, self._line.baud or LINE_BAUD)
        self._over_ns, self._by = found.over_ns, event.about
        if found.items or not was_held:
            self._begun_ns = event.at_ns
        return [*before, *self._packets(found.items)]

    def silence(self, now_ns: int) -> Sequence[dict[str, Any]]:
        """Packets that the silence until now completes."""
        if now_ns < self._over_ns:
            return []
        self._over_ns = FOREVER
        return self._packets(self._splitter.silence(SimTimeNs(now_ns)))

    def unfinished(self, now_ns: int) -> Sequence[dict[str, Any]]:
        """Bytes on the line that are no packet yet, told once. They may go on: only in some framings
        does silence end a packet."""
        data = self._splitter.pending
        if not self._is_open or not data or now_ns < self._begun_ns:
            return []
        self._is_open = False
        item = self._item(self._begun_ns, data, "unfinished", error="unfinished", by=self._by)
        return [{**item, "is_unfinished": True}]

    def start_again(self) -> None:
        """Forget what was heard in part: something in between was lost."""
        self._splitter, self._over_ns = self._line.framing.splitter(), FOREVER

    def _packets(self, items: Iterable[Item]) -> list[dict[str, Any]]:
        framing = self._line.framing
        told = []
        for item in items:
            origin, destination = framing.parties(item)
            text, error = framing.text(item), item.fault or None
            told.append(self._item(item.at_ns, item.raw, text, origin, destination, error, self._by))
        return told

    def _item(
        self,
        at_ns: int,
        data: bytes,
        text: str,
        origin: int | str | None = None,
        destination: int | str | None = None,
        error: str | None = None,
        by: str = "",
    ) -> dict[str, Any]:
        bits = len(data) * self._line.line_format.bits
        return {
            "at_s": at_ns / 1e9,
            "from": origin,
            "to": destination,
            "by": by,
            "hex": data.hex(),
            "text": text,
            "error": error,
            "duration_s": bits / (self._line.baud or LINE_BAUD),
        }
