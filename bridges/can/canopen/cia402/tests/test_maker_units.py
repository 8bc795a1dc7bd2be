"""Units of makers' drives: by their factor objects, by SI units, by lines; and as hil's master has them."""

from collections.abc import Mapping

import pytest

from bridges.can.canopen.cia402.maker_units import contradictions, factors_of, units_with
from bridges.can.canopen.master.drive_units import NO_UNITS, GivenUnits, UnitsUnknown, units_of

Values = Mapping[tuple[int, int], int]
DEG, RPM, RPM_PER_S, MILLIDEG = 0x0041_0000, 0x00B4_4700, 0x00B4_4703, 0xFD41_0000
COUNTS = {(0x608F, 1): 4096, (0x608F, 2): 1}
FEED = {(0x6092, 1): 10_000, (0x6092, 2): 1}
GEAR = {(0x6091, 1): 10, (0x6091, 2): 1}
ONES = {(0x6092, 1): 1, (0x6092, 2): 1, (0x6096, 1): 1, (0x6096, 2): 1}


@pytest.mark.parametrize(
    ("values", "lines", "per_turn", "per_rpm", "per_rpm_per_s"),
    [
        (COUNTS, NO_UNITS, 4096, 4096 / 60, 4096 / 60),
        (COUNTS | ONES, NO_UNITS, 4096, 4096 / 60, 4096 / 60),
        (FEED, NO_UNITS, 10_000, 10_000 / 60, 10_000 / 60),
        (FEED | GEAR, NO_UNITS, 1000, 1000 / 60, 1000 / 60),
        (FEED | COUNTS, NO_UNITS, 10_000, 10_000 / 60, 10_000 / 60),
        ({(0x60A8, 0): MILLIDEG}, NO_UNITS, 360_000, 6000, 6000),
        ({(0x60A8, 0): DEG, (0x60A9, 0): RPM}, NO_UNITS, 360, 1, 1),
        (COUNTS | {(0x60A9, 0): RPM, (0x60AA, 0): RPM_PER_S}, NO_UNITS, 4096, 1, 1),
        (FEED | {(0x6096, 1): 60, (0x6096, 2): 10_000}, NO_UNITS, 10_000, 1, 10_000 / 60),
        ({}, GivenUnits(51_200.0), 51_200, 51_200 / 60, 51_200 / 60),
        (FEED | GEAR, GivenUnits(51_200.0), 51_200, 51_200 / 60, 51_200 / 60),
        (COUNTS, GivenUnits(None, 1.0), 4096, 1, 1),
        (COUNTS, GivenUnits(None, 1.0, 0.5), 4096, 1, 0.5),
        ({}, GivenUnits(333.25, 0.1), 333.25, 0.1, 0.1),
    ],
)
def test_units(
    values: Values, lines: GivenUnits, per_turn: float, per_rpm: float, per_rpm_per_s: float
) -> None:
    def given(index: int, subindex: int) -> int | None:
        return values.get((index, subindex))

    units = units_with(factors_of(given, lines), given)
    assert units.per_deg / units.deg * 360 == pytest.approx(per_turn)
    assert 6 / units.deg_per_s == pytest.approx(per_rpm)
    assert 6 / units.deg_per_s2 == pytest.approx(per_rpm_per_s)
    if (0x6091, 1) not in values and (0x6096, 1) not in values:  # the master asks for neither
        theirs = units_of(values, lines)
        assert theirs.position_per_deg * 360 == pytest.approx(per_turn)
        assert theirs.velocity_per_rpm == pytest.approx(per_rpm)
        assert theirs.acceleration_per_rpm_per_s == pytest.approx(per_rpm_per_s)


@pytest.mark.parametrize("values", [{}, ONES, {(0x608F, 1): 1, (0x608F, 2): 1}, {(0x6092, 1): 0}])
def test_a_file_that_does_not_say_what_a_turn_is(values: Values) -> None:
    with pytest.raises(UnitsUnknown, match="6092h, 608Fh, 60A8h"):
        factors_of(lambda index, subindex: values.get((index, subindex)), NO_UNITS)


def test_a_divisor_of_0_is_none() -> None:
    values = {**FEED, (0x6091, 1): 10, (0x6091, 2): 0}
    factors = factors_of(lambda index, subindex: values.get((index, subindex)), NO_UNITS)
    assert (factors[0x6091, 1], factors[0x6091, 2]) == (1, 1)


def test_lines_that_say_otherwise_are_found() -> None:
    def given(index: int, subindex: int) -> int | None:
        return COUNTS.get((index, subindex))

    assert contradictions(given, GivenUnits(1000.0)) == ("the file has 4096 units a turn, and this is 1000")
    assert contradictions(given, GivenUnits(4096.0)) == ""
    assert contradictions(lambda *_: None, GivenUnits(1000.0)) == ""
