"""RS485 as a kind of bus: all that hil asks of it."""

from typing import TYPE_CHECKING

from hil.vocab.bus import BusKind, SegmentKind
from virtual_ports.rs485.segment_reports import REPORTS

if TYPE_CHECKING:
    from hil.vocab.framing import Framing
    from hil.vocab.line_format import LineFormat
    from hil.vocab.segment import Segment
    from hil.vocab.time import Clock


def _make(clock: "Clock", framing: "Framing", line_format: "LineFormat", name: str) -> "Segment":
    from virtual_ports.rs485 import segment  # most benches have none

    return segment.Rs485Segment(clock, framing, line_format, name)


BUS = BusKind(segments=SegmentKind(REPORTS, _make))
