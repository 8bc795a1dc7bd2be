"""What may be set on an axis from outside: by the motor's own torque, and what the board has."""

import pytest

from hil.session.settable import setting_problem
from hil.testing import Bench
from hil.vocab.faults import FaultRefused

CONFIG = {"bench": "f", "devices": {"s1": {"profile": "sac"}, "m1": {"profile": "mechaduino"}}}
LIMITS = {"s1": "-1.55 to 1.55, 10 times what this motor holds (0.155 Nm)", "m1": "-4.95 to 4.95, 10 times"}
INFINITE, NO_NUMBER = float("inf"), float("nan")


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("torque_Nm", [99.0, -99.0, 5.0, INFINITE, NO_NUMBER])
def test_a_load_is_bounded_by_the_motor(name: str, torque_Nm: float) -> None:
    bench = Bench(CONFIG)
    device = bench._runtime.devices[name]
    assert LIMITS[name] in str(setting_problem(device, "load_torque_Nm", torque_Nm))
    if abs(torque_Nm) <= 1000:
        with pytest.raises(FaultRefused, match="torque_Nm: write -") as refused:
            bench.fault("shaft_load", name, torque_Nm=torque_Nm)
        assert LIMITS[name] in str(refused.value)
    for allowed_Nm in (0.0, 1.5, -1.5):
        assert setting_problem(device, "load_torque_Nm", allowed_Nm) is None


@pytest.mark.parametrize(
    ("name", "field", "value", "why"),
    [
        ("s1", "diaagc", 5, "s1, a sac, has no diaagc"),
        ("m1", "clock_Hz", 5, "m1, a mechaduino, has no clock_Hz"),
        ("m1", "diaagc", 0x8000, "diaagc: write 0 to 32767"),
        ("m1", "uMAX", 256, "uMAX: write 0 to 255"),
        ("m1", "uMAX", "5", "uMAX: write 0 to 255"),
        ("m1", "pKp", True, "pKp: write"),
    ],
)
def test_what_a_field_cannot_have(name: str, field: str, value: object, why: str) -> None:
    assert str(setting_problem(Bench(CONFIG)._runtime.devices[name], field, value)).startswith(why)
