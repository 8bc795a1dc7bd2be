"""Homing of a Modbus drive: switches on its way, methods, and a map with a command and states for it."""

import pytest

from bridges.modbus.protocol.frame import encode
from hil.testing import Bench
from hil.vocab.verbs import VerbRefused

MAP = {
    "modbus_map": 2,
    "position_deg": {"input": 0, "type": "i32", "scale": 0.01},
    "set_velocity_rpm": {"holding": 2},
    "set_point_deg": {"holding": 0, "type": "i32", "scale": 0.01},
    "commands": {"word": {"holding": 10, "values": {"enable": 1, "search_home": 2, "start": 3, "stop": 4}}},
    "states": {"way": {"input": 4, "values": {"homing": 1, "homed": 2}}},
}
ENABLE, SEARCH = (bytes((0, 10, 0, word)) for word in (1, 2))
STATE = bytes((0, 4, 0, 1))


def bench(**switch):
    home = {"axis": "x1", "to_deg": -120, "hysteresis_deg": 0.5, "bounce_ms": 2, "to": "x1.D3"} | switch
    made = Bench(
        {
            "bench": "t",
            "devices": {"x1": {"profile": "modbus_drive", "map": MAP}},
            "segments": {"bus0": {"modbus": {"units": {"x1": 1}}, "baud": 115200, "taps": {"m": {}}}},
            "switches": {"home": home},
        }
    )
    made.run(ms=300)
    return made


def ask(made, function, data):
    """Data of the answer to a request of a master on the line."""
    tap = made.tap("bus0.m")
    tap.read()
    tap.write(encode(1, function, data))
    made.run(ms=20)
    return tap.read()[2:-2]


def test_a_master_homes_by_a_command_and_sees_how_it_goes():
    b = bench()
    assert ask(b, 6, ENABLE) == ENABLE
    assert ask(b, 6, SEARCH) == SEARCH
    assert ask(b, 4, STATE) == bytes((2, 0, 1))
    b.run(ms=8000)
    assert ask(b, 4, STATE) == bytes((2, 0, 2))
    stands_deg = b.axis("x1").snapshot().position_deg
    position = int.from_bytes(ask(b, 4, bytes((0, 0, 0, 2)))[1:], "big", signed=True)
    assert position / 100 == pytest.approx(stands_deg + 119.5, abs=0.2)


def told(b, name):
    return b.runtime.devices["x1"].told.get(name)


def test_the_edge_is_its_zero_and_states_tell_how_it_does():
    b = bench()
    b.axis("x1").do("enable")
    b.axis("x1").do("search_home")
    b.run(ms=50)
    assert told(b, "homing") == 1
    b.run(ms=8000)
    assert told(b, "homing") is None
    assert told(b, "homed") == 1
    assert told(b, "origin_deg") == pytest.approx(-120 + 0.5, abs=0.1)


def test_another_motion_ends_the_search():
    b = bench()
    b.axis("x1").do("enable")
    b.axis("x1").do("search_home")
    b.run(ms=200)
    b.axis("x1").do("stop", how="grace")
    b.run(ms=2000)
    assert told(b, "homed") is None
    assert told(b, "homing") is None
    assert told(b, "origin_deg") is None


def test_it_begins_on_the_switch_and_comes_off_it():
    b = bench(to_deg=20)
    b.axis("x1").do("enable")
    b.axis("x1").do("search_home")
    b.run(ms=8000)
    assert told(b, "homed") == 1
    assert told(b, "origin_deg") == pytest.approx(20.5, abs=0.1)


LOWER = {"axis": "x1", "to_deg": -200, "contact": "normally_closed", "to": "x1.D0"}
UPPER = {"axis": "x1", "from_deg": 400, "contact": "normally_closed", "to": "x1.D1"}
CAM = {"axis": "x1", "from_deg": 100, "to_deg": 110, "to": "x1.D3"}
HOMING = {"homing_method": {"holding": 7}} | {
    name: {"holding": address, "scale": 0.1}
    for name, address in (("homing_velocity_rpm", 8), ("homing_slow_rpm", 9))
}


def machine(map_=MAP | HOMING):
    made = Bench(
        {
            "bench": "t",
            "devices": {"x1": {"profile": "modbus_drive", "map": map_}},
            "segments": {"bus0": {"modbus": {"units": {"x1": 1}}, "baud": 115200, "taps": {"m": {}}}},
            "switches": {"lower": LOWER, "upper": UPPER, "cam": CAM},
        }
    )
    made.run(ms=300)
    made.axis("x1").do("enable")
    return made


def searched(b, method, seconds=30, rpm=120, slow_rpm=6):
    b.axis("x1").do("search_home", method=method, velocity_rpm=rpm, slow_rpm=slow_rpm)
    for _ in range(seconds * 10):
        b.run(ms=100)
        if told(b, "homing") is None:
            return told(b, "origin_deg")
    raise AssertionError("it still searches")


@pytest.mark.parametrize(
    ("method", "home_deg"),
    [
        *((17, -200), (18, 400), (20, 100), (24, 100), (28, 110), (29, 100)),
        *((1, 0), (2, 360), (9, 0), (10, 360), (34, 360)),
    ],
)
def test_it_homes_by_each_switch_and_by_the_index(method, home_deg):
    """At 6 rpm it looks every 0.036 deg; at a limit switch the shaft is a following error off."""
    b = machine()
    found_deg = searched(b, method) or 0.0
    assert found_deg == pytest.approx(home_deg, abs=0.08)
    assert told(b, "homed") == 1
    assert told(b, "home_missed") is None


def test_a_limit_on_the_way_is_an_error_where_the_method_does_not_turn_back():
    b = machine()
    assert searched(b, 21) is None
    assert told(b, "home_missed") == 1
    assert told(b, "homed") is None
    assert b.axis("x1").snapshot().position_deg < -200
    assert searched(b, 23) == pytest.approx(100, abs=0.08)


def test_a_broken_wire_of_a_limit_switch_ends_the_search_at_once():
    b = machine()
    b.fault("switch_wire_broken", "x1.upper")
    assert searched(b, 20, seconds=3) is None
    assert told(b, "home_missed") == 1


def test_a_motion_stops_at_a_limit_switch_and_may_leave_it():
    b = machine()
    b.axis("x1").do("move_abs", position_deg=900)
    b.run(ms=4000)
    stands_deg = b.axis("x1").snapshot().position_deg
    assert 400 < stands_deg < 450
    assert not b.axis("x1").snapshot().following
    b.axis("x1").do("run", velocity_rpm=60)
    b.run(ms=500)
    assert b.axis("x1").snapshot().position_deg < 500
    b.axis("x1").do("move_abs", position_deg=0)
    b.run(ms=4000)
    assert b.axis("x1").snapshot().position_deg == pytest.approx(0, abs=1)


def test_a_master_sets_method_and_speeds():
    b = machine()

    def write(address, value):
        data = bytes((0, address)) + value.to_bytes(2, "big")
        return ask(b, 6, data) == data

    assert ask(b, 3, bytes((0, 7, 0, 1))) == bytes((2, 0, 21))
    assert write(7, 17)
    assert write(8, 1200)
    assert ask(b, 3, bytes((0, 9, 0, 1))) == bytes((2, 0, 120))
    assert write(9, 60)
    assert not write(7, 15)
    assert ask(b, 3, bytes((0, 7, 0, 3))) == bytes((6, 0, 17, 4, 176, 0, 60))
    assert write(10, 2)
    b.run(ms=10000)
    assert told(b, "origin_deg") == pytest.approx(-200, abs=0.08)


def test_a_method_that_is_none_is_refused():
    b = machine()
    with pytest.raises(VerbRefused, match=r"method: 16 is no homing method; there are 1, 2, 3"):
        b.axis("x1").do("search_home", method=16)


def test_a_control_word_of_cia_402_searches_home():
    words = {
        "commands": {"control_word": {"holding": 20, "standard": "cia402", "reads": "written"}},
        "mode": {"holding": 21, "values": {"absolute": 1, "search_home": 6}, "value": 6},
        "states": {"status_word": {"holding": 22, "standard": "cia402"}},
    }
    b = machine(MAP | HOMING | words)
    control, status = (20).to_bytes(2, "big"), bytes((0, 22, 0, 1))
    assert ask(b, 6, bytes((0, 7, 0, 28)))
    for word in (6, 7, 15, 31):
        assert ask(b, 6, control + bytes((0, word)))
    assert int.from_bytes(ask(b, 3, status)[1:], "big") & 0x3400 == 0
    b.run(ms=20000)
    assert int.from_bytes(ask(b, 3, status)[1:], "big") & 0x3400 == 0x1400
    assert told(b, "origin_deg") == pytest.approx(110, abs=0.08)
