"""Captures in words: each packet by the framing that the capture names, each frame of a bus as
that says it, bytes of a terminal by lines."""

import re
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from hil.compose.decoded_item import DecodedItem, DecodedKind
from hil.compose.find import find_catalogue
from hil.compose.framings import in_format
from hil.discovery.named_kinds import find_logs
from hil.vocab.bus import FrameDescription, LoggedFrame, LogKind
from hil.vocab.framing import Framing, Item, Party, Splitter
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.bytes_framing import BYTES, shown_bytes
from hil.wire.outside_text import LeftOut
from hil.wire.packet_fields import fields_of
from hil.wire.pcapng import EVENT_NAMES, LINKTYPES_USER, RAW, CaptureError, Interface, Record, RecordKind
from hil.wire.serial_line import character_ns

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

    def feed(self, record: Record) -> Iterator[DecodedItem]:
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


LINE_BAUD = 38400
"""Speed of a line whose capture does not say it."""


class LineChoice(NamedTuple):
    """Framing and speed of the lines that do not say theirs."""

    framing: str = ""
    line_format: LineFormat = EIGHT_N_1
    baud: int = LINE_BAUD


class _Line:
    """Packets of one direction of an interface, or of both."""

    def __init__(self, line: Interface, choice: LineChoice, left_out: LeftOut) -> None:
        framings = find_catalogue().framings
        name, line_format = line.framing, line.line_format
        if choice.framing and name in ("", BYTES.name):
            name, line_format = choice.framing, choice.line_format
        if name and name not in framings:
            left_out.note(f"{line.name} says {name!r}, which is no framing here: shown as bytes (--framing)")
        self._name = line.name
        self._baud = line.baud or choice.baud
        self._framing: Framing = in_format(framings.get(name) or BYTES, line_format)
        self._splitter: Splitter = self._framing.splitter()
        self._kind = DecodedKind.BYTES if self._framing is BYTES else DecodedKind.PACKET
        self._begun_ns = self._last_ns = 0
        """Times at which what is held began, and the last bytes ended."""
        self._sender = 0, ""
        """Direction and sender of what came last, as far as the capture says it."""
        self.has_ends = self._framing.has_ends

    def packets(self, record: Record) -> Iterator[DecodedItem]:
        data, at_ns = record.data, record.at_ns
        if self._kind is DecodedKind.BYTES and (record.event, record.comment) != self._sender:
            yield from self.silent(FOREVER)  # only who sends says where bytes belong together
            self._sender = record.event, record.comment
        was_held = bool(self._splitter.pending)
        items = self._splitter.burst(data, SimTimeNs(at_ns), self._baud).items
        if items or not was_held:
            self._begun_ns = at_ns
        self._last_ns = at_ns + character_ns(len(data), self._baud)
        yield from map(self._decoded, items)

    def silent(self, now_ns: int) -> Iterator[DecodedItem]:
        """Give what the silence until now completes; behind a long one nothing goes on, and what is held is
        no packet."""
        yield from map(self._decoded, self._splitter.silence(SimTimeNs(now_ns)))
        if now_ns - self._last_ns >= APART_NS and (raw := self._splitter.pending):
            self._splitter = self._framing.splitter()
            yield DecodedItem(
                self._begun_ns,
                self._name,
                DecodedKind.BYTES,
                lambda: f"no packet: {shown_bytes(raw)}",
                error="no packet",
                data=raw,
                stream=self,
            )

    def _decoded(self, item: Item) -> DecodedItem:
        origin, destination = self._framing.parties(item)
        _, sender = self._sender
        if sender:
            return self._item(item, sender, None, f"{sender}: ")
        return self._item(item, origin, destination)

    def _item(self, item: Item, origin: Party, destination: Party, by: str = "") -> DecodedItem:
        return DecodedItem(
            item.at_ns,
            self._name,
            self._kind,
            lambda: f"{by}{self._framing.text(item)}",
            origin,
            destination,
            item.fault,
            item.raw,
            fields=lambda: fields_of(self._framing, item),
            stream=self,
        )


class _Frames:
    """Frames of one kind in a capture, those of each wire in words of their own."""

    def __init__(self, kind: LogKind, names: Any) -> None:
        self.kind, self._names = kind, names
        self._words: dict[str, Callable[[Any], FrameDescription]] = {}

    def decoded(
        self, at_ns: int, wire: str, frame: Any, comment: str = "", record: Record | None = None
    ) -> DecodedItem:
        """Decode a frame; ``comment``: who sent it; ``record``: which this is."""
        words = self._words.get(wire) or self._words.setdefault(wire, self.kind.words(self._names))
        text = words(frame)
        by = f" ({comment})" if comment else ""
        return DecodedItem(
            at_ns,
            wire,
            DecodedKind.EVENT if text.error else DecodedKind.FRAME,
            lambda: f"{text.say()}{by}".rstrip(),
            comment or None,
            error=text.error,
            data=text.data,
            can_id=text.number,
            fields=text.fields,
            stream=record,
        )


class Decoder:
    """Decoder of one capture, whose records come in their order. ``names``: what ``LogKind.names`` has read;
    ``choice``: what lines are that do not say it."""

    def __init__(self, names: Mapping[LogKind, Any] | None = None, choice: LineChoice | None = None) -> None:
        self._choice = choice or LineChoice()
        self._lines: dict[tuple[Interface, int], _Line] = {}
        self._terminals: dict[Interface, TerminalLines] = {}
        self._frames = {kind: _Frames(kind, (names or {}).get(kind)) for kind in find_logs()}
        self.first_ns: int | None = None
        """Time of the first record; None: there was none."""
        self.lost = 0
        """Number of records that were lost while it was captured."""
        self.left_out = LeftOut()
        """Tally of what was left out of it, by who reads it and here."""

    def feed(self, record: Record) -> Iterator[DecodedItem]:
        """Take a record; answers what it completes."""
        self._begin(record.at_ns)
        self.lost += record.lost
        yield from self._silent(record.at_ns)
        if frames := self._frames_of(record.line):
            yield from self._frame(record, frames)
        elif record.line.link in LINKTYPES_USER:
            bus = record.line.framing or f"link type {record.line.link}"
            self.left_out.add(
                f"byte {record.offset}", f"a frame of {bus}, which nothing here puts into words"
            )
        elif record.event not in (RecordKind.TX, RecordKind.RX):
            yield _event(record)
        elif record.line.framing == RAW:
            if record.line not in self._terminals:
                self._terminals[record.line] = TerminalLines(record.interface)
            yield from self._terminals[record.line].feed(record)
        else:
            yield from self._line(record).packets(record)

    def _frames_of(self, line: Interface) -> _Frames | None:
        for frames in self._frames.values():
            if frames.kind.has(line):
                return frames
        return None

    def _frame(self, record: Record, frames: _Frames) -> Iterator[DecodedItem]:
        try:
            frame = frames.kind.unpack(record.data)
        except ValueError as error:
            self.left_out.add(f"byte {record.offset}", str(error))
        else:
            yield frames.decoded(record.at_ns, record.interface, frame, record.comment, record)

    def stream_of(self, record: Record) -> Hashable:
        """Key of the sequence that a record's bytes belong to: ``stream`` of its items. After ``feed``."""
        if self._frames_of(record.line) or record.event not in (RecordKind.TX, RecordKind.RX):
            return record
        return self._terminals[record.line] if record.line.framing == RAW else self._line(record)

    def feed_logged(self, kind: LogKind, frame: LoggedFrame) -> DecodedItem:
        """Take a frame of a log."""
        self._begin(frame[0])
        return self._frames[kind].decoded(*frame)

    def silence(self) -> Iterator[DecodedItem]:
        """Note that nothing follows for long; answers what that completes."""
        return self._silent(FOREVER)

    def _begin(self, at_ns: int) -> None:
        if self.first_ns is None:
            self.first_ns = at_ns

    def _silent(self, now_ns: int) -> Iterator[DecodedItem]:
        for line in dict.fromkeys(self._lines.values()):
            yield from line.silent(now_ns)
        for terminal in self._terminals.values():
            yield from terminal.silent(now_ns)

    def _line(self, record: Record) -> _Line:
        key = record.line, record.event
        if key not in self._lines:
            other = RecordKind.RX if record.event == RecordKind.TX else RecordKind.TX
            known = self._lines.get((record.line, other))
            # Where silence alone ends a packet, both directions are one wire: an answer follows its question.
            self._lines[key] = known if known and not known.has_ends else self._new(record.line)
        return self._lines[key]

    def _new(self, line: Interface) -> _Line:
        return _Line(line, self._choice, self.left_out)


def _event(record: Record) -> DecodedItem:
    name = EVENT_NAMES.get(record.event, f"event {record.event}")
    about = f" ({record.comment})" if record.comment else ""
    data = f": {record.data.hex(' ')}" if record.data else ""
    return DecodedItem(
        record.at_ns,
        record.interface,
        DecodedKind.EVENT,
        lambda: f"{name}{about}{data}",
        error=name,
        data=record.data,
        stream=record,
    )


def decoded_log(kind: LogKind, frames: Iterable[LoggedFrame], decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode a log.

    Raises:
        CaptureError: as who reads it.
    """
    return (decoder.feed_logged(kind, each) for each in frames)


def decoded(records: Iterable[Record], decoder: Decoder) -> Iterator[DecodedItem]:
    """Decode the records of a capture.

    Raises:
        CaptureError: after all that is whole, as who reads them.
    """
    return (item for item in decoded_live(records, decoder) if item)


def decoded_live(records: Iterable[Record | None], decoder: Decoder) -> Iterator[DecodedItem | None]:
    """Decode records as they come. None, of both: nothing has come for a while.

    Raises:
        CaptureError: as ``decoded``.
    """
    error: CaptureError | None = None
    try:
        for record in records:
            yield from decoder.feed(record) if record else (*decoder.silence(), None)
    except CaptureError as caught:
        error = caught
    yield from decoder.silence()  # follows the last record
    if error:
        raise error
