"""Readings that all pages share: fifty pages cost the bench no more than one."""

from bridges.web.web_messages import dumped
from hil.vocab.desk_protocol import Desk, Source

SHORTEST_S = 0.2
"""Minimum time between two readings."""


class SharedReading:
    """Answer of an operation without a target, as JSON."""

    def __init__(self, desk: Desk, source: Source, operation: str) -> None:
        self._desk, self._source, self._operation = desk, source, operation
        self._read_at_s = float("-inf")
        self._turn, self._text = 0, ""

    def read(self, now_s: float) -> tuple[int, str]:
        """Answer, and a number that is another one when the answer is."""
        if now_s - self._read_at_s >= SHORTEST_S:
            self._read_at_s = now_s
            text = dumped(self._desk.ask(self._source, self._operation, "", {}))
            if text != self._text:
                self._turn, self._text = self._turn + 1, text
        return self._turn, self._text
