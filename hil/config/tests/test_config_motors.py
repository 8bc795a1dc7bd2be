"""Motors of the catalogue, and profiles that name one."""

import math
from pathlib import Path

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, ProfileInfo, profile_from_yaml
from hil.config.motors import MEANINGS, MOTORS
from hil.vocab.axis_plan import FULL_PARAMETERS, AxisPlan

TEXT = """\
name: board
title: A board
law: sac
plant: simple
motor: nema17-2A
default_hardware: "1"
hardware: {"1": {supply_min_V: 8, supply_max_V: 35, inputs_5V: []}}
axis:
  driver: {value: 0, unit: "0: A4988", about: Driver., source: chosen}
  phase_current_A: {value: 1.0, unit: A, about: Current., source: chosen}
registers: {}
"""


def read(text: str) -> ProfileInfo:
    return profile_from_yaml(text, Path("board"))


def problem(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        read(text)
    (found,) = caught.value.problems
    return str(found)


@pytest.mark.parametrize("motor", MOTORS)
@pytest.mark.parametrize("plant", ["simple", "full"])
def test_a_profile_that_names_a_motor_has_all_that_the_core_needs(motor: str, plant: str) -> None:
    info = read(TEXT.replace("nema17-2A", motor))
    assert info.motor == motor
    parameters = {name: each.default(plant) for name, each in info.axis.items()}
    assert set(FULL_PARAMETERS) < parameters.keys()
    plan = AxisPlan(parameters, plant, law=info.law)  # type: ignore[arg-type]
    assert find_catalogue().refused_motors({"m": plan}) == {}


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_each_figure_has_its_unit_meaning_and_origin(motor: object) -> None:
    figures = motor.figures  # type: ignore[attr-defined]
    assert figures.keys() == MEANINGS.keys()
    assert all(each.source for each in figures.values())


@pytest.mark.parametrize(
    ("motor", "holding_Nm", "rated_A"),
    [
        ("nema17-2A", 0.45, 2.0),
        ("nema17-2A-long", 0.59, 2.0),
        ("nema23-2.8A", 1.26, 2.8),
        ("nema23-3A", 1.89, 3.0),
    ],
)
def test_two_coils_at_the_rated_current_hold_what_the_data_sheet_says(
    motor: str, holding_Nm: float, rated_A: float
) -> None:
    """Holding torque where both coils pull alike: each is at 45 electrical degrees from its best angle. The
    first motor's constant is that of the boards that were there before, 3 % less."""
    torque_Nm = math.sqrt(2) * rated_A * MOTORS[motor].figures["torque_constant_Nm_per_A"].value
    assert torque_Nm == pytest.approx(holding_Nm, rel=0.03)


def test_a_number_of_ones_own_replaces_the_motors_for_both_plants() -> None:
    info = read(TEXT + "").axis["viscous_Nm_s_per_rad"]
    assert (info.value, info.full) == (0.0015, 4e-5)
    own = read(TEXT.replace("axis:\n", "axis:\n  viscous_Nm_s_per_rad: {value: 0.01, source: measured}\n"))
    changed = own.axis["viscous_Nm_s_per_rad"]
    assert (changed.value, changed.full, changed.source) == (0.01, None, "measured")
    assert (changed.unit, changed.minimum, changed.about) == (info.unit, info.minimum, info.about)


def test_a_number_of_ones_own_needs_its_source() -> None:
    found = problem(TEXT.replace("axis:\n", "axis:\n  inertia_kg_m2: {value: 1.0e-5}\n"))
    assert found == (
        'board/profile.yaml:9:3: axis.inertia_kg_m2.source: this key is missing (add the line "source: ...")'
    )


def test_an_unknown_motor_is_said_with_those_there_are() -> None:
    found = problem(TEXT.replace("nema17-2A", "nema17-3A").replace("law: sac\n", "law: sac\n"))
    assert found.startswith(
        'board/profile.yaml:5:8: motor: there is no motor "nema17-3A" (did you mean "nema17-2A"? known are: '
    )


def test_limits_of_the_motors_parameters_hold() -> None:
    text = TEXT.replace("axis:\n", "axis:\n  rotor_teeth: {value: 50.5, source: counted}\n")
    assert problem(text) == (
        "board/profile.yaml:9:24: axis.rotor_teeth.value: 50.5 is not a whole number (write a whole number)"
    )
