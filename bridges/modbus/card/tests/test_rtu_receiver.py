"""A node's ear finds the frames that a listener to the whole line finds, at the ends of their silences."""

from heapq import heappop, heappush
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from bridges.modbus.card.rtu_receiver import RtuReceiver
from bridges.modbus.protocol.frame import Frame, encode
from bridges.modbus.protocol.splitter import RtuSplitter
from hil.sim.flight import Flight, heard
from hil.vocab.line_format import FORMATS
from hil.wire.serial_line import character_ns, gap_ns, silence_ns

BAUD, FORM = 19200, FORMATS["8E1"]
GAP_NS, SILENCE_NS, ONE_NS = gap_ns(BAUD, 11), silence_ns(BAUD, 11), character_ns(1, BAUD, 11)


class Timeline:
    """Simulated time, as a group has it."""

    def __init__(self) -> None:
        self.now_ns: Any = 0
        self._calls: list[tuple[int, int, Any]] = []
        self._count = 0

    def at(self, at_ns: int, call: Any) -> None:
        assert at_ns >= self.now_ns
        self._count += 1
        heappush(self._calls, (at_ns, self._count, call))

    def run(self, until_ns: int) -> None:
        while self._calls and self._calls[0][0] <= until_ns:
            self.now_ns, _, call = heappop(self._calls)
            call(self.now_ns)
        self.now_ns = max(self.now_ns, until_ns)


class Ear:
    def __init__(self) -> None:
        self.clock = Timeline()
        self.got: list[tuple[int, int, bytes]] = []
        self.receiver = RtuReceiver(self.clock, BAUD, FORM, lambda *frame: self.got.append(frame))

    def burst(self, start_ns: int, data: bytes) -> None:
        self.clock.run(start_ns)
        flight = heard(start_ns, data, BAUD, BAUD, line_format=FORM)  # type: ignore[arg-type]
        assert flight
        self.receiver.feed(flight)


PIECES = st.sampled_from(
    [encode(1, 3, b"\0\0\0\1"), encode(2, 17), b"\1", b"\1\2\3", encode(1, 6, bytes(250))]
)
PAUSES = st.sampled_from([0, 1, GAP_NS, GAP_NS + 1, SILENCE_NS - 1, SILENCE_NS, SILENCE_NS + 1, 10**8])


@given(st.lists(st.tuples(PAUSES, PIECES), max_size=12))
def test_it_finds_what_a_splitter_finds(bursts: list[tuple[int, bytes]]) -> None:
    ear, splitter, at_ns, items = Ear(), RtuSplitter(11), 0, []
    for pause_ns, data in bursts:
        at_ns += pause_ns
        ear.burst(at_ns, data)
        items += splitter.burst(data, at_ns, BAUD).items  # type: ignore[arg-type]
        at_ns += character_ns(len(data), BAUD, 11)
    ear.clock.run(at_ns + 10**9)
    items += splitter.silence(at_ns + 10**9)  # type: ignore[arg-type]
    wanted = [(item.at_ns, item.raw) for item in items if isinstance(item, Frame) and not item.fault]
    assert [(start_ns, raw) for _, start_ns, raw in ear.got] == wanted
    for now_ns, start_ns, raw in ear.got:
        assert now_ns >= start_ns + character_ns(len(raw), BAUD, 11) + SILENCE_NS


def test_a_frame_ends_at_its_nanosecond() -> None:
    ear, raw = Ear(), encode(1, 17)
    ear.burst(1000, raw)
    end_ns = 1000 + character_ns(len(raw), BAUD, 11) + SILENCE_NS
    ear.clock.run(end_ns - 1)
    assert ear.got == []
    ear.clock.run(end_ns)
    assert ear.got == [(end_ns, 1000, raw)]


def test_what_is_taken_back_was_not_heard() -> None:
    ear, raw = Ear(), encode(1, 17)
    ear.burst(0, raw)
    ear.clock.run(2 * ONE_NS + 5)
    ear.receiver.retract(ear.clock.now_ns)
    ear.clock.run(10**9)
    assert ear.got == [], "two characters are no frame"
    ear.burst(10**9, raw)
    ear.clock.run(2 * 10**9)
    assert [each[2] for each in ear.got] == [raw]


def test_a_whole_frame_with_something_behind_it_that_was_taken_back() -> None:
    """The line was not silent: what came after the frame was a collision's beginning."""
    ear, raw = Ear(), encode(1, 17)
    ear.burst(0, raw)
    end_ns = character_ns(len(raw), BAUD, 11)
    ear.burst(end_ns + GAP_NS, b"\1\2")
    ear.clock.run(end_ns + GAP_NS + 10)
    ear.receiver.retract(ear.clock.now_ns)
    ear.receiver.feed(Flight((end_ns + GAP_NS + ONE_NS,), b"\x55"))
    ear.clock.run(10**9)
    assert ear.got == []


def test_a_character_with_an_error_spoils_its_frame_alone() -> None:
    ear, raw = Ear(), encode(1, 17)
    times_ns = tuple((at + 1) * ONE_NS for at in range(len(raw)))
    ear.receiver.feed(Flight(times_ns, raw, spoiled=frozenset({times_ns[1]})))
    ear.burst(10**9, raw)
    ear.clock.run(2 * 10**9)
    assert [each[1] for each in ear.got] == [10**9]


def test_frames_announced_together_end_one_after_the_other() -> None:
    ear, raw = Ear(), encode(1, 17)
    later_ns = len(raw) * ONE_NS + SILENCE_NS
    times_ns = [(at + 1) * ONE_NS for at in range(len(raw))]
    times_ns += [later_ns + at_ns for at_ns in times_ns]
    ear.receiver.feed(Flight(tuple(times_ns), raw * 2))
    ear.clock.run(10**9)
    assert [each[:2] for each in ear.got] == [(later_ns, 0), (2 * later_ns, later_ns)]
