"""CAN buses, their nodes, switches and taps in a configuration."""

from typing import Any

import pytest

from bridges.can.can_model import SwitchConfig
from hil.compose import find_catalogue
from hil.config import ConfigError, diff, from_dict, parse
from hil.config.schema import schema

CATALOGUE = find_catalogue()
HEAD = """bench: t
devices:
  m1: {profile: mechaduino}
  s1: {profile: sac}
  r1: {profile: mechaduino, at: /dev/ttyUSB0}
segments:
  bus0: {stations: [s1]}
can:
"""
LINES = HEAD.count("\n")


def problem(buses: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse(HEAD + buses, "b.yaml", CATALOGUE)
    (found,) = caught.value.problems
    return f"{found.line - LINES}:{found.column}: {found.message} ({found.remedy})"


@pytest.mark.parametrize(
    ("buses", "said"),
    [
        ("  c: {nodes: {m9: 1}}", '1:15: can.c.nodes.m9: there is no device "m9" (known are: m1,'),
        ("  c: {nodes: {r1: 1}}", "1:15: can.c.nodes.r1: r1 is a real board (nodes here are of twins)"),
        ("  c: {nodes: {m1.x: 1}}", "1:15: can.c.nodes.'m1.x': m1 has no axis 'x'"),
        ("  c: {nodes: {m1: 0}}", "1:19: can.c.nodes.m1: the number 0 is too small (write 1 or more)"),
        ("  c: {nodes: {m1: 128}}", "1:19: can.c.nodes.m1: the number 128 is too large (write 127"),
        ("  c: {nodes: {m1: five}}", "1:19: can.c.nodes.m1: keys are wanted here"),
        ("  c: {nodes: {m1: {}}}", "1:15: can.c.nodes.m1.id: this key is missing"),
        (
            "  c: {nodes: {m1: {id: 5, switch: 1}}}",
            '1:27: can.c.nodes.m1.switch: unknown key (did you mean "',
        ),
        ("  c: {nodes: {m1: 5, s1: 5}}", "1:26: can.c.nodes.s1: node 5 is m1 already (give each an id"),
        ("  c: {nodes: {m1: 5, s1: {id: 5}}}", "1:31: can.c.nodes.s1.id: node 5 is m1 already (give"),
        ("  c: {nodes: {m1: 5}}\n  d: {nodes: {m1: 6}}", "2:15: can.d.nodes.m1: m1 has a node on c already"),
        ("  c: {bit_rate: 9999}", "1:17: can.c.bit_rate: the number 9999 is too small"),
        ("  c: {bit_rate: 1000001}", "1:17: can.c.bit_rate: the number 1000001 is too large"),
        ("  c: {bit_rate: 1e6}", "1:17: can.c.bit_rate: a whole number is wanted"),
        ("  c: {taps: {x: {port: ptty}}}", "1:24: can.c.taps.x.port: there is no kind of port"),
        ("  c: {taps: {x: {listen: true}}}", "1:18: can.c.taps.x.listen: unknown key"),
        ("  c: {taps: {X: {}}}", '1:14: can.c.taps.X: "X" is not a name'),
        ("  m1: {}", '1:3: can.m1: a device has the name "m1" already (give the bus another)'),
        ("  bus0: {}", '1:3: can.bus0: a segment has the name "bus0" already (give the bus another)'),
    ],
)
def test_what_cannot_be_is_said_where_it_stands(buses: str, said: str) -> None:
    assert problem(buses).startswith(said)


@pytest.mark.parametrize(
    ("switches", "said"),
    [
        ("{home: {}}", "home: there is neither a cam nor a pin (write {from_deg: 10, to_deg: 20},"),
        ("{home: {from_deg: 1}}", "home.from_deg: from_deg are no cam"),
        ("{home: {from_deg: 3, above_deg: 2}}", "home.from_deg: from_deg and above_deg are no cam"),
        ("{home: {below_deg: 3, above_deg: 2}}", "home.below_deg: below_deg and above_deg are no cam"),
        ("{home: {from_deg: 3, to_deg: 3}}", "home.to_deg: a cam from 3 to 3 is never under the switch"),
        (
            "{home: {from_deg: 3, to_deg: 2, pin: D3}}",
            "home.pin: a switch is a cam or at a pin, and here are",
        ),
        ("{home: {above_deg: 3, active: low}}", "home.active: a cam has no level (leave this key out)"),
        ("{home: {pin: D9}}", "home.pin: m1 has no input 'D9'"),
        ("{home: {pin: D3, active: up}}", 'home.active: "up" is none of the choices'),
        ("{home: {pin: D3}, negative: {pin: D3}}", "negative.pin: the switch home is at D3 already"),
        ("{homing: {pin: D3}}", 'homing: unknown key (did you mean "home"?)'),
        ("{home: D3}", "home: keys are wanted here"),
        (
            "{negative: {below_deg: 10}, positive: {above_deg: -10}}",
            "positive.above_deg: the switch negative is active up to 10, where positive is active too",
        ),
    ],
)
def test_switches_that_make_no_sense(switches: str, said: str) -> None:
    text = problem(f"  c: {{nodes: {{m1: {{id: 1, switches: {switches}}}}}}}")
    assert f"can.c.nodes.m1.switches.{said}" in text, text


def test_a_stepper_has_other_inputs() -> None:
    text = problem("  c: {nodes: {s1: {id: 1, switches: {home: {pin: D3}}}}}")
    assert text.startswith(
        "1:50: can.c.nodes.s1.switches.home.pin: s1 has no input 'D3' (there are sync, Estop, RST)"
    )


def test_a_bus_with_all_there_is() -> None:
    switches = (
        "{home: {from_deg: 10, to_deg: 20}, negative: {below_deg: -90}, positive: {pin: D3, active: low}}"
    )
    text = HEAD + (
        f"  can0: {{bit_rate: 1000000, nodes: {{m1: {{id: 5, switches: {switches}}}, s1: 127}},\n"
        "         taps: {a: {}, b: {port: {kind: tcp, listen: 5555}}}}\n  can1: {}\n"
    )
    config = parse(text, "b.yaml", CATALOGUE)
    bus = config.can["can0"]
    assert (bus.members(), bus.nodes["s1"].id, bus.nodes["m1"].switches.home.from_deg) == (
        ("m1", "s1"),
        127,
        10,
    )
    assert ("m1", "s1") in config.joints()
    assert {name: port.kind for name, port in config.tap_ports().items()} == {
        "can0.a": "pty",
        "can0.b": "tcp",
    }
    assert config.can["can1"].bit_rate == 500_000


def test_ports_of_taps_clash_as_others_do() -> None:
    tap = "{port: {kind: tcp, listen: 5555}}"
    assert "device c.a has its port in the same place" in problem(f"  c: {{taps: {{a: {tap}, b: {tap}}}}}")


def test_ids_may_be_shared_if_that_is_wanted() -> None:
    text = HEAD + "  c: {nodes: {m1: 5, s1: 5}, duplicate_ids: true}\n"
    assert parse(text, "b.yaml", CATALOGUE).can["c"].duplicate_ids


def test_faults_of_a_bus_are_checked() -> None:
    base: dict[str, Any] = {
        "bench": "t",
        "devices": {"m1": {"profile": "mechaduino"}},
        "can": {"c": {"nodes": {"m1": 1}, "taps": {"x": {}}}},
    }
    on_nodes = ("wire_cut", "driver_stuck", "packet_no_ack", "node_babble", "bus_off")
    good = [{"fault": kind, "target": to} for kind in on_nodes for to in ("m1.canopen", "c.x")]
    good += [{"fault": "wire_noise", "target": "c", "rate": 1e-4}]
    good += [{"fault": "bit_rate_wrong", "target": "c.x", "bit_rate": 250_000}]
    from_dict(base | {"faults": good}, CATALOGUE)
    for fault, said in (
        ({"fault": "bus_off", "target": "c"}, "write a CANopen node, or a tap of a CAN bus: c.x, m1.canopen"),
        ({"fault": "wire_noise", "target": "c.x", "rate": 0.1}, "write a segment or a CAN bus: c"),
        ({"fault": "wire_swapped", "target": "m1.canopen"}, "there is none"),
        ({"fault": "packet_nak", "target": "c.x"}, "there is none"),
        ({"fault": "bit_rate_wrong", "target": "c.x"}, "this key is missing"),
        ({"fault": "bit_rate_wrong", "target": "c.x", "bit_rate": 9_999}, "write 10000 to 1000000"),
    ):
        with pytest.raises(ConfigError) as caught:
            from_dict(base | {"faults": [fault]}, CATALOGUE)
        assert said in str(caught.value)


def test_a_change_of_a_bus_is_one_of_the_whole_bench() -> None:
    old, new = (parse(HEAD + f"  c: {{nodes: {{m1: {n}}}}}\n", "b.yaml", CATALOGUE) for n in (1, 2))
    core = next(change for change in diff(old, new) if change.device is None)
    assert core.why == ("can.c.nodes.m1.id: 1 -> 2",)


def test_the_schema_takes_a_node_s_id_alone() -> None:
    from jsonschema import Draft202012Validator

    validator = Draft202012Validator(schema(CATALOGUE))
    bench = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}
    for nodes, is_good in (({"m1": 5}, True), ({"m1": {"id": 5}}, True), ({"m1": 128}, False)):
        given = bench | {"can": {"c": {"nodes": nodes, "taps": {"x": {}}}}}
        assert validator.is_valid(given) == is_good, nodes


def test_a_cam_has_no_default_of_a_pin() -> None:
    assert SwitchConfig.model_validate({"above_deg": 1.0}).model_dump()["active"] is None
