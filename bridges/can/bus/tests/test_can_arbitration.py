"""Arbitration, times and queues against a slow bus that goes bit by bit; who waits when it is full."""

from contextlib import suppress
from itertools import pairwise

import pytest
from can_rig import BIT_NS, RATE, READY_NS, Bench, Offer, Told, play
from hypothesis import given, settings
from hypothesis import strategies as st

from bridges.can.bus.bus_events import CanFilter, MailboxesFull
from bridges.can.frames.can_frame import CanFrame, urgency
from bridges.can.frames.frame_length import frame_bits

BASES = (0, 1, 0x0F8, 0x555, 0x7C0, 0x7FF)


@st.composite
def frames(draw: st.DrawFn, last: int) -> CanFrame:
    """Frames whose identifiers lie close together. ``last``: what no other node's identifiers end in."""
    is_extended = draw(st.booleans())
    base = draw(st.sampled_from(BASES)) & ~3 | last
    is_remote = draw(st.booleans())
    number = base << 18 | draw(st.sampled_from((0, 1, 0x3FFFF))) if is_extended else base
    size = draw(st.integers(0, 8))
    if is_remote:
        return CanFrame(number, b"", is_extended, True, size)
    return CanFrame(number, draw(st.binary(min_size=size, max_size=size)), is_extended)


@st.composite
def offers(draw: st.DrawFn) -> list[Offer]:
    found = []
    for node in range(draw(st.integers(1, 4))):
        for _ in range(draw(st.integers(1, 4))):
            found.append(Offer(draw(st.integers(0, 400)), node, draw(frames(node))))
    return sorted(found)


@pytest.mark.long
@pytest.mark.parametrize("leaps", [True, False])
@settings(max_examples=150, deadline=None)
@given(st.data())
def test_it_is_what_a_slow_bus_does(leaps: bool, data: st.DataObject) -> None:
    given_offers = data.draw(offers())
    bus = Bench(*map(str, range(4)), "ear", leaps=leaps)
    bus.run()
    # On a bus that is idle a frame begins when it comes, so there is one at once that sets the bits' phase.
    first = CanFrame(0x1FFFABCD, b"\xff" * 8, is_extended=True)
    bus.send("ear", first)
    for offer in given_offers:
        bus.run(READY_NS + offer.bit * BIT_NS)
        bus.send(str(offer.node), offer.frame)
    bus.later(10**8)
    wanted = play([Offer(0, 4, first), *given_offers])
    got = sorted((told, int(name)) for name, ear in bus.ears.items() if name != "ear" for told in ear.out)
    assert got == [
        (Told(READY_NS + start * BIT_NS, READY_NS + end * BIT_NS, frame), node)
        for start, end, node, frame in wanted
        if node != 4
    ]
    for name, ear in bus.ears.items():
        others = [told for other, theirs in bus.ears.items() if other != name for told in theirs.out]
        assert ear.got == sorted(others)


def test_a_frame_has_its_times() -> None:
    bus = Bench("a", "b", rate=1_000_000)
    bus.run()
    bus.run(123_456_789)
    frame = CanFrame(0x123, b"\1\2\3")
    bus.send("a", frame)
    bus.later(10**6)
    assert bus.ears["b"].got == [Told(123_456_789, 123_456_789 + frame_bits(frame) * 1000, frame)]
    assert bus.ears["a"].out == bus.ears["b"].got
    assert bus.ears["a"].got == []
    assert bus.busy_ns() == (frame_bits(frame) + 3) * 1000


@pytest.mark.parametrize("rate", [10_000, 33_333, 83_333, 125_000, 800_000, 1_000_000])
def test_times_do_not_drift(rate: int) -> None:
    """Frames one behind the other for two seconds end where the bits' number says."""
    bus = Bench("a", "b", rate=rate)
    bus.run(2 * 10**6)
    frame = CanFrame(0x2AA, b"\x55" * 8)
    bits = frame_bits(frame) + 3
    count = 2 * rate // bits
    for _ in range(count):
        if bus.nodes["a"].mailboxes.size == len(bus.nodes["a"].mailboxes):
            bus.later(bits * 10**9 // rate)
        bus.send("a", frame)
    bus.later(3 * 10**9)
    start_ns = bus.ears["b"].got[0].start_ns
    assert len(bus.ears["b"].got) == count
    for number, told in enumerate(bus.ears["b"].got):
        assert abs(told.start_ns - (start_ns + number * bits * 10**9 // rate)) <= number // (rate // bits) + 1


def test_beyond_capacity_the_least_urgent_wait() -> None:
    """Ten nodes offer a frame each 1 ms, 1.2 times what the wire carries: the first eight get all through,
    each after those before it; the ninth gets what is left, the last nothing."""
    bus = Bench(*map(str, range(10)), rate=1_000_000)
    bus.run()
    frame_ns = (frame_bits(CanFrame(0x100, b"\x55" * 8)) + 3) * 1000
    offered_ns: dict[int, list[int]] = {node: [] for node in range(10)}
    for turn in range(200):
        bus.run(READY_NS + turn * 1_000_000)
        for node in range(10):
            with suppress(MailboxesFull):
                bus.send(str(node), CanFrame(0x100 + node, b"\x55" * 8))
                offered_ns[node].append(bus.timeline.now_ns)
    bus.run(READY_NS + 200_000_000)
    waits_ms = [
        [
            (told.start_ns - at_ns) / 1e6
            for told, at_ns in zip(bus.ears[str(node)].out, offered_ns[node], strict=False)
        ]
        for node in range(10)
    ]
    whole = 1_000_000 // frame_ns
    assert whole == 8
    for node in range(whole):
        assert len(waits_ms[node]) == 200
        assert max(waits_ms[node]) <= (node + 1) * frame_ns / 1e6
    assert 0 < len(waits_ms[8]) < 200
    assert max(waits_ms[8]) > 20
    assert len(waits_ms[9]) == 0
    assert bus.nodes["9"].stats.refused == 200 - 64
    assert bus.counters(bus.timeline.now_ns)["load_percent"] == pytest.approx(100, abs=0.2)


def test_a_node_sends_its_most_urgent_first_and_of_one_urgency_the_oldest() -> None:
    bus = Bench("a", "b")
    bus.run()
    sent = [CanFrame(5, b"x"), CanFrame(9), CanFrame(7, b"1"), CanFrame(7, b"2"), CanFrame(3)]
    for frame in sent:
        bus.send("a", frame)
        bus.later(BIT_NS)  # the first is on the wire already
    bus.later(10**7)
    heard = [told.frame for told in bus.ears["b"].got]
    assert heard == [sent[0], sent[4], sent[2], sent[3], sent[1]]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 300_000), st.integers(0, 7)), max_size=30))
def test_no_frame_is_lost_or_doubled(offered: list[tuple[int, int, int]]) -> None:
    bus = Bench(*"abcd", "ear")
    bus.run()
    sent = []
    for number, (node, pause_ns, low) in enumerate(offered):
        bus.later(pause_ns)
        frame = CanFrame(low << 4 | node, number.to_bytes(2))
        bus.send("abcd"[node], frame)
        sent.append(frame)
    bus.later(10**8)
    heard = [told.frame for told in bus.ears["ear"].got]
    assert sorted(heard) == sorted(sent)
    of_one = {frame.id: [each for each in heard if each.id == frame.id] for frame in sent}
    assert all(each == sorted(each) for each in of_one.values())
    times = [(told.start_ns, told.end_ns) for told in bus.ears["ear"].got]
    assert all(before[1] + 3 * BIT_NS <= after[0] for before, after in pairwise(times))


def test_mailboxes_are_as_many_as_there_are() -> None:
    bus = Bench("b")
    bus.join("a", bus.ears["b"], mailboxes=2)
    bus.run()
    bus.send("a", CanFrame(1))
    bus.send("a", CanFrame(2))
    with pytest.raises(MailboxesFull, match="all 2 mailboxes are full"):
        bus.send("a", CanFrame(0))
    bus.later(10**6)
    bus.send("a", CanFrame(0))
    assert bus.nodes["a"].stats.refused == 1


def test_frames_that_cannot_be_are_refused() -> None:
    bus = Bench("a", "b")
    for frame, why in (
        (CanFrame(0x800), "identifier 0x800; with 11 bits it is 0 to 0x7ff"),
        (CanFrame(-1), "identifier -0x1"),
        (CanFrame(1 << 29, is_extended=True), "with 29 bits"),
        (CanFrame(1, bytes(9)), "9 bytes; a frame has 0 to 8"),
        (CanFrame(1, b"x", is_remote=True), "a remote frame has no data"),
        (CanFrame(1, b"", is_remote=True, remote_dlc=9), "9 bytes"),
        (CanFrame(1, b"", remote_dlc=2), "remote_dlc"),
    ):
        with pytest.raises(ValueError, match=why):
            bus.send("a", frame)
    bus.run(10**7)
    assert bus.frames == 0


@pytest.mark.parametrize("rate", [0, 9_999, 1_000_001])
def test_rates_that_cannot_be_are_refused(rate: int) -> None:
    with pytest.raises(ValueError, match="a bus has 10000 to 1000000"):
        Bench(rate=rate)


def test_what_is_dropped_is_not_sent() -> None:
    bus = Bench("a", "b")
    bus.run()
    for number in range(5):
        bus.send("a", CanFrame(number))
    bus.later(BIT_NS)
    bus.drop("a")
    bus.later(10**7)
    assert [told.frame.id for told in bus.ears["b"].got] == [0]


def test_nodes_hear_what_their_filters_want() -> None:
    bus = Bench("a", "b")
    bus.set_filters("b", [CanFilter(0x100, 0x700), CanFilter(0x5, 0x1FFFFFFF, True)])
    bus.run()
    for frame in (CanFrame(0x1AB), CanFrame(0x2AB), CanFrame(5), CanFrame(5, is_extended=True)):
        bus.send("a", frame)
    bus.later(10**7)
    assert [str(told.frame) for told in bus.ears["b"].got] == ["00000005#", "1AB#"]
    assert len(bus.ears["a"].out) == 4


def test_a_node_that_leaves_is_gone_and_its_place_is_free() -> None:
    bus = Bench("a", "b", "c")
    bus.run()
    bus.send("a", CanFrame(0x55, b"12345678"))
    bus.later(20 * BIT_NS)
    bus.leave("a")  # in the middle of its frame
    bus.later(10**6)
    assert bus.ears["b"].got == []
    assert [event.error for event in bus.events] == ["stuff", "stuff"]
    bus.join("d", bus.ears["a"])
    bus.later(10**6)
    bus.send("d", CanFrame(1))
    bus.later(10**6)
    assert [told.frame.id for told in bus.ears["b"].got] == [1]
    with pytest.raises(ValueError, match="d is on the bus already"):
        bus.join("d", bus.ears["a"])


def test_answers_in_a_callback_go_out_at_once() -> None:
    """A node that answers to what it hears contends for the next start of frame."""
    bus = Bench("a", "b")
    bus.run()

    def answer(frame: CanFrame, start_ns: int, end_ns: int) -> None:
        if frame.id == 0x10:
            bus.send("b", CanFrame(0x11))

    bus.ears["b"].hear = answer  # type: ignore[method-assign]
    bus.send("a", CanFrame(0x10))
    bus.send("a", CanFrame(0x12))
    bus.later(10**6)
    (first, third), (second,) = bus.ears["a"].out, bus.ears["a"].got
    assert second.start_ns == first.end_ns + 3 * BIT_NS
    assert third.start_ns == second.end_ns + 3 * BIT_NS


def test_urgency_is_the_order_of_the_bits() -> None:
    frames = [CanFrame(0x123), CanFrame(0x123, is_remote=True), CanFrame(0x123 << 18, is_extended=True)]
    assert sorted(reversed(frames), key=urgency) == frames
    assert RATE == 500_000
