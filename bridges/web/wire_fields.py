"""Fields of a packet that a page looks into. The page gives those before it, too: a question says what its
answer is."""

from collections.abc import Mapping, Sequence
from typing import Any

from bridges.web.page_rows import FieldsAnswer
from bridges.web.web_messages import NAME, taken
from hil.vocab.desk_protocol import Desk
from hil.vocab.framing import Item
from hil.vocab.packet_field import Fields
from hil.vocab.parameters import Form
from hil.vocab.segment import SegmentView
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused
from hil.wire.packet_fields import bytes_field, fields_of
from hil.wire.packet_words import LINE_BAUD

MOST_PACKETS = 256
MOST_CHARACTERS = 4096
PACKETS = Form(
    f"a list of 1 to {MOST_PACKETS} texts",
    lambda value: (
        isinstance(value, list)
        and 0 < len(value) <= MOST_PACKETS
        and all(isinstance(each, str) and len(each) <= MOST_CHARACTERS for each in value)
    ),
)


def wire_fields(desk: Desk, given: Mapping[str, Any]) -> FieldsAnswer:
    """Find the fields of the last of some packets, which are in the order of their times.

    Raises:
        VerbRefused: there is no such wire, or what is given is no packet.
    """
    values = taken(given, {"wire": NAME, "packets": PACKETS}, {})
    here, wire = desk.describe(), values["wire"]
    if line := here.segments.get(wire):
        fields = _of_line(line, values["packets"])
    elif bus := here.buses.get(wire):
        try:
            fields = bus.fields(values["packets"])
        except ValueError as error:
            raise VerbRefused("bad_parameter", f"packets: {error}") from None
    else:
        known = ", ".join((*here.segments, *here.buses)) or "none"
        raise VerbRefused("no_place", f"there is no wire {wire[:80]!r}; there are {known}")
    return {
        "fields": [
            {"name": name, "text": text, "begin": begin, "end": end, "level": level}
            for name, text, begin, end, level in fields
        ]
    }


def _of_line(line: SegmentView, packets: Sequence[str]) -> Fields:
    splitter, baud = line.framing.splitter(), line.baud or LINE_BAUD
    found: list[Item] = []
    data = b""
    for text in packets:
        at_ns, data = _burst(text)
        found += splitter.silence(at_ns)
        found += splitter.burst(data, at_ns, baud).items
    found += splitter.silence(FOREVER)
    if found and found[-1].raw == data:
        return fields_of(line.framing, found[-1])
    return bytes_field(data)


def _burst(text: str) -> tuple[SimTimeNs, bytes]:
    """Time and bytes of a packet. Raises VerbRefused: it is none."""
    at_s, _, digits = text.partition(" ")
    try:
        at_ns, data = round(float(at_s) * 1e9), bytes.fromhex(digits)
    except (ValueError, OverflowError):
        why = f"packets: {text[:80]!r}: write seconds and hexadecimal digits, as 1.5 02550103"
        raise VerbRefused("bad_parameter", why) from None
    return SimTimeNs(min(max(at_ns, 0), FOREVER - 1)), data
