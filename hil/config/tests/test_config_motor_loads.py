"""Loads that the bench would refuse are found by the check, at their place, with the same words."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.testing import Bench
from hil.vocab.faults import FaultRefused

TEXT = """bench: t
devices:
  s1: {{profile: sac, axis: {{phase_current_A: 0.7, load_torque_Nm: {own_Nm}}}}}
  s2: {{profile: sac}}
faults:
  - {{fault: shaft_load, target: s1, torque_Nm: 0.5, start_s: 5}}
  - {{fault: shaft_load, target: s1, torque_Nm: {torque_Nm}}}
  - {{fault: shaft_load, target: s1, torque_Nm: -1}}
"""
LIMIT = "write -1.085 to 1.085, 10 times what this motor holds (0.1085 Nm): a larger torque only spins it"


def said(own_Nm: float, torque_Nm: float) -> list[str]:
    text = TEXT.format(own_Nm=own_Nm, torque_Nm=torque_Nm)
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", find_catalogue())
    return [str(problem) for problem in caught.value.problems]


def test_a_fault_that_the_motor_cannot_have() -> None:
    (problem,) = said(0.0, 99.0)
    assert problem.startswith("b.yaml:7:48: faults.1.torque_Nm: 99.0 is not allowed here (with 0.5 Nm")
    assert f"it is 99.5; in all {LIMIT}" in problem


def test_the_own_load_of_an_axis() -> None:
    own, *others = said(-99.0, 0.5)
    assert own.startswith("b.yaml:3:")
    assert "devices.s1.axis.load_torque_Nm: -99.0 is not" in own
    assert LIMIT in own
    assert len(others) == 1
    assert "-100" in others[0]  # the last fault's, which pushes the same way


def test_what_the_check_passes_the_bench_takes() -> None:
    bench = Bench(TEXT.format(own_Nm=0.4, torque_Nm=0.185))
    with pytest.raises(FaultRefused, match=r"with 1.085 Nm that push the same way it is 1.095"):
        bench.fault("shaft_load", "s1", torque_Nm=0.01)
    (problem,) = said(0.4, 0.195)
    assert "with 0.9 Nm that push the same way it is 1.095" in problem


def test_a_constant_load_that_drags_any_motor_along() -> None:
    text = (
        "bench: t\ndevices:\n  s1: {{profile: sac, plant: full, load: {{kind: constant, torque_Nm: {}}}}}\n"
    )
    parse(text.format(0.2), "b.yaml", find_catalogue())
    with pytest.raises(
        ConfigError, match=r"b.yaml:3:\d+: devices.s1.load.torque_Nm: 99.0 is not .* 10 times"
    ):
        parse(text.format(99.0), "b.yaml", find_catalogue())


@pytest.mark.parametrize("profile", ["", "profile: mechadunio, "])
def test_a_load_is_checked_without_a_profile_too(profile: str) -> None:
    load = "load: {kind: end_stops, min_deg: low, max_deg: 9, colour: 1}"
    with pytest.raises(ConfigError) as caught:
        parse(f"bench: t\ndevices:\n  m1: {{{profile}{load}}}\n", "b.yaml", find_catalogue())
    said = str(caught.value)
    assert "devices.m1.load.min_deg: a number is wanted here" in said
    assert "devices.m1.load.colour: unknown key" in said
    assert "devices.m1.profile: " in said
    assert len(caught.value.problems) == 3


def test_a_load_is_on_no_port_of_a_board() -> None:
    text = "bench: t\ndevices:\n  s1: {profile: sac}\nfaults:\n  - {fault: shaft_jam, target: s1.main}\n"
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", find_catalogue())
    (problem,) = map(str, caught.value.problems)
    refused = 'b.yaml:5:32: faults.0.target: shaft_jam cannot be on "s1.main"'
    assert problem == f"{refused} (write a twin with a motor: s1, s1.axis)"
