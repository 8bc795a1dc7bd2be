"""Reaction times of nodes: exact where each has an address of its own, apart where two share one."""

import pytest

from bridges.modbus.protocol.frame import encode
from device_profiles.sac.packet import encode as sac_packet
from hil.testing import Bench

FACTORY = 85
"""Address of a SAC from the factory."""
REQUEST = encode(1, 4, bytes.fromhex("00000002"))


def line(seed=0, duplicate=True, **of_segment):
    """Two SACs with the factory's address on one line, and a tap; or one of them alone."""
    names = ("s1", "s2") if duplicate else ("s1",)
    segment = {"stations": list(names), "taps": {"m": {"port": "memory"}}, **of_segment}
    devices = {name: {"profile": "sac", "port": "memory"} for name in names}
    made = Bench({"bench": "t", "devices": devices, "segments": {"bus0": segment}, "seed": seed})
    made.run(ms=2500)
    return made


def answers(made, times=6):
    """What comes at the tap on a message to the factory's address, each with its delay."""
    found = []
    for _ in range(times):
        tap = made.tap("bus0.m")
        tap.read()
        at_ns = made.now_ns
        tap.write(sac_packet(FACTORY, 1, b"V9"))
        made.run(ms=100)
        found.append([(heard_ns - at_ns, byte) for heard_ns, byte in tap.read_timed()])
    return found


def test_a_node_alone_answers_at_its_turnaround():
    times = {tuple(each) for each in answers(line(duplicate=False))}
    assert len(times) == 1


def test_two_nodes_with_one_address_collide_each_time_otherwise():
    b = line(seed=3)
    (first, *others) = answers(b)
    assert any(each != first for each in others)
    assert b.runtime.segments["bus0"].counters(b.now_ns)["collisions"] > 0


def test_the_seed_says_how():
    assert answers(line(seed=3)) == answers(line(seed=3))
    assert answers(line(seed=3)) != answers(line(seed=4))


def test_a_line_may_have_none_and_each_node_some():
    exact = answers(line(seed=3, reaction_us=0))
    assert all(each == exact[0] for each in exact)
    apart = answers(line(seed=3, duplicate=False, reaction_us=50))
    delays = [each[0][0] for each in apart]
    base_ns = answers(line(duplicate=False))[0][0][0]
    assert len(set(delays)) > 1
    assert all(0 <= delay - base_ns <= 50_000 for delay in delays)


def test_a_modbus_node_has_its_own():
    segment = {"modbus": {"units": {"m1": 1}}, "baud": 19200, "taps": {"m": {"port": "memory"}}}
    devices = {"m1": {"profile": "modbus_drive"}}
    made = {"bench": "t", "devices": devices, "segments": {"bus0": {**segment, "reaction_us": 80}}}

    def delays(config):
        b = Bench(config)
        b.run(ms=100)
        found = []
        for _ in range(4):
            at_ns = b.now_ns
            b.tap("bus0.m").write(REQUEST)
            b.run(ms=100)
            found.append(b.tap("bus0.m").read_timed()[0][0] - at_ns)
        return found

    some = delays(made)
    (exact,) = set(delays({**made, "segments": {"bus0": segment}}))
    assert len(set(some)) > 1
    assert all(0 <= each - exact <= 80_000 for each in some)


@pytest.mark.parametrize("value", [-1, 200_000, "much"])
def test_a_wrong_spread_is_refused(value):
    with pytest.raises(Exception, match="reaction_us"):
        line(reaction_us=value)
