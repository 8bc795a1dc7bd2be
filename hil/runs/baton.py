"""When each phrase of a run begins."""

from typing import Protocol

from hil.runs.axes import RunBench


class Baton(Protocol):
    """Says when each phrase begins. The one after the last is the end, which all axes reach together."""

    def start_ns(self, phrase: int) -> int | None:
        """In simulated time, still to come; None: it is not known yet. Asked when the phrases before it have
        ended here."""


class Soon:
    """A ``Baton`` of one bench alone: each phrase begins ``lead_ns`` after the last has ended."""

    def __init__(self, bench: RunBench, lead_ns: int) -> None:
        self._bench = bench
        self._lead_ns = lead_ns

    def start_ns(self, phrase: int) -> int:
        return self._bench.now_ns + self._lead_ns


class Told:
    """A ``Baton`` that others tell: ``starts_ns`` by phrase."""

    def __init__(self) -> None:
        self.starts_ns: dict[int, int] = {}

    def start_ns(self, phrase: int) -> int | None:
        return self.starts_ns.get(phrase)
