"""Streams that a page watches: each keeps what came until the page's next turn, up to a limit."""

import json
import sys
from array import array
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from operator import itemgetter
from struct import Struct
from typing import Any, Protocol

from bridges.web.outbox import LongText
from bridges.web.shared_reading import SharedReading
from bridges.web.web_messages import samples_head
from hil.vocab.desk_protocol import AxisField, Desk, Source, Watch, Watched
from hil.vocab.packed_fields import struct_of
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import json_text

FAST_S, SLOW_S = 1 / 60, 0.25
"""Interval of a page's turns while something fast is watched, and else."""
MOST_ITEMS, ITEM_BYTES = 2000, 512 * 1024
"""Maximum number of items that wait for a page's turn, and of their bytes."""
TAKEN_ITEMS = 300
"""Maximum number of them in one turn: words for so many take some 10 ms."""
_AT_NS = Struct("<q").unpack_from


class PageStream(Protocol):
    """Something that a page watches. ``is_fast``: it wants a turn each ``FAST_S``."""

    is_fast: bool

    def next_message(self, now_s: float) -> bytes | str | LongText | None:
        """Message with what came since the last turn; None: nothing did."""

    def drop(self) -> None:
        """Drop and count what came: the page does not read."""

    @property
    def lost(self) -> int:
        """Number of samples or items that the page never got."""

    def close(self) -> None:
        """End it."""


class FieldReader:
    """Reader of some fields of the binary layout, in the order in which they were asked for."""

    def __init__(self, fields: Sequence[AxisField]) -> None:
        ordered = sorted(dict.fromkeys(fields), key=lambda field: field.offset)
        places = [ordered.index(field) for field in fields]
        self._unpack = struct_of((field.type, field.offset) for field in ordered).unpack_from
        self._arrange: Callable[[tuple[float, ...]], tuple[float, ...]] | None
        self._arrange = None if places == list(range(len(ordered))) else _arrangement(places)

    def values(self, packed: bytes) -> tuple[float, ...]:
        """Values of one sample."""
        values = self._unpack(packed)
        return self._arrange(values) if self._arrange else values


def _arrangement(places: Sequence[int]) -> Callable[[tuple[float, ...]], tuple[float, ...]]:
    if len(places) == 1:
        return lambda values: (values[places[0]],)
    return itemgetter(*places)


class AxisSamples:
    """Samples of an axis. ``names``: of the fields that the page wants."""

    is_fast = True

    def __init__(
        self, desk: Desk, source: Source, number: int, axis: str, names: Sequence[str], rate_Hz: float
    ) -> None:
        self.axis, self.rate_Hz = axis, rate_Hz
        known = desk.describe().devices
        fields: Mapping[str, AxisField] = known[axis].fields if axis in known else {}
        self._number, self._columns = number, len(names)
        self._rows, self._dropped = array("d"), 0
        interval_ns = NS_PER_S / Fraction(str(rate_Hz)).limit_denominator(10**6)
        self._watch: Watch = desk.watch(source, Watched.SAMPLES, axis, self._put, interval_ns=interval_ns)
        if wrong := [name for name in names if name not in fields]:  # the desk has refused what is no axis
            self._watch.close()
            there = ", ".join(fields)
            raise VerbRefused("no_parameter", f"{axis} has no field {wrong[0][:80]!r}; it has {there}")
        self._values = FieldReader([fields[name] for name in names]).values

    def _put(self, packed: bytes) -> None:
        self._rows.append(_AT_NS(packed)[0] / 1e9)
        self._rows.extend(self._values(packed))

    def next_message(self, now_s: float) -> bytes | None:
        """Block of the rows since the last turn."""
        self._watch.flush()
        if not self._rows:
            return None
        rows = self._rows
        if sys.byteorder == "big":
            rows.byteswap()
        block = samples_head(self._columns, self._number, self.lost, len(rows) // (1 + self._columns))
        block += rows.tobytes()
        del rows[:]
        return block

    def drop(self) -> None:
        self._watch.flush()
        self._dropped += len(self._rows) // (1 + self._columns)
        del self._rows[:]

    @property
    def lost(self) -> int:
        return self._dropped + self._watch.lost

    def close(self) -> None:
        self._watch.close()


class PassingItems:
    """Packets, frames or bytes as they pass. ``say`` makes of each what the page gets, on its turn;
    ``size``: about how many bytes one takes."""

    is_fast = True

    def __init__(self, number: int, say: Callable[[Any], Sequence[Any]], size: Callable[[Any], int]) -> None:
        self._number, self._say, self._size = number, say, size
        self._waiting: deque[Any] = deque()
        self._bytes = 0
        self._told_lost = 0
        self.lost = 0
        self.watch: Watch | None = None

    def put(self, item: Any) -> None:
        """Let an item wait for the page's turn; where too much waits, the oldest goes."""
        self._waiting.append(item)
        self._bytes += self._size(item)
        while len(self._waiting) > MOST_ITEMS or (self._bytes > ITEM_BYTES and len(self._waiting) > 1):
            self._bytes -= self._size(self._waiting.popleft())
            self.lost += 1

    def next_message(self, now_s: float) -> str | None:
        said: list[Any] = []
        for _ in range(min(len(self._waiting), TAKEN_ITEMS)):
            item = self._waiting.popleft()
            self._bytes -= self._size(item)
            said += self._say(item)
        if not self._waiting:
            said += self._after_silence()
        if not said and self.lost == self._told_lost:
            return None
        self._told_lost = self.lost
        return json_text({"watch": self._number, "items": said, "lost": self.lost})

    def _after_silence(self) -> Sequence[Any]:
        """Message that tells the page that nothing has come since."""
        return ()

    def drop(self) -> None:
        """Nothing: what waits has its limits."""

    def close(self) -> None:
        if self.watch:
            self.watch.close()


class RunsProgress:
    """Progress of runs: of each its latest, so that none is lost."""

    is_fast, lost = False, 0

    def __init__(self, desk: Desk, source: Source, number: int) -> None:
        self._number = number
        self._latest: dict[str, Mapping[str, Any]] = {
            row["run"]: row for row in desk.ask(source, "runs", "", {})
        }
        self._watch = desk.watch(source, Watched.RUNS, "", self._put)

    def _put(self, progress: Mapping[str, Any]) -> None:
        self._latest[progress["run"]] = progress

    def next_message(self, now_s: float) -> str | None:
        if not self._latest:
            return None
        items = list(self._latest.values())
        self._latest.clear()
        return json_text({"watch": self._number, "items": items, "lost": 0})

    def drop(self) -> None:
        """Nothing: there are only so many runs."""

    def close(self) -> None:
        self._watch.close()


class ToldReading:
    """Answer of an operation, read again and again for all pages together; told when it has changed."""

    is_fast, lost = False, 0

    def __init__(self, reading: SharedReading, number: int, rate_Hz: float) -> None:
        self._reading, self._number, self._interval_s = reading, number, 1 / rate_Hz
        self._told, self._due_s = 0, 0.0

    def next_message(self, now_s: float) -> LongText | None:
        if now_s < self._due_s or (found := self._reading.read(now_s)) is None:
            return None
        self._due_s = now_s + self._interval_s - SLOW_S / 2  # turns come a little early or late
        turn, parts = found
        if turn == self._told:
            return None
        self._told = turn
        head = f'{{"watch":{json.dumps(self._number)},"value":'.encode()
        return LongText((head, *parts, b"}"), sum(map(len, parts)))

    def drop(self) -> None:
        """Nothing: only the latest is told."""

    def close(self) -> None:
        """Nothing is held."""
