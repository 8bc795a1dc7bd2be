"""Findings about motors at their drivers: all at once, each with its place and a remedy."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse

COMMUTATES = "a modbus_drive commutates motors of 200 steps a turn, and this one has 400"


def problems(text: str) -> list[str]:
    try:
        parse(text, "b.yaml", find_catalogue())
    except ConfigError as error:
        return [str(problem) for problem in error.problems]
    return []


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


def test_mistakes_elsewhere_hide_no_motor() -> None:
    weak = "{profile: sac, motor: nema34-5.5A}"
    for wrong, places in (
        ("  s2: {profile: sac, colour: red}", ["4:22"]),
        ("  s2: {profile: saq}", ["4:17"]),
        ("  d2: {profile: modbus_drive, map: none.yaml}", ["4:36"]),
        ("colour: red", ["4:1"]),
        ("state_dir: 3", ["4:12"]),
    ):
        found = problems(f"bench: t\ndevices:\n  s1: {weak}\n{wrong}\n")
        assert [each.split(": ")[0] for each in found] == ["b.yaml:3:29", *(f"b.yaml:{at}" for at in places)]
    found = problems(f"bench: T!\ndevices:\n  s1: {weak}\n")
    assert [each.split(": ")[0] for each in found] == ["b.yaml:1:8", "b.yaml:3:29"]


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
