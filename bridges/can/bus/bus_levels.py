"""Levels of a CAN bus as they were, for pictures of it."""

from collections.abc import Iterator

from bridges.can.bus.bus_events import BusEvent
from bridges.can.frames._wire_bits import wire_bits
from hil.vocab.time import NS_PER_S

_ACK_SLOT = -9
"""Place of the slot for the acknowledgement: its delimiter and the seven bits of the end of frame follow."""
_FLAG_BITS = 12
"""Maximum length of error flags that lie over each other (CAN Specification 2.0, 7.1)."""


def event_levels(event: BusEvent, bit_rate: int) -> Iterator[tuple[int, int]]:
    """Edges that an event has made, as (at_ns, level), 1 recessive. A frame is drawn bit by bit, with the
    acknowledgement that it had. What an error has cut off, with its flag, nobody tells: it is -1."""
    if event.frame is not None and not event.error:
        bits = bytearray(wire_bits(event.frame))
        bits[_ACK_SLOT] = 0
        before = 1
        for index, level in enumerate(bits):
            if level != before:
                yield event.start_ns + index * NS_PER_S // bit_rate, level
            before = level
    elif event.error:
        yield event.start_ns, -1
        yield event.at_ns + _FLAG_BITS * NS_PER_S // bit_rate, 1
