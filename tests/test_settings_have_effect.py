"""Every number of every board's ``axis:`` does something that can be seen, under each plant, or stands here
with the reason why it does not."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from typing import Any

import pytest

from hil.compose.find import find_catalogue
from hil.config.catalogue import AxisParameter
from hil.core.kinds import KINDS
from hil.testing import Bench
from hil.vocab.axis_plan import FULL_PARAMETERS
from hil.vocab.problem import ConfigError
from hil.vocab.verbs import VerbRefused
from hil.wire.step_dir import generate

pytestmark = pytest.mark.long

PROFILES = find_catalogue().profiles
PLANTS = ("simple", "full")
SERVOS = ("hand", "gripper")
FULL_ONLY = (
    *("encoder_eccentricity_deg", "encoder_nonlinearity_deg", "encoder_noise_counts", "phase_resistance_ohm"),
    *("phase_inductance_H", "detent_torque_Nm", "coulomb_torque_Nm", "full_step_error_pct", "supply_V"),
    "fast_decay_pct",
)
Case = tuple[str, str, str, str]


def without_effect(case: Case) -> str | None:
    """Why a number changes nothing; None: it has to."""
    profile, _, plant, name = case
    if plant == "simple" and name in FULL_ONLY:
        return "the simple plant has none of it; the supply is held against the board's range"
    if name.startswith("encoder_") and profile in ("sac", "easydriver"):
        return "the board has no encoder: the number is the motor's, for boards that have one"
    if profile == "walter" and name in ("inertia_kg_m2", "viscous_Nm_s_per_rad", "rotor_teeth"):
        return "a joint is where its pulses have brought it, 1.8 deg a step"
    return None


def others(parameter: AxisParameter, value: float, name: str, holding_Nm: float) -> list[float]:
    """Other values that are allowed."""
    steps = (1.0, -1.0) if parameter.whole else (0.2 * abs(value) or 0.01, -0.2 * abs(value) or -0.01)
    if name.endswith(("_deg", "supply_V")):
        steps = (1.0, -1.0)
    if name == "load_torque_Nm":
        steps = (0.02, 1.1 * holding_Nm)
    return [value + step for step in steps if parameter.refusal(value + step) is None]


def look(bench: Bench, axis: str, law: str) -> tuple[float, ...]:
    """Fields of an axis, without the time and the load, which is told as it was set."""
    now = bench.axis(axis).snapshot()
    return tuple(getattr(now, name) for name in KINDS[law].fields if name not in ("at_ns", "load_torque_Nm"))


def move(bench: Bench, axis: str) -> Iterator[None]:
    bench.axis(axis).do("enable")
    bench.run(ms=300)
    yield
    with suppress(VerbRefused):  # a drive with too much load has a fault
        bench.axis(axis).do("position", position_deg=1000.0)  # as fast as it can
    for _ in range(4):
        bench.run(ms=100)
        yield


def turn(bench: Bench, axis: str) -> Iterator[None]:
    for line, ms in ((b"$CJ4\r", 50), (b"$R\r", 1500)):  # all pins of the microsteps high
        bench.port("d").write(line)
        bench.run(ms=ms)
    bench.axis(axis).do("move_rel", angle_deg=90.0, velocity_rpm=60.0)
    for _ in range(4):
        bench.run(ms=100)
        yield


def pulse(bench: Bench, axis: str) -> Iterator[None]:
    bench.device(axis).drive(generate(800, 4000))
    for _ in range(4):
        bench.run(ms=70)
        yield


def lead(bench: Bench, axis: str) -> Iterator[None]:
    """Move a joint, with a load that its motor just holds, and without its encoder at the end."""
    for line in (b"POWER on\r", b"ENABLE\r", b"MOVETO 5 5 5 5 5 5 5 300\r"):
        bench.port("d").write(line)
        bench.run(ms=130)
        yield
    if not axis.endswith(SERVOS):
        bench.fault("bus_no_answer", axis)
    bench.port("d").write(b"MOVETO 8 8 8 8 8 8 8 300\r")
    for _ in range(12):
        bench.run(ms=30)
        yield


SCENES: dict[str, tuple[float, Callable[[Bench, str], Iterator[None]]]] = {
    "mechaduino": (4100, move),
    "modbus_drive": (300, move),
    "canopen_drive": (300, move),
    "sac": (1500, turn),
    "easydriver": (10, pulse),
    "walter": (1000, lead),
}
"""Time until a board is ready, and what is done with its axis then."""


def holding_Nm(profile: str, axis: str) -> float:
    info = PROFILES[profile].axes[axis]
    return KINDS[info.law].holding_Nm({name: each.value for name, each in info.axis.items()})


@cache
def seen(profile: str, axis: str, plant: str, name: str = "", value: float = 0.0) -> tuple[Any, ...]:
    """All that was seen of an axis, with a number changed; a joint has a load that it just holds."""
    info = PROFILES[profile].axes[axis]
    numbers = {"load_torque_Nm": 0.99 * holding_Nm(profile, axis)} if profile == "walter" else {}
    if name:
        numbers[name] = value
    of_axis: dict[str, Any] = {"axis": numbers}
    is_only = len(PROFILES[profile].axes) == 1
    device: dict[str, Any] = {"profile": profile}
    device |= of_axis | {"plant": plant} if is_only else {"axes": {axis: of_axis}}
    if profile == "mechaduino":
        device |= {"flash": {"table": "identity"}}
    ready_ms, scene = SCENES[profile]
    target = "d" if is_only else f"d.{axis}"
    with Bench({"bench": "t", "devices": {"d": device}}) as bench:
        bench.run(ms=ready_ms)
        looks = [look(bench, target, info.law)]
        looks += [look(bench, target, info.law) for _ in scene(bench, target)]
    return tuple(looks)


CASES: list[Case] = [
    (profile, axis, plant, name)
    for profile, info in PROFILES.items()
    for axis, of_axis in info.axes.items()
    for plant in (PLANTS if set(FULL_PARAMETERS) <= of_axis.axis.keys() else PLANTS[:1])
    for name in of_axis.axis
]


def test_every_board_with_a_motor_is_here() -> None:
    with_numbers = {name for name, info in PROFILES.items() if any(each.axis for each in info.axes.values())}
    assert with_numbers == SCENES.keys()


@pytest.mark.parametrize("case", CASES, ids="-".join)
def test_a_number_changes_what_is_seen(case: Case) -> None:
    profile, axis, plant, name = case
    parameter = PROFILES[profile].axes[axis].axis[name]
    values = others(parameter, parameter.default(plant), name, holding_Nm(profile, axis))
    if profile in ("canopen_drive", "modbus_drive") and name == "rotor_teeth":
        with pytest.raises(ConfigError, match="commutates"):
            seen(profile, axis, plant, name, values[0])
        return
    before = seen(profile, axis, plant)
    changing = [value for value in values if seen(profile, axis, plant, name, value) != before]
    if values:  # else it is what it is
        assert bool(changing) == (without_effect(case) is None), without_effect(case)
