"""A bus with more to send than it has bits: who waits how long.

Bounds by the analysis of Davis, Burns, Bril and Lukkien, Controller Area Network (CAN) schedulability
analysis: Refuted, revisited and revised, 2007, equations 3 to 6.
"""

from itertools import count

from can_rig import BIT_NS, Bench

from bridges.can.bus.bus_events import MailboxesFull
from bridges.can.frames.can_frame import CanFrame
from bridges.can.frames.frame_length import INTERMISSION_BITS, frame_bits

PERIOD_NS = 1_000_000
CYCLES = 500
FIRST_ID, NODES = 0x100, 7
DATA = b"\x5a" * 8
NAMES = [f"n{at}" for at in range(NODES)]
LENGTH_NS = [(frame_bits(CanFrame(FIRST_ID + at, DATA)) + INTERMISSION_BITS) * BIT_NS for at in range(NODES)]


def offered() -> tuple[Bench, dict[int, list[int]]]:
    """Each node sends a frame each period, all at once; times from a frame's offer to its end, by node."""
    bus = Bench(*NAMES)
    bus.run()
    begun: dict[int, list[int]] = {at: [] for at in range(NODES)}
    waits: dict[int, list[int]] = {at: [] for at in range(NODES)}
    for _ in range(CYCLES):
        for at in reversed(range(NODES)):  # whoever comes last is the most urgent
            try:
                bus.send(NAMES[at], CanFrame(FIRST_ID + at, DATA))
                begun[at].append(bus.timeline.now_ns)
            except MailboxesFull:
                pass
        bus.later(PERIOD_NS)
    for event in bus.events:
        assert event.frame
        at = event.frame.id - FIRST_ID
        waits[at].append(event.at_ns - begun[at][len(waits[at])])
    return bus, waits


def bound_ns(at: int) -> int:
    """Longest time from offer to end, for nodes whose more urgent frames and own fit into the bus: what is on
    the wire when it is offered, and all that is more urgent meanwhile."""
    blocking_ns = max(LENGTH_NS[at + 1 :], default=0)
    waiting_ns = blocking_ns
    for _ in count():
        more = blocking_ns + sum(-(-(waiting_ns + BIT_NS) // PERIOD_NS) * length for length in LENGTH_NS[:at])
        if more == waiting_ns:
            return waiting_ns + LENGTH_NS[at]
        waiting_ns = more
    raise AssertionError


def test_urgent_frames_keep_their_bounds_and_the_others_have_what_is_left() -> None:
    bus, waits = offered()
    fit = 0
    while sum(LENGTH_NS[: fit + 1]) <= PERIOD_NS:
        fit += 1
    assert 2 < fit < NODES - 1, "some fit, and not all but one"
    for at in range(fit):
        assert len(waits[at]) >= CYCLES - 1, "all but one that is on its way"
        assert max(waits[at]) <= bound_ns(at)
        assert max(waits[at]) >= sum(LENGTH_NS[: at + 1]) - INTERMISSION_BITS * BIT_NS
    means = [sum(each) / len(each) for each in waits.values() if each]
    assert means == sorted(means), "the less urgent, the longer"
    left_ns = CYCLES * (PERIOD_NS - sum(LENGTH_NS[:fit]))
    sent = len(waits[fit])
    assert abs(sent * LENGTH_NS[fit] - left_ns) < 2 * LENGTH_NS[fit] + left_ns / 50
    for at in range(fit + 1, NODES):
        assert not waits[at], "nothing is left for it"
        assert len(bus.nodes[NAMES[at]].mailboxes) == bus.nodes[NAMES[at]].mailboxes.size
        assert bus.nodes[NAMES[at]].stats.refused > 0
    assert bus.counters(bus.timeline.now_ns)["load_percent"] > 99
