"""Homing of a Modbus drive: a switch on its way, and a map with a command and states for it."""

import pytest

from bridges.modbus.protocol.frame import encode
from hil.testing import Bench

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
