"""Lines of what a bench and its boards said in a run, read from its recording, without a replay."""

import json
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from hil.sim.inputs import InputLogError
from hil.sim.noted_events import NotedEvent, decode_event
from hil.vocab.address import Address, owner_of
from hil.vocab.shown_text import printable

LEVELS = ("info", "warning", "error")
"""Levels of lines, the least first."""
_WARNINGS = frozenset({"faults", "motors", "refusals", "lateness"})
_ERRORS = frozenset({"trouble"})
_HEADS = {"faults": "fault ", "refusals": "refused: ", "runs": "run "}
"""Words before the text of an event, by its kind."""
_LOG = "log"
_OF_LOG = {"DEBUG": "info", "INFO": "info", "WARNING": "warning", "ERROR": "error", "CRITICAL": "error"}
"""Levels of lines of the daemon's log, by the word at their beginning."""
_SENT = re.compile(
    rb'\{"at_ns":(\d{1,18}),"device":"([^"\\]*)","sent":"([0-9a-f]*)"[^\n]*?(?:"port":"([^"\\]*)")?\}\n'
)
LONGEST = 200
"""Maximum number of bytes of a line of a board; more are another line."""
SILENCE_NS = 500_000_000
"""Time after which a text without an end is a line, as a prompt."""
_PACKET_NS = 2_000_000
"""The same of bytes that are no text."""
_ENDS = re.compile(rb"[\r\n]+")
_NO_TEXT = re.compile(rb"[^\x20-\x7e\t\r\n\x1b\x07\x08\x0c\x80-\xff]")


class SaidLine(NamedTuple):
    """Line of a bench's log. ``source``: address, or ``bench``; ``level``: of ``LEVELS``; ``kind``: that of
    the event, or ``text`` and ``bytes`` of a board; ``number``: of the event, 0: of none; a later one of that
    number takes its place."""

    at_ns: int
    source: str
    level: str
    kind: str
    text: str
    number: int = 0

    def is_of(self, name: str) -> bool:
        """True if it is of a device, a wire or a part of one."""
        sources = self.source.split(", ")
        return any(each == name or each.startswith(f"{name}.") for each in sources)

    def as_dict(self) -> dict[str, Any]:
        """Line for JSON."""
        return {
            "at_ns": self.at_ns,
            "source": self.source,
            "level": self.level,
            "kind": self.kind,
            "text": self.text,
        }


class _Typing(NamedTuple):
    """Bytes of a board that have not become a line. ``last_ns``: time of the last piece."""

    at_ns: int
    last_ns: int
    data: bytes


class SaidLines:
    """Reader of a recording's lines, in their order."""

    def __init__(self) -> None:
        self._open: dict[str, _Typing] = {}
        self.names: set[str] = set()
        """Devices that have said something, or could."""
        self.end = ""
        """Reason of the log's end; empty: there is none so far."""
        self.end_ns = 0
        self.header: dict[str, Any] = {}

    def add(self, line: bytes) -> Iterator[SaidLine]:
        """Take the next line of the recording. A line that is damaged says nothing."""
        if found := _SENT.fullmatch(line):
            at, device, digits, port = found.groups()
            place = str(Address(device.decode(), (port or b"").decode()))
            yield from self._sent(int(at), place, bytes.fromhex(digits.decode()))
            return
        if b'"input":' in line[:300] and self.header:
            return
        try:
            values = json.loads(line)
        except ValueError:
            return
        if not isinstance(values, dict):
            return
        if not self.header:
            self._begin(values)
        elif "event" in values:
            try:
                yield line_of(decode_event(values))
            except InputLogError:
                return
        elif "sent" in values:
            place = str(Address(str(values["device"]), str(values.get("port", ""))))
            yield from self._sent(int(values["at_ns"]), place, bytes.fromhex(values["sent"]))
        elif "reload" in values:
            yield SaidLine(int(values.get("at_ns", self.end_ns)), "bench", "info", "reloads", "reloaded")
        elif "check" in values:
            self.end_ns = max(self.end_ns, int(values.get("at_ns", 0)))
            yield from self.silent(self.end_ns)
        elif "end" in values:
            self.end = str(values.get("why", values["end"]))

    def silent(self, now_ns: int | None = None) -> Iterator[SaidLine]:
        """Take what no end of a line has followed for so long that it is a line; None: all."""
        for place, typed in list(self._open.items()):
            if now_ns is None or now_ns - typed.last_ns >= SILENCE_NS:
                del self._open[place]
                yield from _text_lines(typed.at_ns, place, typed.data)

    def _begin(self, values: dict[str, Any]) -> None:
        self.header = values
        config = values.get("config")
        if isinstance(config, dict):
            self.names |= {
                str(name) for key in ("devices", "segments", "can") for name in config.get(key) or ()
            }

    def _sent(self, at_ns: int, place: str, data: bytes) -> Iterator[SaidLine]:
        self.names.add(owner_of(place))
        self.end_ns = max(self.end_ns, at_ns)
        before = self._open.pop(place, None)
        if before and at_ns - before.last_ns > (_PACKET_NS if _NO_TEXT.search(before.data) else SILENCE_NS):
            yield from _text_lines(before.at_ns, place, before.data)
            before = None
        begun_ns = before.at_ns if before else at_ns
        *whole, rest = (
            _ENDS.split(before.data + data if before else data)
            if not _NO_TEXT.search(data)
            else [(before.data if before else b"") + data]
        )
        for each in whole:
            yield from _text_lines(begun_ns, place, each)
            begun_ns = at_ns
        if len(rest) >= LONGEST:
            yield from _text_lines(begun_ns, place, rest)
        elif rest:
            self._open[place] = _Typing(begun_ns, at_ns, rest)


def _text_lines(at_ns: int, place: str, data: bytes) -> Iterator[SaidLine]:
    """Lines of a board: bytes that are no text, and control characters, are escaped."""
    kind = "bytes" if _NO_TEXT.search(data) else "text"
    for begin in range(0, len(data), LONGEST):
        text = printable(data[begin : begin + LONGEST].decode(errors="backslashreplace"))
        if text.strip():
            yield SaidLine(at_ns, place, "info", kind, text)


def line_of(event: NotedEvent) -> SaidLine:
    """Make a line of an event."""
    text, level = event.text, "info"
    if event.kind == _LOG:
        level, _, text = event.text.partition(" ")
        level = _OF_LOG.get(level, "info")
    elif event.kind in _WARNINGS:
        level = "warning"
    elif event.kind in _ERRORS and not event.text.startswith("over: "):
        level = "error"
    text = _HEADS.get(event.kind, "") + text
    if event.count > 1:
        text = f"{text} ({event.count} times)"
    if event.who not in ("", "bench", event.of):
        text = f"{text} (by {event.who})"
    return SaidLine(event.at_ns, event.of or "bench", level, event.kind, text, event.number)
