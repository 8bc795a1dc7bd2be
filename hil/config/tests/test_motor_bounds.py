"""Bounds of motors and loads by the motor's own figures, at their borders, for every board and plant."""

import re
from dataclasses import replace

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.config.motor_bounds import BOUNDS, OF_OTHER_MOTORS, numbers_beyond, pulls_beyond
from hil.core.axis_kind import speed_limit_rpm
from hil.core.kinds import KINDS
from hil.sim.load_limit import load_problem
from hil.vocab.axis_plan import AxisPlan, Load

CATALOGUE = find_catalogue()
PROFILES = ("mechaduino", "sac", "modbus_drive", "canopen_drive")
NAN, INFINITE = float("nan"), float("inf")


def usual(profile: str, plant: str) -> dict[str, float]:
    (axis,) = CATALOGUE.profiles[profile].axes.values()
    return {name: parameter.default(plant) for name, parameter in axis.axis.items()}


def plan_of(profile: str, plant: str, load: Load = Load(), **own: float) -> AxisPlan:  # noqa: B008
    law = CATALOGUE.profiles[profile].law
    assert law
    return AxisPlan(usual(profile, plant) | own, plant, load, law=law)


def beyond(plan: AxisPlan, profile: str) -> list[str]:
    return [each.key[-1] for each in numbers_beyond(plan, usual(profile, plan.plant))]


def limits(plan: AxisPlan) -> dict[str, float]:
    """Largest values, as the decision has them."""
    holding_Nm = KINDS[plan.law].holding_Nm(plan.parameters)
    turn_rad = 6.283185307179586
    most = {"inertia_kg_m2": holding_Nm / turn_rad, "viscous_Nm_s_per_rad": holding_Nm / (turn_rad / 60)}
    if plan.plant == "full":
        most |= {"coulomb_torque_Nm": 10 * holding_Nm, "detent_torque_Nm": holding_Nm}
    return most


@pytest.mark.parametrize("plant", ["simple", "full"])
@pytest.mark.parametrize("profile", PROFILES)
def test_the_borders_by_what_a_motor_holds(profile: str, plant: str) -> None:
    plan = plan_of(profile, plant)
    assert beyond(plan, profile) == []
    for name, limit in limits(plan).items():
        least = 1e-9 if name == "inertia_kg_m2" else 0.0
        for good in (least, limit / 2, limit):
            assert beyond(plan_of(profile, plant, **{name: good}), profile) == []
        for bad in (limit * 1.001, 1e300, INFINITE, NAN, -limit, -1e-9):
            assert beyond(plan_of(profile, plant, **{name: bad}), profile) == [name], bad


@pytest.mark.parametrize("plant", ["simple", "full"])
@pytest.mark.parametrize("profile", PROFILES)
def test_the_borders_by_the_profiles_figures(profile: str, plant: str) -> None:
    figures = usual(profile, plant)
    names = [name for name in OF_OTHER_MOTORS if name in figures]
    assert len(names) >= 4
    for name in names:
        for good in (figures[name] / 100, figures[name], figures[name] * 100):
            assert name not in beyond(plan_of(profile, plant, **{name: good}), profile)
        for bad in (figures[name] / 101, figures[name] * 101, 0.0, -1.0, 1e300, INFINITE, NAN):
            assert beyond(plan_of(profile, plant, **{name: bad}), profile) == [name], bad


@pytest.mark.parametrize("resistor_ohm", [0.13, 0.17, 0.19, 0.7])
def test_what_a_remedy_says_can_be_written(resistor_ohm: float) -> None:
    key = "sense_resistor_ohm"
    plan = plan_of("mechaduino", "full", **{key: resistor_ohm, "inertia_kg_m2": 9e9, "detent_torque_Nm": 9e9})
    for found in numbers_beyond(plan, usual("mechaduino", "full")):
        (limit,) = re.findall(r"(?:, and| to) (\S+?)(?: or less)?:", found.remedy)
        said = {found.key[-1]: float(limit)}
        assert beyond(plan_of("mechaduino", "full", **{key: resistor_ohm} | said), "mechaduino") == []
    holding_Nm = KINDS[plan.law].holding_Nm(plan.parameters)
    (most,) = re.findall(r" to (\S+),", load_problem(9e9, holding_Nm) or "")
    assert load_problem(float(most), holding_Nm) is None


def test_rotor_and_load_have_one_bound_of_inertia() -> None:
    plan = plan_of("mechaduino", "full")
    room = limits(plan)["inertia_kg_m2"] - plan.parameters["inertia_kg_m2"]
    assert beyond(replace(plan, load=Load(inertia_kg_m2=room)), "mechaduino") == []
    assert beyond(replace(plan, load=Load(inertia_kg_m2=room * 1.001)), "mechaduino") == ["load"]


@pytest.mark.parametrize("law", [law for law in KINDS if KINDS[law].has_motor])
def test_pulls_are_bound_as_torques_are(law: str) -> None:
    plan = replace(plan_of("mechaduino", "full", phase_current_A=2.2, start_deg=10.0), law=law)
    most_Nm = 10 * KINDS[law].holding_Nm(plan.parameters)
    for of in (
        lambda torque: Load(pendulum_Nm=torque),
        lambda torque: Load(torque_Nm=torque),
        lambda torque: Load(torque_Nm=-torque),
        lambda torque: Load(stiffness_Nm_per_rad=torque, centre_deg=10.0 + 57.29577951308232),
    ):
        assert not [*pulls_beyond(replace(plan, load=of(most_Nm)))]
        ((what, remedy),) = pulls_beyond(replace(plan, load=of(1.001 * most_Nm)))
        assert f"pulls with {1.001 * most_Nm:g} Nm" in what
        assert (
            remedy == f"make it {most_Nm:g} Nm or less, 10 times what this motor holds ({most_Nm / 10:g} Nm)"
        )


SCREW = "{kind: lead_screw, lead_mm: 5, mass_kg: 600, gravity: positive}"


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("axis: {inertia_kg_m2: 1.0e+300}", r":3:\d+: devices.m1.axis.inertia_kg_m2: 1e\+300 kg m2 is out"),
        ("axis: {torque_constant_Nm_per_A: 99}", ":3:.*the profile's 0.225, and 100 times less or more"),
        (
            "axis: {coulomb_torque_Nm: 99}, plant: full",
            ":3:.*write 0 to 3.41: 10 times what this motor holds",
        ),
        (f"load: {SCREW}, plant: full", r":3:\d+: devices.m1.load: the carriage's weight pulls with 4.68"),
        ("load: {kind: constant, inertia_kg_m2: 1}, plant: full", "load has 1 kg m2 .*make it 0.0542"),
        (
            "load: {kind: spring, stiffness_Nm_per_rad: 1, centre_deg: 1.0e+6}, plant: full",
            "starts, the spring",
        ),
        ("axis: {inertia_kg_m2: .inf}", "not a number to compute with"),
        ("axis: {inertia_kg_m2: -1}", "too small"),
    ],
)
def test_a_check_says_where_and_why(keys: str, said: str) -> None:
    text = f"bench: t\ndevices:\n  m1: {{profile: mechaduino, {keys}}}\n"
    with pytest.raises(ConfigError, match=said) as caught:
        parse(text, "b.yaml", CATALOGUE)
    assert len(caught.value.problems) == 1


def test_the_table_names_what_there_is() -> None:
    known = {name for profile in PROFILES for name in usual(profile, "full")} | {"load", "shaft_load"}
    assert {name for names in BOUNDS for name in names} <= known


@pytest.mark.parametrize(
    ("teeth", "rpm"), [(50, 10_000), (100, 5000), (1000, 500), (16, 30_000), (1, 30_000)]
)
def test_the_limit_of_speed_goes_by_the_teeth(teeth: float, rpm: float) -> None:
    assert speed_limit_rpm({"rotor_teeth": teeth}) == rpm
