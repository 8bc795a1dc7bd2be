"""Characters that stations hear: those of the whole waveform, whoever looks, whenever it was announced."""

from random import Random
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from wire_rig import BAUD, Ear, Sent, SlowWire, Timeline, Wire, characters_ns

from device_profiles.sac.packet import encode
from virtual_ports.rs485.disturbance import WINDOW_CHARACTERS
from virtual_ports.rs485.stations import Station

NAMES = "abcdef"
Y = encode(85, 1, b"y")
DATA = st.one_of(
    st.sampled_from([Y, b"m", b"\0\2\3", b"U" * 9, b"\xff\0" * 3, bytes(range(30))]),
    st.binary(min_size=1, max_size=8),
)
STARTS = st.one_of(st.integers(0, 8_000_000), st.integers(0, 30).map(lambda n: n * 260_416))
BURSTS = st.lists(st.tuples(STARTS, st.sampled_from("abcd"), DATA), max_size=8)
STATION = st.fixed_dictionaries(
    {
        "baud": st.sampled_from([BAUD, BAUD, BAUD, 9600, 57600, 250_000]),
        "has_echo": st.booleans(),
        "is_swapped": st.sampled_from([False, False, False, True]),
        "is_stuck": st.sampled_from([False] * 7 + [True]),
        "is_cut": st.sampled_from([False] * 7 + [True]),
        "release_ns": st.sampled_from([0, 0, 1, 30_000, 800_000]),
    }
)
STATIONS = st.one_of(
    st.tuples(*[STATION] * len(NAMES)),
    st.just(({"baud": BAUD},) * len(NAMES)),
)


def wire_of(stations: Any) -> Wire:
    wire = Wire(*NAMES, bauds=[each["baud"] for each in stations])
    for name, each in zip(NAMES, stations, strict=True):
        for key, value in each.items():
            if key != "baud":
                setattr(wire.stations[name], key, value)
    wire.stations.changed()
    return wire


def slow_of(stations: Any) -> SlowWire:
    return SlowWire(
        {
            name: Station(
                name, Ear(Timeline(), each["baud"]), **{k: v for k, v in each.items() if k != "baud"}
            )
            for name, each in zip(NAMES, stations, strict=True)
        }
    )


def sent(bursts: Any, stations: Any) -> list[Sent]:
    """Bursts in the order of time; a UART sends one after the other."""
    free: dict[str, int] = {}
    out = []
    for start_ns, name, data in sorted(bursts):
        baud = stations[NAMES.index(name)]["baud"]
        begin_ns = max(start_ns, free.get(name, 0))
        free[name] = begin_ns + characters_ns(len(data), baud)
        out.append(Sent(begin_ns, name, data))
    return sorted(out, key=lambda each: each.start_ns)


RIGHT = {
    "baud": BAUD,
    "has_echo": False,
    "is_swapped": False,
    "is_stuck": False,
    "is_cut": False,
    "release_ns": 0,
}


@pytest.mark.thorough
@pytest.mark.long
@settings(max_examples=100)
@example(  # a low of 1 ns at the end of the first burst of "a" goes on as a start bit
    [(0, "d", b"U" * 9), (1, "a", b"\xff\0" * 3), (2, "a", b"\2U\1y\3d\0")],
    (
        *(RIGHT | {"release_ns": 1}, RIGHT, RIGHT | {"is_stuck": True}),
        *(RIGHT | {"baud": 57600, "is_swapped": True}, RIGHT, RIGHT),
    ),
)
@given(BURSTS, STATIONS)
def test_all_is_heard_as_from_the_whole_waveform(bursts: Any, stations: Any) -> None:
    wire, slow = wire_of(stations), slow_of(stations)
    every = sent(bursts, stations)
    for burst in every:
        wire.send(burst.station, burst.start_ns, burst.data)
    wire.clock.run(10**10)
    slow.play(every)
    for name in NAMES:
        assert wire.ears[name].got == slow.ears[name].got, name
    assert {name: each.collisions for name, each in wire.stats.stations.items()} == slow.collisions
    assert wire.stats.packets == slow.packets


@example(  # "d" goes on without letting go at the time that "a" comes on
    [(0, "a", Y), (0, "a", Y), (0, "d", Y), (0, "d", Y)],
    (RIGHT, RIGHT, RIGHT, RIGHT | {"release_ns": 1}, RIGHT, RIGHT),
    Random(1),
)
@given(BURSTS, STATIONS, st.randoms(use_true_random=False))
def test_when_and_in_which_order_bursts_are_announced_does_not_matter(
    bursts: Any, stations: Any, random: Any
) -> None:
    on_time, ahead = wire_of(stations), wire_of(stations)
    every = sent(bursts, stations)
    for burst in every:
        on_time.send(burst.station, burst.start_ns, burst.data)
    announced = [(random.randint(0, burst.start_ns), random.random(), burst) for burst in every]
    for at_ns, _, burst in sorted(announced):
        ahead.clock.run(at_ns)
        baud = ahead.ears[burst.station].baud_now
        ahead.transmit(burst.station, burst.start_ns, burst.data, baud)  # type: ignore[arg-type]
    for wire in (on_time, ahead):
        wire.clock.run(10**10)
    for name in NAMES:
        assert on_time.ears[name].got == ahead.ears[name].got
    counters = [wire.counters(10**10) for wire in (on_time, ahead)]
    for each in counters:
        each.pop("stations")  # whose start at one time was the collision depends on their order
    assert counters[0] == counters[1]


def test_a_third_that_sends_between_two_writes_collides_with_the_first() -> None:
    wire = Wire("tap", "b", "c")
    wire.send("tap", 0, Y)
    wire.transmit("tap", characters_ns(len(Y)), Y, BAUD)  # type: ignore[arg-type]
    wire.send("b", characters_ns(3), b"ABCD")
    heard = wire.heard()["c"]
    assert heard.startswith(Y[:3])
    assert b"ABCD" not in heard
    assert heard.endswith(Y)
    assert (wire.stats.collisions, wire.stats.stations["tap"].collisions) == (1, 1)


def test_a_long_disturbance_is_shown_in_pieces_and_nothing_is_lost_between_them() -> None:
    wire = Wire("a", "b", "c", "d")
    wire.stations["d"].is_swapped = True  # so that each burst is read from the waveform
    wire.stations.changed()
    told: list[bytes] = []
    wire.watchers.append(lambda event: told.append(event.data))
    data = bytes(range(256)) * 4
    assert len(data) > 3 * WINDOW_CHARACTERS
    wire.send("a", 0, data)
    wire.clock.run(10**10)
    assert wire.ears["c"].data == data
    assert wire.ears["c"].told >= len(data) // WINDOW_CHARACTERS
    assert b"".join(told) == data
    assert len(told) > 1


@pytest.mark.parametrize("late_ns", [-1, 0, 1, 51_000, 52_000, 110_000, 150_000])
def test_a_character_that_begins_before_a_window_ends_is_told_in_time(late_ns: int) -> None:
    """The line is read ahead to the end of a window; a burst that begins shortly before takes that back."""
    stations = [
        RIGHT | {"baud": 9600},
        RIGHT,
        RIGHT,
        RIGHT,
        RIGHT,
        RIGHT | {"baud": 57600, "is_swapped": True},
    ]
    wire, slow = wire_of(stations), slow_of(stations)
    window_ns = characters_ns(WINDOW_CHARACTERS)
    bursts = [(0, "a", bytes(range(30))), (4_000_000, "b", Y), (4_164_931 + window_ns - late_ns, "c", Y)]
    for start_ns, name, data in bursts:
        wire.send(name, start_ns, data)
    wire.clock.run(10**10)
    slow.play(sent(bursts, stations))
    for name in NAMES:
        assert wire.ears[name].got == slow.ears[name].got, name


class Looked(RuleBasedStateMachine):
    """Two equal wires; at one of them everything that a view has is looked at, at any times."""

    @initialize(stations=STATIONS)
    def begin(self, stations: Any) -> None:
        self.wires = [wire_of(stations), wire_of(stations)]
        self.shown: list[list[Any]] = [[], []]
        for wire, shown in zip(self.wires, self.shown, strict=True):
            wire.watchers.append(shown.append)

    @rule(name=st.sampled_from("abcd"), data=DATA, ahead_ns=st.sampled_from([0, 0, 1, 300_000, 4_000_000]))
    def send(self, name: str, data: bytes, ahead_ns: int) -> None:
        for wire in self.wires:
            baud = wire.ears[name].baud_now
            wire.transmit(name, wire.clock.now_ns + ahead_ns, data, baud)

    @rule(for_ns=st.sampled_from([1, 50_000, 260_416, 1_000_000, 20_000_000]))
    def wait(self, for_ns: int) -> None:
        for wire in self.wires:
            wire.clock.run(wire.clock.now_ns + for_ns)

    @rule(elapsed_ns=st.integers(0, 10**12))
    def look(self, elapsed_ns: int) -> None:
        wire = self.wires[0]
        wire.counters(elapsed_ns)
        wire.clashes()
        wire.clashes_with(85, "a")
        for name in NAMES:
            wire.has(name)
            wire.baud_of(name)

    @invariant()
    def the_other_is_the_same(self) -> None:
        if hasattr(self, "wires"):
            looked, other = self.wires
            assert looked.counters(10**9) == other.counters(10**9)
            assert self.shown[0] == self.shown[1]
            for name in NAMES:
                assert looked.ears[name].got == other.ears[name].got


TestLooked = pytest.mark.long(Looked.TestCase)
