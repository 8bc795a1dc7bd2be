"""Streams that a page watches: each keeps what came until the page's next turn, up to a limit."""

import json
import sys
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import chain
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
"""Interval of a page's turns while packets or bytes are watched, and while nothing fast is."""
TAKEN_S = 2 * FAST_S
"""Time between two takings of an axis's samples: a page draws 30 times a second."""
CARD_HZ, CARD_TAKEN_S = 60.0, 6 * FAST_S
"""Rate up to which extremes are for cards, of which a page has many; time between two takings of those."""
MOST_ITEMS, ITEM_BYTES = 2000, 512 * 1024
"""Maximum number of items that wait for a page's turn, and of their bytes."""
TAKEN_ITEMS = 300
"""Maximum number of them in one turn: words for so many take some 10 ms."""


class PageStream(Protocol):
    """Something that a page watches. ``turn_s``: time between the turns that it wants."""

    turn_s: float

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
    """Reader of the time and some fields of the binary layout, in the order in which they were asked for. It
    reads many samples at once: a page has thousands in a second."""

    def __init__(self, fields: Sequence[AxisField]) -> None:
        offsets = [0, *(field.offset for field in fields)]
        types = {0: "i64"} | {field.offset: field.type for field in fields}
        ordered = sorted(types)
        self._columns, self._places = len(offsets), [(types[offset], offset) for offset in ordered]
        places = [ordered.index(offset) for offset in offsets]
        self._arrange = None if places == list(range(len(ordered))) else itemgetter(*places)
        self._of_bytes: dict[int, Struct] = {}
        """Readers by the length of a sample."""

    def rows(self, samples: Sequence[bytes]) -> "array[float]":
        """Read samples of one length: of each the time in seconds and the fields."""
        size = len(samples[0])
        if (reader := self._of_bytes.get(size)) is None:
            reader = self._of_bytes[size] = struct_of(self._places, size)
        values: Iterable[tuple[float, ...]] = reader.iter_unpack(b"".join(samples))
        rows = array("d", chain.from_iterable(map(self._arrange, values) if self._arrange else values))
        rows[:: self._columns] = array("d", [at_ns / 1e9 for at_ns in rows[:: self._columns]])
        return rows


def rows_per_s(rate_Hz: float, points: int) -> float:
    """Rate at which rows come: extremes are two of each interval."""
    return rate_Hz if points == 1 else 2 * rate_Hz


class AxisSamples:
    """Samples of an axis. ``names``: of the fields that the page wants; ``points`` above 1: of each interval
    the extremes of so many looks."""

    def __init__(
        self,
        desk: Desk,
        source: Source,
        number: int,
        axis: str,
        names: Sequence[str],
        rate_Hz: float,
        points: int = 1,
    ) -> None:
        self.axis, self.rows_per_s = axis, rows_per_s(rate_Hz, points)
        known = desk.describe().devices
        fields: Mapping[str, AxisField] = known[axis].fields if axis in known else {}
        self._number, self._columns = number, len(names)
        self._samples: list[bytes] = []
        self._dropped, self._taking = 0, -1
        self.turn_s = CARD_TAKEN_S if points > 1 and rate_Hz <= CARD_HZ else TAKEN_S
        interval_ns = NS_PER_S / Fraction(str(rate_Hz)).limit_denominator(10**6)
        self._watch: Watch = desk.watch(
            source, Watched.SAMPLES, axis, self._samples.append, interval_ns=interval_ns, points=points
        )
        if wrong := [name for name in names if name not in fields]:  # the desk has refused what is no axis
            self._watch.close()
            there = ", ".join(fields)
            raise VerbRefused("no_parameter", f"{axis} has no field {wrong[0][:80]!r}; it has {there}")
        self._reader = FieldReader([fields[name] for name in names])

    def next_message(self, now_s: float) -> bytes | None:
        """Block of the rows of the last turns."""
        before, self._taking = self._taking, int(now_s / self.turn_s)  # of all watches at the same turn
        if before in (-1, self._taking):
            return None
        self._watch.flush()
        if not self._samples:
            return None
        rows = self._reader.rows(self._samples)
        if sys.byteorder == "big":
            rows.byteswap()
        block = samples_head(self._columns, self._number, self.lost, len(self._samples)) + rows.tobytes()
        self._samples.clear()
        return block

    def drop(self) -> None:
        self._watch.flush()
        self._dropped += len(self._samples)
        self._samples.clear()

    @property
    def lost(self) -> int:
        return self._dropped + self._watch.lost

    def close(self) -> None:
        self._watch.close()


class PassingItems:
    """Packets, frames or bytes as they pass. ``say`` makes of each what the page gets, on its turn;
    ``size``: about how many bytes one takes."""

    turn_s = FAST_S

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

    turn_s, lost = SLOW_S, 0

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


class BenchEvents:
    """Events of the bench: those that it keeps, then each as it happens, or as others join it."""

    turn_s = SLOW_S

    def __init__(self, desk: Desk, source: Source, number: int) -> None:
        told = desk.ask(source, "events", "", {})
        self._number, self.lost, self._told_lost = number, told["left_out"], -1
        self._waiting: dict[int, Mapping[str, Any]] = {row["number"]: row for row in told["events"]}
        self._watch = desk.watch(source, Watched.EVENTS, "", self._put)

    def _put(self, event: Mapping[str, Any]) -> None:
        self._waiting[event["number"]] = event
        if len(self._waiting) > MOST_ITEMS:
            del self._waiting[min(self._waiting)]
            self.lost += 1

    def next_message(self, now_s: float) -> str | None:
        items = list(self._waiting.values())[:TAKEN_ITEMS]
        if not items and self.lost == self._told_lost:
            return None
        for item in items:
            del self._waiting[item["number"]]
        self._told_lost = self.lost
        return json_text({"watch": self._number, "items": items, "lost": self.lost})

    def drop(self) -> None:
        """Nothing: what waits has its limit."""

    def close(self) -> None:
        self._watch.close()


class DoorClock:
    """Time of the loop, in ms. It is told while nothing else is new, too: a page knows by it how old is what
    it shows, and can say until when a request of it has to begin."""

    turn_s, lost = SLOW_S, 0

    def __init__(self, number: int, rate_Hz: float) -> None:
        self._number, self._interval_s, self._tick = number, 1 / rate_Hz, -1

    def next_message(self, now_s: float) -> str | None:
        before, self._tick = self._tick, int(now_s / self._interval_s)
        if before == self._tick:
            return None
        return json_text({"watch": self._number, "value": round(now_s * 1000, 1)})

    def drop(self) -> None:
        """Nothing: only the latest is told."""

    def close(self) -> None:
        """Nothing is held."""


class ToldReading:
    """Answer of an operation, read again and again for all pages together; told when it has changed."""

    turn_s, lost = SLOW_S, 0

    def __init__(self, reading: SharedReading, number: int, rate_Hz: float) -> None:
        self._reading, self._number, self._interval_s = reading, number, 1 / rate_Hz
        self._told, self._tick = 0, -1

    def next_message(self, now_s: float) -> LongText | None:
        tick = int(now_s / self._interval_s)
        if tick == self._tick or (found := self._reading.read(now_s)) is None:
            return None
        turn, parts = found
        if turn == self._told and self._reading.is_under_way:
            return None  # it is told on a turn soon
        self._tick = tick
        if turn == self._told:
            return None
        self._told = turn
        head = f'{{"watch":{json.dumps(self._number)},"value":'.encode()
        return LongText((head, *parts, b"}"), sum(map(len, parts)))

    def drop(self) -> None:
        """Nothing: only the latest is told."""

    def close(self) -> None:
        """Nothing is held."""
