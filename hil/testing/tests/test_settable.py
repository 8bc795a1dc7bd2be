"""Fields of an axis that may be set from outside: limits by the motor's own torque, and by what the board
has."""

import re

import pytest

from hil.sim.settable import setting_problem
from hil.testing import Bench
from hil.vocab.faults import FaultRefused

PROFILES = {"s1": "sac", "m1": "mechaduino", "d1": "modbus_drive", "c1": "canopen_drive"}
FULL = {"m2": "mechaduino", "s2": "sac"}
CONFIG = {
    "bench": "f",
    "devices": {name: {"profile": profile} for name, profile in PROFILES.items()}
    | {name: {"profile": profile, "plant": "full"} for name, profile in FULL.items()},
}
SMALL = "-1.55 to 1.55, 10 times what this motor holds (0.155 Nm)"
LIMITS = dict.fromkeys(("m1", "d1", "c1"), "-4.95 to 4.95, 10 times") | dict.fromkeys(("s1", "s2"), SMALL)
LIMITS["m2"] = "-3.41 to 3.41, 10 times what this motor holds (0.341 Nm)"
INFINITE, NO_NUMBER = float("inf"), float("nan")


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize("torque_Nm", [99.0, -99.0, 5.0, INFINITE, NO_NUMBER])
def test_a_load_is_bounded_by_the_motor(name: str, torque_Nm: float) -> None:
    bench = Bench(CONFIG)
    runtime, device = bench._runtime, bench._runtime.devices[name]
    assert LIMITS[name] in str(setting_problem(runtime.faults, device, "load_torque_Nm", torque_Nm))
    with pytest.raises(ValueError, match=f"load_torque_Nm: .*; write {re.escape(LIMITS[name])}"):
        bench.axis(name).load_torque_Nm = torque_Nm
    if abs(torque_Nm) <= 1000:
        with pytest.raises(FaultRefused, match=r"torque_Nm: .*; write -") as refused:
            bench.fault("shaft_load", name, torque_Nm=torque_Nm)
        assert LIMITS[name] in str(refused.value)
    for allowed_Nm in (0.0, 1.5, -1.5):
        assert setting_problem(runtime.faults, device, "load_torque_Nm", allowed_Nm) is None


SUM = "with {} Nm that push the same way it is {}; in all write -1.55 to 1.55, 10 times what this motor holds"


def test_loads_on_one_shaft_add_up_to_the_bound_at_most() -> None:
    bench = Bench(CONFIG)
    bench.axis("s1").load_torque_Nm = 0.55
    bench.fault("shaft_load", "s1", torque_Nm=0.9, start_s=1.0)
    with bench.fault("shaft_load", "s1", torque_Nm=-1.55), pytest.raises(FaultRefused) as refused:
        bench.fault("shaft_load", "s1", torque_Nm=1.55)
    assert SUM.format("1.45", "3") in str(refused.value)
    bench.fault("shaft_load", "s1", torque_Nm=0.1)
    bench.run(ms=1100)
    assert bench.axis("s1").load_torque_Nm == pytest.approx(1.55)
    with pytest.raises(ValueError, match=re.escape(SUM.format("1", "1.56"))):
        bench.axis("s1").load_torque_Nm = 0.56
    for lighter_Nm in (0.5, 0.0, -1.55, 0.55):
        bench.axis("s1").load_torque_Nm = lighter_Nm
    with pytest.raises(FaultRefused, match=r"1.55 Nm that push the same way"):
        bench.fault("shaft_load", "s1", torque_Nm=0.001)
    bench.fault("shaft_load", "m1", torque_Nm=4.9)


@pytest.mark.parametrize(
    ("name", "field", "value", "why"),
    [
        ("s1", "diaagc", 5, "s1, a sac, has no diaagc"),
        ("m1", "clock_Hz", 5, "m1, a mechaduino, has no clock_Hz"),
        ("m1", "diaagc", 0x8000, "diaagc: 32768 is too large; write 0 to 32767"),
        ("m1", "uMAX", 256, "uMAX: 256 is too large; write 0 to 255"),
        ("m1", "uMAX", "5", 'uMAX: "5" is a text; write the number without quotes, as 5'),
        ("m1", "pKp", True, "pKp: true is no number; write"),
    ],
)
def test_what_a_field_cannot_have(name: str, field: str, value: object, why: str) -> None:
    runtime = Bench(CONFIG)._runtime
    assert str(setting_problem(runtime.faults, runtime.devices[name], field, value)).startswith(why)
