"""Modbus nodes and formats of segments in a configuration."""

from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, diff, from_dict, parse

CATALOGUE = find_catalogue()
HEAD = """bench: t
devices:
  m1: {profile: mechaduino}
  s1: {profile: sac}
  r1: {profile: mechaduino, at: /dev/ttyUSB0}
segments:
"""


def problem(segments: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse(HEAD + segments, "b.yaml", CATALOGUE)
    (found,) = caught.value.problems
    return f"{found.line - 6}:{found.column}: {found.message} ({found.remedy})"


@pytest.mark.parametrize(
    ("segments", "said"),
    [
        ("  b: {modbus: {units: {m9: 1}}}", '1:24: segments.b.modbus.units.m9: there is no device "m9"'),
        ("  b: {modbus: {units: {r1: 1}}}", "1:24: segments.b.modbus.units.r1: r1 is a real board (nodes"),
        ("  b: {modbus: {units: {m1.x: 1}}}", "1:24: segments.b.modbus.units.'m1.x': m1 has no axis 'x'"),
        ("  b: {modbus: {units: {m1: 1, s1: 1}}}", "1:35: segments.b.modbus.units.s1: unit 1 is m1 already"),
        (
            "  b: {modbus: {units: {m1: 248}}}",
            "1:28: segments.b.modbus.units.m1: the number 248 is too large",
        ),
        ("  b: {modbus: {units: {m1: 0}}}", "1:28: segments.b.modbus.units.m1: the number 0 is too small"),
        ("  b: {modbus: {units: {}}}", "1:23: segments.b.modbus.units: there is nothing in it"),
        ("  b: {modbus: {}}", "1:7: segments.b.modbus.units: this key is missing"),
        ("  b: {modbus: {units: {m1: 1}, word_order: up}}", "1:44: segments.b.modbus.word_order"),
        ("  b: {modbus: {units: {m1: 1}, response_ms: -1}}", "1:45: segments.b.modbus.response_ms"),
        (
            "  a: {modbus: {units: {m1: 1}}}\n  b: {modbus: {units: {m1: 2}}}",
            "2:24: segments.b.modbus.units.m1: m1 has a node on a already (an axis has one",
        ),
        (
            "  b: {stations: [s1], modbus: {units: {m1: 1}}}",
            "1:31: segments.b.modbus: b speaks sac already, by s1; this is modbus_rtu (put it on",
        ),
        (
            "  b: {modbus: {units: {m1: 1}}, taps: {x: {framing: sac}}}",
            "1:53: segments.b.taps.x.framing: b speaks modbus_rtu already, by modbus; this is sac",
        ),
        (
            "  b: {stations: [s1], format: 8E1}",
            "1:31: segments.b.format: s1 speaks 8N1, as all boards' UARTs do but a processor's (put it",
        ),
        (
            "  b: {format: 8E1, taps: {x: {framing: sac}}}",
            "1:40: segments.b.taps.x.framing: b speaks modbus_rtu",
        ),
        ("  b: {format: 7E1}", "1:15: segments.b.format"),
    ],
)
def test_what_cannot_be_is_said_where_it_stands(segments: str, said: str) -> None:
    assert problem(segments).startswith(said)


@pytest.mark.parametrize(
    ("axis", "said"),
    [
        ("p1", "7:24: segments.b.modbus.units.p1: a pinger has no axis (a node needs one)"),
        ("p1.x", "7:24: segments.b.modbus.units.'p1.x': p1 has no axis 'x'; it has none ("),
    ],
)
def test_a_board_without_axes_has_no_node(axis: str, said: str) -> None:
    boards = Path(__file__).parents[3] / "tests/boards"
    catalogue = find_catalogue(path=[boards])
    head = HEAD.replace("s1: {profile: sac}", "p1: {profile: pinger}")
    with pytest.raises(ConfigError) as caught:
        parse(f"{head}  b: {{modbus: {{units: {{{axis}: 1}}}}}}", "b.yaml", catalogue)
    (found,) = caught.value.problems
    assert str(found).startswith(f"b.yaml:{said}")


def test_nodes_taps_and_a_format() -> None:
    text = HEAD + "  b: {modbus: {units: {m1: 1, s1: 247}}, format: 8O1, taps: {x: {}}}\n  c: {format: 8N2}\n"
    config = parse(text, "b.yaml", CATALOGUE)
    assert config.segments["b"].members() == ("m1", "s1")
    assert ("m1", "s1") in config.joints()
    assert config.segments["c"].modbus is None


def test_equal_numbers_are_a_mistake_unless_they_are_wanted() -> None:
    text = HEAD + "  b: {modbus: {units: {m1: 1, s1: 1}%s}}\n"
    with pytest.raises(ConfigError) as caught:
        parse(text % "", "b.yaml", CATALOGUE)
    said = 'unit 1 is m1 already (give each a number of its own, or add "duplicate_units: true" to modbus)'
    assert said in str(caught.value)
    with pytest.raises(ConfigError, match="unit 1 is m1 already"):
        parse(text % ", duplicate_units: false", "b.yaml", CATALOGUE)
    modbus = parse(text % ", duplicate_units: true", "b.yaml", CATALOGUE).segments["b"].modbus
    assert modbus
    assert modbus.units == {"m1": 1, "s1": 1}


def test_boards_without_a_framing_may_be_on_a_line_with_nodes() -> None:
    with pytest.raises(ConfigError):
        from_dict(
            {
                "bench": "t",
                "devices": {"s1": {"profile": "sac"}},
                "segments": {"b": {"stations": ["s1"], "modbus": {"units": {"s1": 1}}}},
            },
            CATALOGUE,
        )


def test_faults_of_nodes_are_checked() -> None:
    base = {
        "bench": "t",
        "devices": {"m1": {"profile": "mechaduino"}},
        "segments": {"b": {"modbus": {"units": {"m1": 1}}, "taps": {"x": {}}}},
    }
    good = [{"fault": kind, "target": "m1.modbus"} for kind in ("modbus_late", "packet_bad_crc", "wire_cut")]
    from_dict(base | {"faults": good}, CATALOGUE)
    for fault, said in (
        ({"fault": "modbus_late", "target": "m1"}, "write an axis's Modbus node: m1.modbus"),
        ({"fault": "modbus_late", "target": "b.x"}, "write an axis's Modbus node: m1.modbus"),
        ({"fault": "shaft_jam", "target": "m1.modbus"}, "write a twin with a motor: m1"),
        ({"fault": "packet_nak", "target": "m1.modbus"}, "of faults of packets it can have packet_bad_crc"),
        ({"fault": "modbus_exception", "target": "m1.modbus", "code": 0}, "write 1 to 255"),
    ):
        with pytest.raises(ConfigError) as caught:
            from_dict(base | {"faults": [fault]}, CATALOGUE)
        assert said in str(caught.value)


def test_a_change_of_nodes_is_one_of_the_whole_bench() -> None:
    old, new = (
        parse(HEAD + f"  b: {{modbus: {{units: {{m1: {n}}}}}}}\n", "b.yaml", CATALOGUE) for n in (1, 2)
    )
    core = next(change for change in diff(old, new) if change.device is None)
    assert core.why == ("segments.b.modbus.units.m1: 1 -> 2",)
