"""A line of another framing than the boards', by what a tap says."""

import pytest

from bridges.modbus.protocol.frame import encode
from hil.testing import Bench
from hil.vocab.faults import FaultRefused

CONFIG = {
    "bench": "f",
    "devices": {"s1": {"profile": "sac"}},
    "segments": {
        "bus0": {"taps": {"a": {"port": "memory", "framing": "modbus_rtu"}, "b": {"port": "memory"}}},
        "bus1": {"stations": ["s1"], "taps": {"c": {"port": "memory"}}},
    },
}


def test_frames_are_counted_as_the_tap_says():
    b = Bench(CONFIG)
    frame = encode(17, 3, b"\0\x6b\0\3")
    b.tap("bus0.a").write(frame)
    b.run(ms=10)
    b.tap("bus0.b").write(frame[:-1] + b"\0")
    b.run(ms=10)
    assert b.tap("bus0.b").read() == frame
    counters = b.segment("bus0").counters(1)
    assert (counters["packets"], counters["errors"]) == (2, {"CRC": 1})
    assert [b.segment(name).framing.name for name in ("bus0", "bus1")] == ["modbus_rtu", "sac"]


def test_faults_are_those_of_its_framing():
    b = Bench(CONFIG)
    with pytest.raises(FaultRefused, match="packet_nak means nothing on a line of modbus_rtu"):
        b.fault("packet_nak", "bus0.a")
    with pytest.raises(FaultRefused, match="node_clash means nothing"):
        b.fault("node_clash", "bus0", address=17)
    b.fault("packet_bad_crc", "bus0.a")
    b.tap("bus0.a").write(encode(17, 3))
    b.run(ms=10)
    assert b.segment("bus0").counters(1)["errors"] == {"CRC": 1}
    b.fault("packet_nak", "bus1.c")


def test_a_line_without_boards_has_bytes_between_silences():
    taps = {name: {"port": "memory"} for name in "ab"}
    b = Bench({"bench": "f", "devices": CONFIG["devices"], "segments": {"bus0": {"taps": taps}}})
    assert b.segment("bus0").framing.name == "bytes"
    for _ in range(2):
        b.tap("bus0.a").write(b"#01RD0\r\n")
        b.run(ms=10)
    assert b.tap("bus0.b").read() == b"#01RD0\r\n" * 2
    counters = b.segment("bus0").counters(1)
    assert (counters["packets"], counters["errors"]) == (2, {})
    with pytest.raises(FaultRefused, match="packet_nak means nothing on a line of bytes"):
        b.fault("packet_nak", "bus0.a")
