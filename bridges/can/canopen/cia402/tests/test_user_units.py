"""User units of positions, speeds and accelerations."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridges.can.canopen.cia402.drive_context import UserUnits

DEFAULT = {
    (0x6091, 1): 1,
    (0x6091, 2): 1,
    (0x6092, 1): 360_000,
    (0x6092, 2): 1,
    (0x6096, 1): 1,
    (0x6096, 2): 1,
}
DEFAULT |= {(0x6097, 1): 1, (0x6097, 2): 1, (0x607E, 0): 0}


def units(given: dict[tuple[int, int], int] | None = None, zero_deg: float = 0.0) -> UserUnits:
    values = DEFAULT | (given or {})
    return UserUnits.made(lambda index, subindex: values[index, subindex], zero_deg)


@pytest.mark.parametrize(
    ("given", "position", "angle_deg"),
    [
        ({}, 1, 0.001),
        ({}, -90_000, -90.0),
        ({(0x6091, 1): 10}, 360_000, 3600.0),
        ({(0x6091, 2): 10}, 360_000, 36.0),
        ({(0x6092, 1): 5, (0x6092, 2): 2}, 5, 720.0),
        ({(0x607E, 0): 0x80}, 90_000, -90.0),
    ],
)
def test_a_position_is_an_angle(given: dict[tuple[int, int], int], position: int, angle_deg: float) -> None:
    made = units(given)
    assert made.angle_deg(position) == angle_deg
    assert made.position(angle_deg) == position


def test_speeds_have_factors_of_their_own() -> None:
    made = units({(0x6096, 1): 60, (0x6096, 2): 360_000, (0x6097, 1): 1, (0x6097, 2): 1000})
    assert made.deg_per_s == pytest.approx(6.0)  # rpm
    assert made.velocity(360.0) == 60
    assert made.deg_per_s2 == pytest.approx(1.0)
    assert units({(0x607E, 0): 0x40}).velocity(360.0) == -360_000


@given(st.integers(-(2**31), 2**31 - 1), st.floats(-1e3, 1e3))
def test_a_position_comes_back(position: int, zero_deg: float) -> None:
    made = units(zero_deg=zero_deg)
    assert made.position(made.angle_deg(position)) == position
