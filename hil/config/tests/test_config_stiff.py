"""Motors that cannot be integrated are found by the check, not by the start."""

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse
from hil.testing import Bench

TEXT = """bench: t
devices:
  m1: {{profile: mechaduino, plant: {plant}, axis: {{{parameter}: {value}}}}}
  m2: {{profile: mechaduino}}
"""


@pytest.mark.parametrize("plant", ["simple", "full"])
@pytest.mark.parametrize(
    ("parameter", "value"), [("inertia_kg_m2", "1.0e-20"), ("inertia_kg_m2", "1.0e-300")]
)
def test_a_motor_that_is_too_stiff(plant: str, parameter: str, value: str) -> None:
    with pytest.raises(
        ConfigError, match=r"bench.yaml:3:\d+: devices.m1.axis: the motor is too stiff .*more inertia"
    ):
        parse(TEXT.format(plant=plant, parameter=parameter, value=value), "bench.yaml", find_catalogue())


@pytest.mark.parametrize(
    ("parameter", "value"), [("start_deg", 1e300), ("load_torque_Nm", -1e7), ("rotor_teeth", 1 << 31)]
)
def test_numbers_that_would_run_out_of_range(parameter: str, value: float) -> None:
    with pytest.raises(ConfigError, match=f"devices.m1.axis.{parameter}: .*(too large|too small)"):
        Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino", "axis": {parameter: value}}}})


@pytest.mark.parametrize("torque_Nm", [float("nan"), float("inf"), -1e7])
def test_a_load_that_is_none(torque_Nm: float) -> None:
    bench = Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}})
    with pytest.raises(
        ValueError, match=r"load_torque_Nm: .*; write -4.95 to 4.95, 10 times what this motor"
    ):
        bench.axis("m1").load_torque_Nm = torque_Nm


@pytest.mark.parametrize("segments", [8, 300])
def test_segments_without_stations_need_no_device(segments: int) -> None:
    bench = Bench(
        {
            "bench": "t",
            "devices": {"m1": {"profile": "mechaduino"}},
            "segments": {f"b{n}": {} for n in range(segments)},
        }
    )
    bench.run(ms=10)
