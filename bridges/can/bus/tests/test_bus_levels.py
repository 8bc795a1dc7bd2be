"""Levels of a bus are the bits of its frames, with their acknowledgement; what nobody knows is not drawn."""

import pytest

from bridges.can.bus.bus_events import BusEvent
from bridges.can.bus.bus_levels import event_levels
from bridges.can.frames._wire_bits import wire_bits
from bridges.can.frames.can_frame import parse_frame
from hil.vocab.time import SimTimeNs


@pytest.mark.parametrize("text", ["000#", "123#0011", "7FF#FFFFFFFFFFFFFFFF", "0000CAFE#R4", "1FFFFFFF#00"])
@pytest.mark.parametrize("rate", [125_000, 1_000_000, 33_333])
def test_a_frame_read_in_the_middles_of_its_bits(text: str, rate: int) -> None:
    frame = parse_frame(text)
    bits = wire_bits(frame)
    start_ns, bit_ns = 1_000_003, 10**9 / rate
    event = BusEvent(SimTimeNs(start_ns), SimTimeNs(start_ns + len(bits) * 10**9 // rate), "a", frame)
    edges = [*event_levels(event, rate)]
    assert edges[0] == (start_ns, 0)
    assert edges[-1][1] == 1  # the delimiter behind the acknowledgement
    read = []
    for index in range(len(bits)):
        at_ns = start_ns + (index + 0.5) * bit_ns
        read.append([1, *(level for edge_ns, level in edges if edge_ns <= at_ns)][-1])
    acknowledged = bytearray(bits)
    acknowledged[-9] = 0
    assert bits[-9] == 1
    assert bytes(read) == bytes(acknowledged)


def test_what_an_error_cut_off_is_unknown() -> None:
    event = BusEvent(SimTimeNs(1000), SimTimeNs(90_000), "a", error="acknowledgement")
    assert [*event_levels(event, 500_000)] == [(1000, -1), (90_000 + 12 * 2000, 1)]
    assert [*event_levels(BusEvent(SimTimeNs(1), SimTimeNs(2), "a", state="bus-off"), 500_000)] == []
