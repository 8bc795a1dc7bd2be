"""Faults of switches along axes: what the pin and a card have of them, in any order, and in a replay."""

import io

import pytest

from hil.compose.replay import replay
from hil.config import ConfigError
from hil.sim.faults.fitting import fault_places
from hil.testing import Bench
from hil.vocab.faults import FAULT_KINDS, SWITCH, FaultRefused

HOME = {"axis": "s1", "to_deg": -90, "to": "s1.sync"}
CONFIG = {"bench": "t", "devices": {"s1": {"profile": "sac"}}, "switches": {"home": HOME}}


def config(**switch):
    return CONFIG | {"switches": {"home": HOME | switch}}


def started(**switch):
    made = Bench(config(**switch))
    made.run(ms=2500)
    return made


def level(b):
    return b.axis("s1").snapshot().pin_sync


def active(b):
    return b.runtime.parts.switches["home"].is_active


def test_it_is_a_place_with_its_kinds():
    b = started()
    kinds = {kind.name for kind in FAULT_KINDS.values() if kind.target == SWITCH}
    (place,) = (each for each in fault_places(b.runtime.parts) if each.sort == "switch")
    assert (place.place, place.of, set(place.kinds)) == ("s1.home", "s1", kinds)
    with pytest.raises(
        FaultRefused, match=r"switch_stuck: s1 is no switch along an axis; there are s1\.home"
    ):
        b.fault("switch_stuck", "s1")
    with pytest.raises(FaultRefused, match=r"shaft_jam"):
        b.fault("shaft_jam", "s1.home")


@pytest.mark.parametrize("contact", ["normally_open", "normally_closed"])
@pytest.mark.parametrize("closed", ["low", "high"])
@pytest.mark.parametrize("held", ["open", "closed"])
def test_a_contact_that_is_stuck(contact, closed, held):
    b = started(contact=contact, closed=closed)
    well = level(b), active(b)
    fault = b.fault("switch_stuck", "s1.home", contact=held)
    assert level(b) == ((held == "closed") is (closed == "high"))
    assert active(b) is ((held == "closed") is (contact == "normally_open"))
    fault.clear()
    assert (level(b), active(b)) == well


def test_a_broken_wire_wins_over_a_contact_that_is_stuck_closed():
    b = started()
    stuck = b.fault("switch_stuck", "s1.home", contact="closed")
    assert level(b) == 0
    broken = b.fault("switch_wire_broken", "s1.home")
    assert level(b) == 1
    stuck.clear()
    stuck = b.fault("switch_stuck", "s1.home", contact="closed")
    assert level(b) == 1
    broken.clear()
    assert level(b) == 0
    stuck.clear()
    assert level(b) == 1


def test_a_motor_runs_over_a_switch_that_is_stuck_open():
    b = started(to="s1.Estop")
    b.fault("switch_stuck", "s1.home")
    b.port("s1").write(b"m-300v120\r")
    b.run(ms=6000)
    assert b.axis("s1").snapshot().position_deg < -300


def test_a_switch_that_has_moved_works_at_its_new_place_and_moves_add_up():
    def stands_deg(*moves_deg):
        b = started(to="s1.Estop")
        for by_deg in moves_deg:
            b.fault("switch_moved", "s1.home", by_deg=by_deg)
        b.port("s1").write(b"m-300v30\r")
        b.run(ms=6000)
        return b.axis("s1").snapshot().position_deg

    assert stands_deg() == pytest.approx(-90, abs=1.8)
    assert stands_deg(-45) == pytest.approx(-135, abs=1.8)
    assert stands_deg(-45, 90) == pytest.approx(-45, abs=1.8)


def test_a_shaft_that_rests_is_held_by_a_switch_that_comes_to_it():
    b = started()
    fault = b.fault("switch_moved", "s1.home", by_deg=100, start_s=0.5, for_s=0.5)
    b.run(ms=499)
    assert not active(b)
    b.run(ms=2)
    assert active(b)
    assert level(b) == 0
    b.run(ms=600)
    assert not active(b)
    assert not fault.is_active


def test_a_replay_has_it_again():
    log, took = io.StringIO(), []
    with Bench(config(bounce_ms=2)) as b:
        axis = b.runtime.parts.axis("s1")
        axis.record_input_edges(True)
        b.run(ms=2500)
        b.fault("switch_stuck", "s1.home", contact="closed", for_s=0.3)
        b.fault("switch_moved", "s1.home", by_deg=30)
        b.port("s1").write(b"m-300v60\r")
        b.run(ms=4000)
        took = axis.take_input_edges()
        b.inputs.write_to(log)
    assert len(took) >= 5
    replayed = replay(log.getvalue().splitlines(keepends=True))
    assert replayed.difference() is None


def test_faults_of_a_configuration_and_names():
    fault = {"fault": "switch_stuck", "target": "s1.home", "contact": "closed"}
    b = Bench(CONFIG | {"faults": [fault]})
    b.run(ms=2500)
    assert level(b) == 0
    wrong = {"fault": "switch_stuck", "target": "s1.hom"}
    with pytest.raises(ConfigError, match=r'there is no "s1\.hom" here \(did you mean "s1\.home"'):
        Bench(CONFIG | {"faults": [wrong]})
    switches = {"network": HOME}
    with pytest.raises(ConfigError, match=r"s1\.network is another part of s1 already"):
        Bench(CONFIG | {"switches": switches})
