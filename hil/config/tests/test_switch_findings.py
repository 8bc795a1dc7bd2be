"""Findings about switches along axes, and about motors of the catalogue at their drivers: all at once, each
with its place and a remedy."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse

HEAD = """\
bench: t
devices:
  s1: {profile: sac, plant: full, load: {kind: end_stops, min_deg: -90, max_deg: 90}}
  m1: {profile: mechaduino}
  u1: {profile: uno}
wires: [{from: s1.clk, to: m1.step}]
"""

COMMUTATES = "a modbus_drive commutates motors of 200 steps a turn, and this one has 400"


def problems(text: str) -> list[str]:
    try:
        parse(text, "b.yaml", find_catalogue())
    except ConfigError as error:
        return [str(problem) for problem in error.problems]
    return []


def said_of(switch: str) -> str:
    (found,) = problems(f"{HEAD}switches:\n  a: {switch}\n")
    return found


@pytest.mark.parametrize(
    ("switch", "said"),
    [
        (
            "{axis: s9, to_deg: 1}",
            'b.yaml:8:13: switches.a.axis: there is no device "s9" (known are: m1, s1, u1)',
        ),
        (
            "{axis: u1, to_deg: 1}",
            'b.yaml:8:13: switches.a.axis: "u1" has no motor, and so no shaft that could hold a switch'
            " (write one of s1, m1)",
        ),
        (
            "{axis: s1, to_deg: 1, to: s1.Estp}",
            'b.yaml:8:32: switches.a.to: s1 has no pin "Estp" (did you mean "Estop"? there are sync, Estop,'
            " RST, EnA, EnB, xclk)",
        ),
        (
            "{axis: s1, to_deg: 1, to: s1.clk}",
            "b.yaml:8:32: switches.a.to: clk of s1 is an output"
            " (write one of sync, Estop, RST, EnA, EnB, xclk)",
        ),
        (
            "{axis: s1, to_deg: 1, to: m1.D1}",
            "b.yaml:8:32: switches.a.to: m1.D1 is driven by s1.clk already (give each a pin of its own)",
        ),
        (
            "{axis: s1, from_deg: 91}",
            "b.yaml:8:27: switches.a.from_deg: s1 stops at 90 deg, before the switch"
            " (write an angle from -90 to 90, or put the stop behind the switch)",
        ),
        (
            "{axis: s1, to_deg: -91}",
            "b.yaml:8:25: switches.a.to_deg: s1 stops at -90 deg, before the switch"
            " (write an angle from -90 to 90, or put the stop behind the switch)",
        ),
        (
            "{axis: m1}",
            "b.yaml:8:3: switches.a: the switch has no place (write from_deg, to_deg or both)",
        ),
        (
            "{axis: m1, from_deg: 2, to_deg: 1}",
            "b.yaml:8:38: switches.a.to_deg: the switch ends where it has not begun"
            " (write an angle that is not less than from_deg)",
        ),
        (
            "{axis: m1, from_deg: 0, to_deg: 9, every_deg: 10, hysteresis_deg: 1}",
            "b.yaml:8:52: switches.a.every_deg: with 10 deg the switch is never let go"
            " (write from_deg and to_deg, with more than what lies between them here)",
        ),
    ],
)
def test_a_wrong_switch_is_said_where_it_stands(switch: str, said: str) -> None:
    assert said_of(switch) == said


def test_two_switches_at_one_pin_by_any_of_its_names() -> None:
    rows = "".join(f"  {name}: {{axis: s1, to_deg: 1, to: s1.Estop}}\n" for name in "ab")
    text = f"{HEAD}switches:\n{rows}"
    assert problems(text) == [
        "b.yaml:9:32: switches.b.to: s1.Estop is driven by the switch a already (give each a pin of its own)"
    ]


def test_an_axis_has_so_many_switches() -> None:
    rows = "".join(f"  x{i}: {{axis: s1, to_deg: {i}}}\n" for i in range(9))
    (found,) = problems(f"{HEAD}switches:\n{rows}")
    assert found == "b.yaml:16:14: switches.x8.axis: s1 has 8 switches already (take one of them out)"


def test_motors_that_a_driver_cannot_feed_are_all_said_at_once() -> None:
    found = problems("""\
bench: t
devices:
  s1: {profile: sac, motor: nema17-2a}
  s2: {profile: sac, motor: nema34-5.5A}
  s3: {profile: sac, motor: nema17-0.33A, axis: {phase_current_A: 1.0}}
  s4: {profile: sac, motor: nema23-2.8A, axis: {phase_current_A: 2.4}}
  s5: {profile: sac, plant: full, motor: nema14-0.5A, axis: {supply_V: 8, phase_current_A: 0.6}}
  m1: {profile: modbus_drive, motor: nema17-2A-400}
  m2: {profile: modbus_drive, axis: {rotor_teeth: 100}}
  m3: {profile: mechaduino, motor: nema14-0.5A}
switches: {a: {axis: s1}}
""")
    begins = [each.partition(" (")[0] for each in found]
    assert begins == [
        'b.yaml:3:29: devices.s1.motor: there is no motor "nema17-2a"',
        "b.yaml:4:29: devices.s2.motor: the driver gives 2 A at most, and nema34-5.5A is rated for 5.5 A",
        "b.yaml:5:67: devices.s3.axis.phase_current_A: the driver gives it 1 A, and nema17-0.33A is rated"
        " for 0.33 A",
        "b.yaml:6:66: devices.s4.axis.phase_current_A: the driver gives 2 A at most, and 2.4 A are written"
        " here",
        "b.yaml:7:72: devices.s5.axis.supply_V: 8 V drive 0.533 A through 15 ohm, and 0.6 A are set",
        f"b.yaml:8:38: devices.m1.motor: {COMMUTATES}",
        f"b.yaml:9:51: devices.m2.axis.rotor_teeth: {COMMUTATES}",
        "b.yaml:10:36: devices.m3.motor: the driver gives it 2.2 A, and nema14-0.5A is rated for 0.5 A",
        "b.yaml:11:12: switches.a: the switch has no place",
    ]
    assert '(did you mean "nema17-2A"?' in found[0]
    assert (
        "(write axis.phase_current_A: 2, with which it is weaker, or a motor that it can feed: " in found[1]
    )


def test_the_remedy_names_no_motors_where_the_catalogue_has_none() -> None:
    (found,) = problems(
        "bench: t\ndevices: {m1: {profile: mechaduino, motor: nema17-2A, axis: {sense_resistor_ohm: 0.02}}}\n"
    )
    assert found.endswith("(write another axis.sense_resistor_ohm)")


def test_each_motor_that_a_remedy_names_is_taken() -> None:
    head = "bench: t\ndevices:\n  m1: {profile: modbus_drive, motor: "
    for motor in ("nema34-6A", "nema17-2A-400", "nema14-0.5A"):
        (found,) = problems(f"{head}{motor}}}\n")
        named = found.rpartition("(write ")[2].rstrip(")").rpartition(": ")[2].removeprefix("one of ")
        assert named, found
        for other in named.split(", "):
            assert problems(f"{head}{other}}}\n") == [], other


def test_a_motor_of_the_catalogue_takes_the_place_of_the_boards() -> None:
    config = parse(
        "bench: t\ndevices: {s1: {profile: sac, plant: full, motor: nema17-2A-long, axis: {supply_V: 30},"
        " load: {kind: constant, inertia_kg_m2: 1.0e-5, friction_Nm: 0.05, viscous_Nm_s_per_rad: 1.0e-4}}}\n",
        "b.yaml",
        find_catalogue(),
    )
    numbers = config.devices["s1"].axis_parameters(find_catalogue().profiles["sac"])
    assert numbers["inertia_kg_m2"] == 8.2e-6
    assert numbers["phase_current_A"] == 2.0
    assert numbers["supply_V"] == 30
    assert numbers["coulomb_torque_Nm"] == pytest.approx(0.058)
    assert numbers["viscous_Nm_s_per_rad"] == pytest.approx(1.4e-4)
