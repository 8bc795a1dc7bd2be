"""Each kind of fault: its effect at a port, and that nothing of it is left when it is cleared."""

import re

import pytest

from device_profiles.sac.packet import Malformed, PacketDecoder, encode
from hil.sim.bench import BenchHooks
from hil.sim.faults.fitting import fault_places
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench
from hil.vocab.faults import (
    BUS_PART,
    CAN_NODE,
    FAULT_KINDS,
    MODBUS_NODE,
    OWN_FIELD,
    PROCESSOR,
    SWITCH,
    FaultRefused,
)

CONFIG = {
    "bench": "f",
    "devices": {
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "m2": {"profile": "mechaduino", "flash": {"table": "identity"}, "plant": "full"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "memory"}}}},
}
ASK_MS = 30.0
ACK, NAK = b"\x06", b"\x15"


class Rig:
    def __init__(self, config=CONFIG):
        self.bench = Bench(config)
        self.master = self.bench.tap("bus0.master")
        self.terminal = self.bench.port("s1")
        self.bench.run(ms=1100)
        self.bench.port("s2").write(b"$CM86\r")
        self.bench.run(ms=100)
        self.bench.port("s2").write(b"$R\r")
        self.bench.run(ms=3000)
        for name in CONFIG["devices"]:
            self.bench.port(name).read()

    def ask(self, data=b"y", address=85, ms=ASK_MS):
        """Send a packet, and return the answers: data of good packets, or what is wrong with others."""
        self.master.write(encode(address, 1, data))
        self.bench.run(ms=ms)
        decoder = PacketDecoder()
        items = decoder.feed(self.master.read())
        return [
            item.fault if isinstance(item, Malformed) else item.data if item.is_good else "CRC"
            for item in items
        ] + ([decoder.pending] if decoder.pending else [])

    def type(self, line, ms=100.0, device="s1"):
        port = self.bench.port(device)
        port.write(line.encode())
        self.bench.run(ms=ms)
        return port.read()

    def is_well(self):
        assert self.ask() == [ACK]
        assert self.ask(address=86) == [ACK]
        assert self.type("vd\r") == b"vd\r\n0\t0\r\nSAC>"
        assert b" , Angle: " in self.type("p", 200, "m1")
        assert self.bench._runtime.faults.active == {}


@pytest.fixture
def rig():
    return Rig()


# What each kind does on this rig: (target, parameters, how it is seen).
def _terminal(rig):
    return rig.type("vd\r") != b"vd\r\n0\t0\r\nSAC>"


def _answer(rig):
    return rig.ask() != [ACK]


def _late(rig):
    start_ns = rig.bench.now_ns
    rig.terminal.write(b"\r")
    rig.bench.run(ms=500)
    rig.terminal.read()
    return rig.terminal.timeline[-1][0] - start_ns > 30_000_000


def _collides(rig):
    before = rig.bench.segment("bus0").counters(1)["collisions"]
    rig.ask(ms=300)
    return rig.bench.segment("bus0").counters(1)["collisions"] > before


def _encoder(rig):
    rig.bench.device("m1")
    before = rig.type("p", 200, "m1")
    rig.bench.axis("m1").load_torque_Nm = 0.3
    rig.bench.run(ms=500)
    after = rig.type("p", 200, "m1")
    rig.bench.axis("m1").load_torque_Nm = 0.0
    rig.bench.run(ms=2000)
    return before.partition(b"raw")[2] == after.partition(b"raw")[2]


def _moved(rig):
    before = rig.bench.axis("m1").snapshot().position_deg
    rig.bench.run(ms=500)
    return abs(rig.bench.axis("m1").snapshot().position_deg - before) > 0.1


def _position(rig):
    return rig.bench.axis("m1").snapshot().position_deg


def _pushed(rig):
    before = _position(rig)
    rig.bench.axis("m1").load_torque_Nm = 0.3
    rig.bench.run(ms=300)
    after = _position(rig)
    rig.bench.axis("m1").load_torque_Nm = 0.0
    return abs(after - before) > 0.1


def _currents(rig, name="m1"):
    """Currents of both coils after a step, which energises them."""
    rig.type("s", 300, name)
    shot = rig.bench.axis(name).snapshot()
    return shot.current_a_A, shot.current_b_A


def _raw(rig, ms=0.0):
    rig.bench.run(ms=ms)
    return rig.bench.axis("m1").snapshot().raw


def _shaft_count(rig):
    return int(_position(rig) / 360 % 1 * 16384)


def _started_again(rig):
    rig.bench.run(ms=1100)
    return rig.terminal.read().endswith(b"SAC 1.0\r\nSAC>")


SEEN = {
    "byte_flip": ("s1", {"rate": 0.5}, _terminal),
    "byte_drop": ("s1", {"rate": 0.5, "towards": "board"}, _terminal),
    "byte_duplicate": ("s1", {"rate": 1.0}, _terminal),
    "byte_delay": ("s1", {"rate": 1.0, "delay_ms": 30}, _late),
    "host_stop_reading": ("s1", {}, lambda rig: rig.type("m9ad\r") == b"" and rig.bench.run(1000) is None),
    "host_close": ("s1", {}, lambda rig: rig.type("\r") == b""),
    "packet_bad_crc": ("s1.network", {}, lambda rig: rig.ask() == ["CRC"]),
    "packet_no_ack": ("s1.network", {}, lambda rig: rig.ask() == []),
    "packet_nak": ("s1.network", {}, lambda rig: rig.ask() == [NAK]),
    "wire_noise": ("bus0", {"rate": 0.3}, _answer),
    "wire_cut": ("s1.network", {}, lambda rig: (rig.ask(), rig.ask(address=86)) == ([], [ACK])),
    "wire_swapped": ("s1.network", {}, _answer),
    "driver_stuck": ("s2.network", {}, lambda rig: rig.ask() == []),
    "driver_late": ("bus0.master", {"late_us": 2000}, _answer),
    "node_babble": ("s2.network", {"bytes": 50, "every_ms": 5}, _collides),
    "node_clash": ("bus0", {"address": 85}, _collides),
    "node_reset": ("s1", {}, _started_again),
    "node_brown_out": ("s1", {}, lambda rig: (rig.ask(), rig.type("\r")) == ([], b"")),
    "node_hang": ("s1", {}, lambda rig: (rig.ask(), rig.type("\r")) == ([], b"")),
    "shaft_load": ("m1", {"torque_Nm": 0.3}, _moved),
    "shaft_jam": ("m1", {}, lambda rig: not _pushed(rig)),
    "steps_lost": ("m1", {"turn_deg": -7.2}, lambda rig: _position(rig) < 0),
    "phase_open": ("m1", {"coil": "A"}, lambda rig: [_currents(rig)[0] for _ in range(2)] == [0, 0]),
    "phase_swapped": ("m1", {"coil": "A"}, lambda rig: _currents(rig)[0] < 0),
    "motor_unplugged": ("m1", {}, lambda rig: _currents(rig) == (0, 0)),
    "motor_power_off": ("m1", {}, lambda rig: _currents(rig) == (0, 0)),
    "thermal_trip": ("m1", {}, lambda rig: _currents(rig) == (0, 0)),
    "supply_sag": ("m2", {"supply_V": 0.0}, lambda rig: max(map(abs, _currents(rig, "m2"))) < 0.01),
    "encoder_slip": ("m1", {"counts": 100}, lambda rig: _raw(rig) == (_shaft_count(rig) + 100) % 16384),
    "encoder_noise": ("m1", {"counts": 5}, lambda rig: len({_raw(rig, 1.0) for _ in range(20)}) > 5),
    "encoder_freeze": ("m1", {}, _encoder),
    "encoder_disconnect": ("m1", {}, lambda rig: b"raw encoder: 16383" in rig.type("p", 200, "m1")),
}


def test_each_kind_of_the_table_has_its_test():
    # Those of Modbus nodes are seen in test_kit_modbus_faults.py, those of CAN nodes in test_kit_canbus.py,
    # those of parts on an arm's bus in test_walter_arm.py, those of processors in test_processor.py, those of
    # a board's own fields in test_kit_own_fields.py, those of switches in test_kit_switches.py.
    others = (MODBUS_NODE, CAN_NODE, BUS_PART, PROCESSOR, OWN_FIELD, SWITCH)
    assert set(SEEN) == {kind.name for kind in FAULT_KINDS.values() if kind.target not in others}


@pytest.mark.parametrize("kind", SEEN)
def test_a_fault_is_seen_and_undone(rig, kind):
    target, parameters, is_seen = SEEN[kind]
    rig.is_well()
    fault = rig.bench.fault(kind, target, **parameters)
    assert is_seen(rig)
    fault.clear()
    rig.bench.run(ms=2000)
    rig.master.read()
    rig.terminal.read()
    rig.type("\r")
    rig.is_well()


def test_a_fault_has_its_time(rig):
    fault = rig.bench.fault("packet_no_ack", "s1.network", start_s=1.0, for_s=0.5)
    assert rig.ask() == [ACK]
    rig.bench.run(ms=1000)
    assert rig.ask() == []
    assert fault.is_active
    rig.bench.run(ms=500)
    assert not fault.is_active
    assert rig.ask() == [ACK]
    fault.clear()


def test_a_fault_comes_again_until_it_is_cleared(rig):
    fault = rig.bench.fault("packet_no_ack", "s1.network", for_s=0.5, every_s=2.0)
    for _ in range(2):
        assert rig.ask() == []
        rig.bench.run(ms=1000)
        assert rig.ask() == [ACK]
        assert fault.is_active
        rig.bench.run(ms=1000 - 2 * ASK_MS)
    assert rig.ask() == []
    fault.clear()
    assert rig.ask() == [ACK]
    rig.bench.run(ms=4000)
    assert rig.ask() == [ACK]


def test_what_happens_once_comes_again(rig):
    before_deg = rig.bench.axis("m2").snapshot().position_deg
    with rig.bench.fault("steps_lost", "m2", turn_deg=7.2, every_s=0.1) as fault:
        rig.bench.run(ms=250)
        assert fault.is_active
        after_deg = rig.bench.axis("m2").snapshot().position_deg
    assert after_deg - before_deg == pytest.approx(21.6, abs=1)
    rig.bench.run(ms=250)
    assert rig.bench.axis("m2").snapshot().position_deg == pytest.approx(after_deg, abs=1)


@pytest.mark.parametrize(
    ("kind", "parameters", "why"),
    [
        ("packet_no_ack", {"every_s": 1.0}, "every_s: say for how long each time: for_s"),
        ("packet_no_ack", {"every_s": 1.0, "for_s": 1.0}, "every_s: it lasts 1 s: write more than that"),
        ("packet_no_ack", {"every_s": 1e-4}, "every_s: write 0, or at least 0.001 s"),
        ("node_reset", {"every_s": 1.0, "for_s": 0.1}, "every_s: it is over at once: leave for_s out"),
    ],
)
def test_a_fault_that_cannot_come_again(rig, kind, parameters, why):
    with pytest.raises(FaultRefused, match=re.escape(why)):
        rig.bench.fault(kind, "s1.network" if kind.startswith("packet") else "s1", **parameters)


def test_places_have_the_kinds_that_fit_them(rig):
    rows = {row.place: row for row in fault_places(rig.bench._runtime.parts)}
    kinds = {name: set(row.kinds) for name, row in rows.items()}
    assert {"byte_flip", "shaft_jam", "node_hang"} <= kinds["s1"]
    assert not {"encoder_freeze", "modbus_late", "wire_noise", "chip_bit_flip"} & kinds["s1"]
    assert {"wire_cut", "packet_nak"} <= kinds["s1.network"]
    assert kinds["bus0"] == {"wire_noise", "node_clash"}
    assert (rows["s1.network"].of, rows["s1.network"].wire, rows["s1.network"].sort) == ("s1", "bus0", "port")
    assert (rows["bus0.master"].of, rows["bus0.master"].sort) == ("bus0", "tap")
    assert (rows["bus0"].of, rows["bus0"].sort) == ("", "wire")


def test_a_fault_cleared_before_it_begins_does_not(rig):
    with rig.bench.fault("packet_no_ack", "s1.network", start_s=0.1):
        pass
    rig.bench.run(ms=200)
    assert rig.ask() == [ACK]


def test_a_brown_out_loses_the_session_and_keeps_the_eeprom(rig):
    rig.type("$Cd2.5\r")
    rig.bench.fault("node_brown_out", "s1", for_s=2.0)
    assert rig.bench.device("s1").failed == "no power (fault 1)"
    rig.bench.run(ms=3200)
    assert rig.terminal.read() == b"SAC 1.0\r\nSAC>"
    assert b"d acc\t\t2.50" in rig.type("cc\r", 300)


def test_a_hung_board_goes_on_where_it_was(rig):
    with rig.bench.fault("node_hang", "s1"):
        rig.type("vd\r")
    rig.bench.run(ms=100)
    assert rig.terminal.read() == b"vd\r\n0\t0\r\nSAC>"


@pytest.mark.parametrize(
    ("kind", "target", "parameters", "why"),
    [
        ("node_hang", "s9", {}, "there is no 's9'; there are s1, s2, m1, m2, s1.network"),
        ("encoder_freeze", "s1", {}, "encoder_freeze: s1 has no encoder; "),
        (
            "packet_nak",
            "m1",
            {},
            "packet_nak: m1 is on no segment",
        ),
        ("wire_noise", "s1", {"rate": 0.1}, "wire_noise: s1 is no segment and no CAN bus"),
        ("byte_flip", "s1", {}, "rate: this one is missing"),
        ("byte_flip", "s1", {"rate": "much"}, 'rate: "much" is no number; write 0 to 1'),
        ("byte_flip", "s1", {"rate": 1, "rte": 1}, "rte: there is no such parameter; did you mean \"rate\""),
        ("byte_flip", "s1", {"rte": 1}, "rte: there is no such parameter; did you mean"),
        ("byte_flip", "s9", {}, "there is no 's9'; "),
        ("byte_flop", "s1", {}, "there is no fault 'byte_flop'; did you mean \"byte_flip\"? kinds"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(rig, kind, target, parameters, why):
    with pytest.raises(FaultRefused) as caught:
        rig.bench.fault(kind, target, **parameters)
    assert str(caught.value).startswith(why)


def test_faults_of_the_configuration_are_there_from_the_start():
    rig = Rig(CONFIG | {"faults": [{"fault": "packet_no_ack", "target": "s1.network", "start_s": 5.0}]})
    assert rig.ask() == [ACK]
    rig.bench.run(ms=2000)
    assert rig.ask() == []


def test_the_same_seed_gives_the_same_bytes():
    def run(seed):
        rig = Rig()
        rig.bench.fault("byte_flip", "s1", rate=0.01, seed=seed)
        rig.bench.fault("wire_noise", "bus0", rate=0.01, seed=seed)
        rig.type("q\r", 2000)
        rig.ask()
        return rig.terminal.timeline, rig.bench.segment("bus0").counters(1)

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_faults_stand_in_the_log(tmp_path):
    from hil.compose.replay import replay
    from hil.sim.inputs import Bytes

    path = tmp_path / "log.jsonl"
    with path.open("w") as file:
        bench = Bench(CONFIG, around=BenchHooks(log=InputLogWriter(file, "test", CONFIG, {})))
        bench.run(ms=1100)
        bench.fault("byte_flip", "s1", rate=0.02, seed=5)
        bench.fault("node_babble", "bus0.master", start_s=0.5, for_s=1.0)
        fault = bench.fault("node_clash", "bus0", address=85)
        bench._runtime.apply_to(bench._runtime.devices["s1"], Bytes(b"q\r"))
        bench.tap("bus0.master").write(encode(85, 1, b"v99"))
        bench.run(ms=1000)
        fault.clear()
        bench.fault("node_brown_out", "s2", for_s=0.2)
        bench.fault("byte_drop", "s1", rate=0.5, for_s=0.1, every_s=0.3)
        bench.run(ms=3000)
    assert replay(path).difference() is None
