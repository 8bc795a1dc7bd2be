"""Captures as text: each packet a line, by the framing that the capture names; each frame of CAN a line, with
what it says by CANopen."""

from collections.abc import Iterable, Iterator, Mapping

from hil.cli.capture_files import logged
from hil.compose.find import find_catalogue
from hil.compose.framings import LINE_FRAMING, in_format
from hil.vocab.framing import Framing, Splitter
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.can.can_frame import CanFrame
from hil.wire.can.candump_log import LoggedFrame
from hil.wire.canopen.canopen_words import CanOpenWords
from hil.wire.canopen.eds_names import EdsObjects
from hil.wire.pcapng import EVENT_NAMES, CaptureError, Interface, Record, RecordKind, read

LINE_BAUD = 38400
"""Speed of a line whose capture does not say it."""


class _Line:
    """One direction of an interface, or both."""

    def __init__(self, line: Interface) -> None:
        framings = find_catalogue().framings
        if (name := line.framing or LINE_FRAMING) not in framings:
            raise CaptureError(f"{line.name} has the framing {name!r}; this knows {', '.join(framings)}")
        self._name = line.name
        self._baud = line.baud or LINE_BAUD
        self._framing: Framing = in_format(framings[name], line.line_format)
        self._splitter: Splitter = self._framing.splitter()
        self.has_ends = self._framing.has_ends

    def packets(self, data: bytes, at_ns: int) -> Iterator[tuple[int, str]]:
        for item in self._splitter.burst(data, SimTimeNs(at_ns), self._baud).items:
            yield item.at_ns, f"{self._name} {self._framing.text(item)}"

    def silent(self, now_ns: int) -> Iterator[tuple[int, str]]:
        for item in self._splitter.silence(SimTimeNs(now_ns)):
            yield item.at_ns, f"{self._name} {self._framing.text(item)}"


Eds = Mapping[int, EdsObjects]
"""What is known of CANopen nodes, by their ids."""


class _Buses:
    """CAN buses of a capture, each a network of CANopen."""

    def __init__(self, eds: Eds) -> None:
        self._eds = eds
        self._words: dict[str, CanOpenWords] = {}

    def text(self, each: LoggedFrame, comment: str = "") -> str:
        """Say a frame or an error; ``comment``: who sent or found it."""
        by = f" ({comment})" if comment else ""
        if not isinstance(each.frame, CanFrame):
            return f"{each.bus} {each.frame}{by}"
        if each.bus not in self._words:
            names = {node: objects.names for node, objects in self._eds.items()}
            values = {node: objects.values for node, objects in self._eds.items()}
            self._words[each.bus] = CanOpenWords(names, values)
        return f"{each.bus} {each.frame!s:20} {self._words[each.bus].say(each.frame)}{by}".rstrip()


def decoded_log(frames: Iterable[LoggedFrame], eds: Eds) -> Iterator[str]:
    """Decode a log of CAN; times are seconds since its first frame.

    Raises:
        CaptureError: as who reads it.
    """
    buses, first_ns = _Buses(eds), None
    for each in frames:
        first_ns = each.at_ns if first_ns is None else first_ns
        yield f"{(each.at_ns - first_ns) / 1e9:12.6f} {buses.text(each)}"


def decoded(capture: bytes | Iterable[Record], eds: Eds | None = None) -> Iterator[str]:
    """Decode a capture, or its records as they come; times are seconds since its first record. ``eds``: of
    CANopen nodes.

    Raises:
        CaptureError: after all that is whole, as ``hil.wire.pcapng.read``; or a framing that is not here.
    """
    records = read(capture) if isinstance(capture, bytes) else capture
    lines: dict[tuple[Interface, int], _Line] = {}
    buses = _Buses(eds or {})
    first_ns: int | None = None
    error: CaptureError | None = None
    try:
        for record in records:
            first_ns = record.at_ns if first_ns is None else first_ns
            for at_ns, text in _of_record(record, lines, buses):
                yield f"{(at_ns - first_ns) / 1e9:12.6f} {text}"
    except CaptureError as caught:
        error = caught
    for line in lines.values():  # silence follows the last record
        for at_ns, text in line.silent(FOREVER):
            yield f"{(at_ns - (first_ns or 0)) / 1e9:12.6f} {text}"
    if error:
        raise error


def _of_record(
    record: Record, lines: dict[tuple[Interface, int], _Line], buses: _Buses
) -> Iterator[tuple[int, str]]:
    for line in lines.values():
        yield from line.silent(record.at_ns)
    if record.line.is_can:
        yield record.at_ns, buses.text(logged(record), record.comment)
        return
    if record.event not in (RecordKind.TX, RecordKind.RX):
        name = EVENT_NAMES.get(record.event, f"event {record.event}")
        about = f" ({record.comment})" if record.comment else ""
        yield record.at_ns, f"{record.interface} {name}{about}: {record.data.hex(' ')}"
        return
    key = record.line, record.event
    if key not in lines:
        other = RecordKind.RX if record.event == RecordKind.TX else RecordKind.TX
        known = lines.get((record.line, other))
        # Where silence alone ends a packet, both directions are one wire: an answer follows its question.
        lines[key] = known if known and not known.has_ends else _Line(record.line)
    yield from lines[key].packets(record.data, record.at_ns)
