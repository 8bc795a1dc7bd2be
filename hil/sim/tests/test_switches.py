"""Switches along axes: when they close, what they do to pins, their bounces. Stops, and motors that stall."""

from itertools import pairwise

import pytest

from hil.testing import Bench

HOME = {"axis": "s1", "to_deg": -180, "hysteresis_deg": 2, "to": "s1.Estop"}
"""Switch at the lower end. Without its hysteresis a rotor that swings from step to step lets it go again."""


def bench(switches, seed=0, **devices):
    made = Bench(
        {"bench": "t", "devices": devices or {"s1": {"profile": "sac"}}, "switches": switches, "seed": seed}
    )
    made.run(ms=2500)
    return made


def edges(made, axis="s1"):
    """Edges of an axis's inputs from now on, as (at_ns, level)."""
    at = made.runtime.parts.axis(axis)
    at.record_input_edges(True)
    at.take_input_edges()
    return lambda: [(at_ns, level) for at_ns, _, level in at.take_input_edges()]


def go(made, command, ms):
    made.port("s1").write(command + b"\r")
    made.run(ms=ms)


def test_a_motor_stops_at_its_switch_and_may_leave_it():
    b = bench({"home": HOME})
    took = edges(b)
    go(b, b"m-v30", 3000)
    shot = b.axis("s1").snapshot()
    assert shot.position_deg == pytest.approx(-180, abs=1.8)
    assert (shot.speed_rpm, shot.pin_estop) == (0, 0)
    assert [level for _, level in took()] == [0]
    go(b, b"m100v30", 3000)
    assert b.axis("s1").snapshot().pin_estop == 1
    assert b.axis("s1").snapshot().position_deg == pytest.approx(0, abs=1.8)


def test_it_closes_where_the_shaft_is_there():
    """A servo passes a cam: at the edges' times it is at the cam's edges, to a hundredth of a degree."""
    cam = {"axis": "m1", "from_deg": 36, "to_deg": 72, "to": "m1.D3", "closed": "high"}

    def turning():
        b = bench({"cam": cam}, m1={"profile": "mechaduino", "flash": {"table": "identity"}})
        b.run(ms=2500)
        b.port("m1").write(b"vyr60\n")
        return b

    b = turning()
    took = edges(b, "m1")
    b.run(ms=900)
    (up_ns, one), (down_ns, none) = took()
    assert (one, none) == (1, 0)
    again = turning()
    for at_ns, wanted_deg in ((up_ns, 36), (down_ns, 72)):
        again.run_until(ms=at_ns / 1e6)
        shot = again.axis("m1").snapshot()
        assert shot.at_ns == at_ns
        assert shot.position_deg == pytest.approx(wanted_deg, abs=0.01)


@pytest.mark.parametrize(
    ("contact", "closed", "away"),
    [
        ("normally_open", "low", 1),
        ("normally_open", "high", 0),
        ("normally_closed", "low", 0),
        ("normally_closed", "high", 1),
    ],
)
def test_contact_and_side_make_the_level(contact, closed, away):
    switch = {
        "axis": "u0",
        "from_deg": -90,
        "to_deg": 90,
        "to": "u1.D2",
        "contact": contact,
        "closed": closed,
    }
    b = bench({"x": switch}, u0={"profile": "easydriver"}, u1={"profile": "uno"})
    assert b.runtime.parts.axis("u1").snapshot().pin_levels >> 2 & 1 == 1 - away
    assert b.runtime.parts.switches["x"].is_active
    outside = {**switch, "from_deg": 10}
    b = bench({"x": outside}, u0={"profile": "easydriver"}, u1={"profile": "uno"})
    assert b.runtime.parts.axis("u1").snapshot().pin_levels >> 2 & 1 == away


def test_an_index_comes_each_turn_and_lets_go_by_its_hysteresis():
    index = {
        "axis": "s1",
        "from_deg": 350,
        "to_deg": 358,
        "every_deg": 360,
        "hysteresis_deg": 4,
        "to": "s1.EnA",
    }
    b = bench({"index": index})
    took = edges(b)
    go(b, b"m604v60", 5000)
    assert [level for _, level in took()] == [0, 1] * 3
    assert b.axis("s1").snapshot().position_deg == pytest.approx(3 * 360 + 7.2, abs=2)


def bounced(seed, reruns=1):
    found = []
    for _ in range(reruns):
        b = bench({"home": {**HOME, "bounce_ms": 3, "to": "s1.sync"}}, seed=seed)
        took = edges(b)
        go(b, b"m-v30", 2500)
        found.append(took())
    return found


def test_a_bounce_is_the_seeds_and_ends_in_time():
    first, again = bounced(1, reruns=2)
    (other,) = bounced(2)
    assert first == again
    assert first != other
    times, levels = zip(*first, strict=True)
    assert levels[0] == levels[-1] == 0
    assert len(levels) in (3, 5, 7, 9)
    assert all(one != two for one, two in pairwise(levels))
    assert times[-1] - times[0] <= 3_000_100


def test_it_is_the_same_however_time_is_cut():
    def run(step_ms):
        b = bench({"home": {**HOME, "bounce_ms": 2, "to": "s1.sync"}})
        took = edges(b)
        b.port("s1").write(b"m-v120\r")
        for _ in range(int(1500 / step_ms)):
            b.run(ms=step_ms)
        return took(), b.axis("s1").snapshot().as_dict()

    assert run(1500) == run(0.75)


def test_a_stop_holds_the_shaft_and_the_motor_loses_steps():
    """The stop is as stiff as it is said: the shaft goes into it by what the motor pulls."""
    stops = {"kind": "end_stops", "min_deg": -90, "max_deg": 90, "stop_Nm_per_rad": 20.0}
    b = bench({}, s1={"profile": "sac", "plant": "full", "load": stops})
    b.port("s1").write(b"m200v60\r")
    seen_deg = []
    for _ in range(3000):
        b.run(ms=1)
        seen_deg.append(b.axis("s1").snapshot().position_deg)
    shot = b.axis("s1").snapshot()
    assert 90 < max(seen_deg) < 91
    assert shot.lost_steps != 0
    assert shot.stalls == 1
    assert 2.5e9 < shot.stalled_at_ns < 4e9
    assert "it lost steps once, at " in b.device("s1").notes["motor"]


def test_a_speed_that_the_motor_cannot_follow_is_a_stall_with_its_time():
    b = bench({})
    go(b, b"m3000v1200a1", 50)
    b.run(ms=9000)
    shot = b.axis("s1").snapshot()
    assert shot.stalls == 1
    assert shot.lost_steps > 0
    assert b.device("s1").notes["motor"].endswith("by its figures the motor follows up to 987 rpm")


def test_a_motor_that_follows_has_no_stall():
    b = bench({})
    go(b, b"m1000v600a1", 8000)
    assert b.axis("s1").snapshot().stalls == 0
    assert dict(b.device("s1").notes) == {}


def test_a_servo_that_pushes_and_stands_says_so():
    b = bench({}, m1={"profile": "mechaduino", "flash": {"table": "identity"}})
    b.run(ms=2500)
    b.port("m1").write(b"xyr10\n")
    b.run(ms=500)
    assert "motor" not in b.device("m1").notes
    b.fault("shaft_jam", "m1")
    b.port("m1").write(b"r90\n")
    b.run(ms=1500)
    assert b.device("m1").notes["motor"] == "it pushes with its whole effort, and stands"


def test_a_second_motors_way_is_the_sync_the_encoder_and_the_estop_of_a_sac():
    """An index releases a command that waits; two tracks of a disc are an encoder of 100 pulses a turn, which
    gives as many pulses, half steps here, while nothing else moves; a limit switch ends all."""
    disc = {"axis": "d1", "every_deg": 3.6, "closed": "high"}
    b = bench(
        {
            "index": {"axis": "d1", "from_deg": 10, "to_deg": 20, "every_deg": 360, "to": "s1.sync"},
            "track_a": {**disc, "from_deg": 0, "to_deg": 1.8, "to": "s1.EnA"},
            "track_b": {**disc, "from_deg": 0.9, "to_deg": 2.7, "to": "s1.EnB"},
            "end": {"axis": "d1", "from_deg": 380, "to": "s1.Estop"},
        },
        s1={"profile": "sac"},
        d1={"profile": "sac"},
    )
    b.port("s1").write(b"m100v60s\r")
    b.run(ms=1000)
    assert b.axis("s1").snapshot().position_deg == pytest.approx(0, abs=0.5)
    b.port("d1").write(b"m8v30\r")
    b.run(ms=3000)
    assert b.axis("s1").snapshot().position_deg == pytest.approx(180, abs=1)
    b.port("d1").write(b"m192v30\r")
    b.run(ms=4000)
    assert b.axis("s1").snapshot().position_deg == pytest.approx(180 + 0.96 * 90, abs=1.8)
    assert b.axis("s1").snapshot().pin_estop == 1
    b.port("s1").write(b"m-200v60\r")
    b.port("d1").write(b"m20v60\r")
    b.run(ms=3000)
    assert b.axis("s1").snapshot().pin_estop == 0
    assert b.axis("s1").snapshot().position_deg > 180
