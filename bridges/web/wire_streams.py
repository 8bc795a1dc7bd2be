"""Packets of segments, frames of CAN buses and bytes at ports, as a page gets them."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import islice
from typing import Any, NamedTuple

from bridges.web.streams import PassingItems
from hil.vocab.desk_protocol import Desk, Source, Watched
from hil.vocab.segment import SegmentEvent
from hil.vocab.verbs import VerbRefused
from hil.wire.packet_words import PacketWords
from hil.wire.pcapng import Interface, RecordKind, frame_record, header, record

KEPT_EVENTS, KEPT_BYTES = 10_000, 2 << 20
"""Maximum of what is kept of a segment for captures: so many events, and bytes of them."""
RECORDED_EVENTS = 100
"""Events that are encoded at a time: some 2 ms."""
SETTLED_NS = 100_000_000
"""Time after which a silence is one: what was on a line is told a little later than it was."""
_EVENT_BYTES = 64


def _size(event: SegmentEvent) -> int:
    return _EVENT_BYTES + len(event.data)


class WireRecord:
    """Last events of a segment or a bus, kept for captures while pages watch it, for all of them together."""

    def __init__(
        self, desk: Desk, source: Source, what: Watched, name: str, size: Callable[[Any], int]
    ) -> None:
        self._kept: deque[Any] = deque()
        self._size, self._bytes = size, 0
        self.heard = 0
        """Number of events so far."""
        self.pages = 0
        self._watch = desk.watch(source, what, name, self._hear)

    def _hear(self, event: Any) -> None:
        self.heard += 1
        self._kept.append(event)
        self._bytes += self._size(event)
        while len(self._kept) > KEPT_EVENTS or self._bytes > KEPT_BYTES:
            self._bytes -= self._size(self._kept.popleft())

    def since(self, heard: int) -> Sequence[Any]:
        """Events behind the first so many, as far as they are kept."""
        gone = self.heard - len(self._kept)
        return tuple(islice(self._kept, max(heard - gone, 0), None))

    def close(self) -> None:
        self._watch.close()


Records = dict[tuple[Watched, str], WireRecord]
"""Records of what is watched now, for all pages."""


class RecordedItems(PassingItems, ABC):
    """Packets or frames of a segment or a bus, which can be captured."""

    def __init__(
        self,
        desk: Desk,
        source: Source,
        number: int,
        place: tuple[Watched, str],
        say: Callable[[Any], Sequence[Any]],
        size: Callable[[Any], int],
        records: Records,
    ) -> None:
        super().__init__(number, say, size)
        self._clock = desk.describe().clock
        self.watch = desk.watch(source, *place, self.put)
        if place not in records:
            records[place] = WireRecord(desk, source, *place, size)
        self._place, self._records, self._record = place, records, records[place]
        self._record.pages += 1
        self._since = self._record.heard

    def close(self) -> None:
        super().close()
        self._record.pages -= 1
        if not self._record.pages:
            self._record.close()
            del self._records[self._place]

    def capture(self, program: str) -> "Captured":
        """Items of the wire that have passed, for a capture."""
        head = header(program, [self._interface()])
        return Captured(head, self._recorder(), self._record.since(self._since), self._clock.wall_ns(0))

    @abstractmethod
    def _interface(self) -> Interface:
        """Name the wire for a capture."""

    @abstractmethod
    def _recorder(self) -> Callable[[Any, int], bytes]:
        """Encoder of an event for a capture; it is told when simulated time began."""


class Captured:
    """Events for a capture, apart from those who watch."""

    def __init__(
        self, head: bytes, recorded: Callable[[Any, int], bytes], events: Sequence[Any], epoch_ns: int
    ) -> None:
        self._head, self._recorded, self._events, self._epoch_ns = head, recorded, events, epoch_ns

    def __len__(self) -> int:
        return len(self._events)

    def pcapng(self) -> Iterator[bytes]:
        """Encode as pcapng, some events at a time."""
        yield self._head
        for at in range(0, len(self._events), RECORDED_EVENTS):
            some = self._events[at : at + RECORDED_EVENTS]
            yield b"".join(self._recorded(event, self._epoch_ns) for event in some)


class LinePackets(RecordedItems):
    """Packets of a segment."""

    def __init__(self, desk: Desk, source: Source, number: int, segment: str, records: Records) -> None:
        here = desk.describe()
        if segment not in here.segments:
            known = ", ".join(here.segments) or "none"
            raise VerbRefused("no_place", f"there is no segment {segment[:80]!r}; there are {known}")
        self._line, self._name = here.segments[segment], segment
        self._words = PacketWords(self._line)
        place = Watched.PACKETS, segment
        super().__init__(desk, source, number, place, self._words.say, _size, records)
        self._heard_lost = 0

    def next_message(self, now_s: float) -> str | None:
        if self.lost != self._heard_lost:
            self._heard_lost = self.lost
            self._words.start_again()
        return super().next_message(now_s)

    def _after_silence(self) -> Sequence[Any]:
        now_ns = self._clock.times_ns()[0] - SETTLED_NS
        return [*self._words.silence(now_ns), *self._words.unfinished(now_ns)]

    def _interface(self) -> Interface:
        return Interface(self._name, self._line.framing.name, self._line.baud, self._line.line_format)

    def _recorder(self) -> Callable[[SegmentEvent, int], bytes]:
        return _packet_record


def _packet_record(event: SegmentEvent, epoch_ns: int) -> bytes:
    kind = RecordKind.FRAMING_ERROR if event.is_damaged else RecordKind.RX
    return record(0, epoch_ns + event.at_ns, kind, event.data, event.about)


class SameErrors(NamedTuple):
    """Error that came several times with nothing between: ``first``, and the end of the last."""

    first: Any
    times: int
    at_ns: int


class BusFrames(RecordedItems):
    """Frames, errors and nodes' states on a CAN bus. An error that comes again and again, as where nobody
    acknowledges a node, is one item of a turn: there may be thousands in a second."""

    def __init__(self, desk: Desk, source: Source, number: int, bus: str, records: Records) -> None:
        here = desk.describe()
        if bus in here.segments:
            raise VerbRefused("no_place", f"{bus} is a segment, and no CAN bus")
        self._frames, self._name = here.buses.get(bus), bus
        words = self._frames.words() if self._frames else dict  # the desk refuses a bus that is not there
        place = Watched.FRAMES, bus
        super().__init__(
            desk, source, number, place, partial(_said, words), lambda event: _EVENT_BYTES, records
        )

    def put(self, item: Any) -> None:
        last = self._waiting[-1] if self._waiting else None
        first, times = (last.first, last.times) if isinstance(last, SameErrors) else (last, 1)
        error = getattr(item, "error", "")
        if error and first and (first.node, getattr(first, "error", "")) == (item.node, error):
            self._waiting[-1] = SameErrors(first, times + 1, item.at_ns)
        else:
            super().put(item)

    def _interface(self) -> Interface:
        assert self._frames
        return Interface(self._name, self._frames.name, link=self._frames.link)

    def _recorder(self) -> Callable[[Any, int], bytes]:
        assert self._frames
        return partial(_frame_record, self._frames.packed)


def _said(words: Callable[[Any], Mapping[str, Any]], item: Any) -> Sequence[Mapping[str, Any]]:
    if not isinstance(item, SameErrors):
        return (words(item),)
    said, first, times = words(item.first), item.first, item.times
    duration_s = (item.at_ns - first.start_ns) / 1e9
    return ({**said, "text": f"{said['text']}, {times} times", "times": times, "duration_s": duration_s},)


def _frame_record(pack: Callable[[Any], bytes], event: Any, epoch_ns: int) -> bytes:
    return frame_record(0, epoch_ns + event.at_ns, pack(event), event.node)


class PortBytes(PassingItems):
    """Bytes at a port."""

    def __init__(self, desk: Desk, source: Source, number: int, port: str) -> None:
        self._clock = desk.describe().clock
        super().__init__(number, lambda item: (item,), lambda item: _EVENT_BYTES + len(item["hex"]))
        self.watch = desk.watch(source, Watched.BYTES, port, self._passed)

    def _passed(self, towards: str, data: bytes) -> None:
        at_ns, _ = self._clock.times_ns()
        self.put({"at_s": at_ns / 1e9, "to": towards, "hex": data.hex()})
