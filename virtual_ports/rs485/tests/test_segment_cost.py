"""Cost of a disturbed line: in proportion to its stations, and no more the longer it lasts."""

import gc
import itertools
import sys
import time
from collections.abc import Callable
from typing import Any

import pytest
from wire_rig import BAUD, Wire

from device_profiles.sac.packet import encode

STATIONS = 252
CPU_MS = 20
"""Maximum CPU time of a collision of all stations."""


def crowd(count: int) -> Wire:
    return Wire(*(f"s{address}" for address in range(4, 4 + count)))


def all_at_once(wire: Wire, apart_ns: int = 0) -> None:
    """Each acknowledges, under an address of its own; then time for all of it."""
    start_ns = wire.clock.now_ns
    for place, name in enumerate(wire.ears):
        wire.send(name, start_ns + place * apart_ns, encode(1, 4 + place, b"\6"))
    wire.heard()


def calls(work: Callable[[], Any]) -> int:
    """Return the number of functions called: a measure of work that other programs do not change."""
    count = 0

    def note(frame: Any, event: str, argument: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    gc.disable()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
        gc.enable()
    return count


def test_a_collision_of_a_full_line_costs_20_ms_at_most() -> None:
    spent_ms = []
    for _ in range(5):  # the least of them is not another program's
        wire = crowd(STATIONS)
        before_s = time.process_time()
        all_at_once(wire)
        spent_ms.append((time.process_time() - before_s) * 1e3)
        assert wire.stats.collisions == STATIONS - 1
    assert min(spent_ms) < CPU_MS


@pytest.mark.parametrize("within_ns", [0, 252, 126_000, 240_000, 300_000])
def test_the_cost_of_a_collision_grows_in_proportion_to_its_stations(within_ns: int) -> None:
    """Few or many stations begin within the same time, so that both lines are read again equally often."""
    few, many = (
        calls(lambda count=count: all_at_once(crowd(count), within_ns // count)) for count in (63, STATIONS)
    )
    assert 3.5 < many / few < 4.5


def test_in_a_collision_all_are_told_at_once() -> None:
    wire = crowd(STATIONS)
    all_at_once(wire)
    assert max(ear.told for ear in wire.ears.values()) <= 3


def babble(wire: Wire, name: str, every_ns: int) -> None:
    """20 bytes at a time, forever. They take 5.2 ms, so that more often is always."""

    def speak(now_ns: Any) -> None:
        data = bytes((now_ns * place >> 7) & 0xFF for place in range(1, 21))
        wire.transmit(name, now_ns, data, BAUD)
        wire.clock.at(now_ns + every_ns, speak)

    wire.clock.at(every_ns, speak)


def test_a_line_that_is_never_idle_always_costs_the_same() -> None:
    wire = Wire(*"abcd")
    shown: list[int] = []
    wire.watchers.append(lambda event: shown.append(len(event.data)))
    babble(wire, "a", 5_000_000)
    babble(wire, "b", 4_900_000)
    costs = [calls(lambda: wire.clock.run(wire.clock.now_ns + 200_000_000)) for _ in range(6)]
    assert max(costs[1:]) < 1.2 * min(costs[1:])
    assert len(shown) > 5  # watchers and counters do not wait for its end
    assert sum(shown) > 2000
    assert wire.counters(1_200_000_000)["load"] == pytest.approx(1, abs=0.01)


def test_what_a_line_remembers_is_bounded() -> None:
    wire = Wire(*"abcd")
    babble(wire, "a", 5_000_000)
    babble(wire, "b", 4_900_000)
    sizes = []
    for _ in range(50):
        wire.clock.run(wire.clock.now_ns + 50_000_000)
        line: Any = wire._disturbance and wire._disturbance._line
        sizes.append(len(line._drives) + sum(map(len, line._lows.values())) + len(line._own["a"]))
    assert max(sizes) < 100


def test_a_station_that_is_to_send_more_than_its_line_takes_sends_one_burst_after_the_other() -> None:
    wire = Wire("a", "b")
    babble(wire, "a", 100_000)
    cost = calls(lambda: wire.clock.run(200_000_000))
    times_ns = [at_ns for at_ns, _ in wire.ears["b"].got]
    gaps_ns = [later - sooner for sooner, later in itertools.pairwise(times_ns)]
    assert len(times_ns) > 700
    assert min(gaps_ns) > 260_000
    assert wire.counters(200_000_000)["load"] == pytest.approx(1, abs=0.02)
    assert wire.stats.collisions == 0
    assert cost < 100_000
