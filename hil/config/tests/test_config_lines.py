"""Network ports, segments, real boards and faults in a configuration."""

from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, from_dict, parse, schema
from hil.config.port_kinds import segment_speeds
from hil.vocab.segment import speed_notes

CATALOGUE = find_catalogue()
SAC = {"profile": "sac"}
PROGRAM = Path(__file__).parents[3] / "examples/own_sketch/bare/bare_node.hex"


def problems(**top):
    with pytest.raises(ConfigError) as caught:
        from_dict({"bench": "t", **top}, CATALOGUE)
    return [f"{problem.message.partition(': ')[2]} ({problem.remedy})" for problem in caught.value.problems]


def test_a_whole_bench_with_lines():
    text = """
bench: t
devices:
  s1: {profile: sac, network: pty}
  s2: {profile: sac}
  s3: {profile: sac, at: /dev/ttyUSB0, baud: 9600}
  m1: {profile: mechaduino, at: "rfc2217://box:7000", port: tcp}
segments:
  bus0: {stations: [s1, s2.main]}
faults:
  - {fault: byte_flip, target: s3, rate: 0.001, towards: board}
"""
    config = parse(text, "b.yaml", CATALOGUE)
    assert list(config.twins) == ["s1", "s2"]
    assert [(device.at, device.baud) for device in config.real.values()] == [
        ("/dev/ttyUSB0", 9600),
        ("rfc2217://box:7000", 115200),
    ]
    assert config.segments["bus0"].addresses() == [("s1", ""), ("s2", "main")]
    assert config.faults[0].model_extra == {"rate": 0.001, "towards": "board"}


@pytest.mark.parametrize(
    ("device", "problem"),
    [
        ({"at": "ttyUSB0"}, "this is no serial port (write a path as in /dev/ttyUSB0, socket://host:port or"),
        (
            {"at": "http://x:1"},
            "this is no serial port (write a path as in /dev/ttyUSB0, socket://host:port or"
            " rfc2217://host:port; of a CANopen drive can+socketcan://can0?node=5, of a Modbus drive",
        ),
        ({"at": "socket://x"}, "this is no serial port"),
        ({"at": ""}, "this is no serial port"),
        ({"at": 5}, "YAML takes this for the number 5"),
        (
            {"at": "/dev/ttyUSB0", "plant": "full"},
            "a real board (at: /dev/ttyUSB0) has its own (",
        ),
        ({"at": "/dev/ttyUSB0", "axis": {"start_deg": 3}}, "a real board"),
        ({"at": "/dev/ttyUSB0", "network": "pty"}, "a real board"),
        ({"network": "ptty"}, 'there is no kind of port "ptty" (did you mean "pty"?'),
        ({"network": {"kind": "tcp", "lsten": 1}}, 'unknown key (did you mean "listen"?'),
    ],
)
def test_a_device_that_cannot_be(device, problem):
    (said,) = problems(devices={"s1": SAC | device})
    assert said.startswith(problem)


def test_a_mechaduino_has_no_network():
    (said,) = problems(devices={"m1": {"profile": "mechaduino", "network": "pty"}})
    assert said == "a mechaduino has no second serial interface (leave this key out)"


def test_two_ports_in_one_place():
    (said,) = problems(devices={"s1": SAC | {"network": {"kind": "pty", "path": "s1"}}})
    assert said.startswith("device s1 has its port in the same place")
    (said,) = problems(devices={"s1": SAC | {"at": "/dev/x"}, "s2": SAC | {"at": "/dev/x"}})
    assert said == "device s1 is there (each board has its own port)"


@pytest.mark.parametrize(
    ("stations", "problem"),
    [
        (["s1", "s9"], 'there is no device "s9" (known are: m1, s1, s2)'),
        (["s1.netwrk"], 's1 has no serial interface "netwrk" (did you mean "network"?'),
        (["m1"], "a mechaduino has no network"),
        (["m1.main"], "the serial interface of a mechaduino is USB"),
        (["s1", "s1.network"], "s1.network is on segment bus0 already"),
        (["s2"], "s2 is a real board"),
    ],
)
def test_a_segment_that_cannot_be(stations, problem):
    devices = {"s1": SAC, "m1": {"profile": "mechaduino"}, "s2": SAC | {"at": "/dev/x"}}
    (said,) = problems(devices=devices, segments={"bus0": {"stations": stations}})
    assert said.startswith(problem)


def test_a_wire_to_a_real_board():
    devices = {"s1": SAC, "s2": SAC | {"at": "/dev/x"}}
    (said,) = problems(devices=devices, wires=[{"from": "s1.clk", "to": "s2.sync"}])
    assert said.startswith("s2 is a real board")


@pytest.mark.parametrize(
    ("fault", "problem"),
    [
        ({"fault": "byte_flp", "target": "s2", "rate": 0.1}, 'there is no fault "byte_flp" (did you'),
        ({"fault": "byte_flip", "target": "s7", "rate": 0.1}, 'there is no "s7" here'),
        ({"fault": "node_hang", "target": "s2"}, 'node_hang cannot be on "s2" (write a twin: s1'),
        ({"fault": "encoder_freeze", "target": "s1"}, 'encoder_freeze cannot be on "s1" (write a twin with'),
        ({"fault": "packet_nak", "target": "s1"}, 'packet_nak cannot be on "s1" (write a twin\'s port on'),
        ({"fault": "wire_cut", "target": "s1", "for_s": -1}, 'wire_cut cannot be on "s1"'),
        ({"fault": "byte_flip", "target": "s2"}, "this key is missing"),
        ({"fault": "byte_flip", "target": "s2", "rate": 2}, "2 is too large (write 0 to 1)"),
        ({"fault": "byte_flip", "target": "s2", "rate": "x"}, '"x" is no number (write 0 to 1)'),
        ({"fault": "byte_flip", "target": "s2", "rate": 0.1, "towards": "up"}, 'there is no "up" here'),
        ({"fault": "byte_flip", "target": "s2", "rate": 0.1, "spin": 1}, "there is no such parameter ("),
        ({"target": "s2"}, "this key is missing"),
        ({"fault": "byte_flip", "target": "s2", "rate": 0.1, "for_s": 5}, "s2 is a real board (leave this"),
        ({"fault": "byte_flip", "target": "s2", "rate": 0.1, "start_s": 5}, "s2 is a real board (leave this"),
    ],
)  # fmt: skip
def test_a_fault_that_cannot_be(fault, problem):
    devices = {"s1": SAC, "s2": SAC | {"at": "/dev/x"}}
    said = problems(devices=devices, faults=[fault])
    assert said[0].startswith(problem)


def test_problems_have_their_place_in_the_file():
    text = """bench: t
devices:
  s1: {profile: sac, at: ttyUSB0}
segments:
  bus0:
    stations:
      - s1
      - s7
"""
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", CATALOGUE)
    assert [str(problem).partition(": ")[0] for problem in caught.value.problems] == [
        "b.yaml:3:26", "b.yaml:7:9", "b.yaml:8:9",
    ]  # fmt: skip


def test_the_schema_has_the_keys():
    device = schema(CATALOGUE)["$defs"]["DeviceConfig"]["properties"]
    assert {"type": "null"} in device["network"]["anyOf"]
    assert "at" in device


def test_a_segment_with_a_devices_name():
    (said,) = problems(devices={"s1": SAC}, segments={"s1": {"stations": ["s1"]}})
    assert said.startswith('a device has the name "s1" already')


def tap(framing):
    return {"port": "pty", "framing": framing}


@pytest.mark.parametrize(
    ("segment", "problem"),
    [
        ({"taps": {"a": tap("modbus")}}, 'there is no framing "modbus" (did you mean "modbus_rtu"?'),
        (
            {"stations": ["s1"], "taps": {"a": tap("modbus_rtu")}},
            "bus0 speaks sac already, by s1; this is mod",
        ),
        (
            {"taps": {"a": tap("sac"), "b": tap("modbus_rtu")}},
            "bus0 speaks sac already, by a; this is modbus",
        ),
    ],
)
def test_a_line_speaks_one_framing(segment, problem):
    (said,) = problems(devices={"s1": SAC}, segments={"bus0": segment})
    assert said.startswith(problem)


def test_a_fault_that_means_nothing_in_a_lines_packets():
    segments = {"bus0": {"taps": {"a": tap("modbus_rtu")}}, "bus1": {"stations": ["s1"]}}
    faults = [
        {"fault": "packet_nak", "target": "bus0.a"},
        {"fault": "packet_bad_crc", "target": "bus0.a"},
        {"fault": "node_clash", "target": "bus0", "address": 9},
        {"fault": "packet_nak", "target": "s1.network"},
    ]
    said = problems(devices={"s1": SAC}, segments=segments, faults=faults)
    assert said == [
        f"{kind} means nothing on a line of modbus_rtu (of faults of packets it can have packet_bad_crc)"
        for kind in ("packet_nak", "node_clash")
    ]


@pytest.mark.parametrize("kind", [[], {}, None, 3])
def test_a_fault_on_a_line_whose_kind_is_no_text(kind):
    faults = [{"fault": kind, "target": "s1.network"}]
    (said,) = problems(devices={"s1": SAC}, segments={"bus0": {"stations": ["s1"]}}, faults=faults)
    assert "text" in said


@pytest.mark.parametrize("echo", [None, True, False])
def test_the_echo_of_a_tap_is_that_of_its_adapter_or_its_own(echo):
    taps = {"real": {"port": {"kind": "serial", "url": "/dev/ttyUSB0"}, "echo": echo}, "ours": {"echo": echo}}
    bench = {"bench": "t", "devices": {"s1": SAC}, "segments": {"bus0": {"stations": ["s1"], "taps": taps}}}
    made = from_dict(bench, CATALOGUE).segments["bus0"].taps
    assert made["real"].port.options.echo is echo
    assert not made["real"].hears_itself
    assert made["ours"].hears_itself is (echo is True)


def test_an_echo_is_of_adapters():
    assert problems(devices={"m1": {"profile": "mechaduino", "echo": True}}) == [
        "a twin has no adapter; `echo` of a `serial` port is for one (leave this key out)"
    ]
    at = "modbus+rtu:///dev/ttyUSB0?unit=1"
    _, said = problems(devices={"x": {"profile": "modbus_drive", "at": at, "echo": True}})
    assert said.startswith("a real drive has no such key")


def test_speeds_on_a_segment_are_those_of_its_stations_nodes_and_taps():
    taps = {"here": {}, "real": {"port": {"kind": "serial", "url": "/dev/ttyUSB0", "baud": 9600}}}
    segment = {"stations": ["s1", "s2"], "taps": taps}
    devices = {"s1": {**SAC, "bauds": {"network": 115200}}, "s2": SAC}
    made = from_dict({"bench": "t", "devices": devices, "segments": {"bus0": segment}}, CATALOGUE)
    speeds = segment_speeds(made, "bus0", CATALOGUE.profiles)
    assert speeds == {"s1.network": 115200, "s2.network": 38400, "bus0.here": 115200, "bus0.real": 9600}
    (said,) = speed_notes(speeds)
    assert said.endswith("s1.network, bus0.here 115200 baud; s2.network 38400 baud; bus0.real 9600 baud")


@pytest.mark.parametrize(("fast", "is_told"), [(38_462, False), (39_900, False), (40_000, True)])
def test_a_processors_clock_is_no_speed_of_its_own(fast, is_told):
    assert bool(speed_notes({"u1.main": fast, "s1.network": 38_400, "s2.network": 38_400})) == is_told


def test_the_speed_of_a_program_is_not_known():
    """Nor is it that of the line: a Uno's is 115200 while its program has set none."""
    devices = {"u1": {"profile": "uno", "firmware": str(PROGRAM)}, "s1": SAC}
    segment = {"stations": ["u1", "s1"], "taps": {"here": {}}}
    made = from_dict({"bench": "t", "devices": devices, "segments": {"bus0": segment}}, CATALOGUE)
    assert segment_speeds(made, "bus0", CATALOGUE.profiles) == {"s1.network": 38400, "bus0.here": 38400}
