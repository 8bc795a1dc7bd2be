"""Pulses of a move, against the manual's interrupt done step by step."""

import pytest

from device_profiles.uno.constants import Constants, boot_text, counts_of, ramp_of
from device_profiles.uno.ramp import HIGH_NS, paused, pulses_of
from hil.vocab.firmware import Pulses


def interrupts(steps: int, counts: int, accel_during: int) -> list[int]:
    """Counts before each step, as setup() and the interrupt of the manual have them."""
    delta = (255 - counts) // accel_during if accel_during > 0 else 0
    first, during = counts + delta * accel_during, accel_during
    if accel_during > 0 and delta <= 0:
        delta, first, during = (1, 255, 255 - counts) if counts < 255 else (0, counts, 0)
    register, up, down, before = first, during, during, []
    for left in range(steps, 0, -1):
        before.append(register or 256)
        if left == down:
            down, register = down - 1, (register + delta) % 256
        elif up > 0:
            up, register = up - 1, (register - delta) % 256
    return before


@pytest.mark.parametrize("accel_during", [0, 1, 10, 100, 255])
@pytest.mark.parametrize("counts", [1, 18, 141, 254, 255])
@pytest.mark.parametrize("steps", [1, 2, 9, 10, 11, 15, 19, 20, 21, 500])
def test_a_move_has_the_manuals_delays(steps: int, counts: int, accel_during: int) -> None:
    rows = pulses_of(steps, ramp_of(counts, accel_during))
    delays = [row.period_ns for row in rows for _ in range(row.number)]
    assert delays == [each * 8000 for each in interrupts(steps, counts, accel_during)]
    assert all(0 < row.high_ns < row.period_ns for row in rows)


def test_the_manuals_ramp() -> None:
    assert ramp_of(18, 10) == (248, 23, 10)
    delays_us = [row.period_ns // 1000 for row in pulses_of(1600, ramp_of(18, 10)) for _ in range(row.number)]
    up_us = [1984 - 184 * k for k in range(11)]
    assert delays_us == [*up_us, *[144] * 1579, *reversed(up_us[1:])]


def test_a_long_move_is_few_rows() -> None:
    assert len(pulses_of(2_000_000_000, ramp_of(18, 10))) == 20


def test_a_pause_delays_the_first_pulse_alone() -> None:
    assert paused([Pulses(3, 8000, HIGH_NS)], 50) == [Pulses(1, 8050, HIGH_NS), Pulses(2, 8000, HIGH_NS)]


def test_the_manuals_numbers() -> None:
    manual = Constants()
    assert manual.delay_us == 140
    assert manual.with_values({"microStepping": 1.0}).delay_us == 1125
    assert counts_of(140) == 18
    assert boot_text(manual) == (
        b"18.00\r\n23\r\n248\r\nInter Step Delay: 140 us\r\nMax Speed: 267.86 RPM\r\n"
        b"Inter Step Delay programat a Timer2: 144\r\nMax Speed Real: 260.42"
    )
    assert round(1e6 / (1600 * 18 * 8), 2) == 4.34  # turns a second


@pytest.mark.parametrize(
    ("values", "first_lines"),
    [
        ({"accelDuring": 0.0}, b"18.00\r\n18\r\n"),
        ({"accelDuring": 255.0}, b"18.00\r\n0\r\n255\r\n"),
        ({"microStepping": 1.0, "l": 90.0}, b"254.00\r\n0\r\n255\r\n"),
        ({"microStepping": 1.0, "l": 90.6, "accelDuring": 1.0}, b"255.00\r\n0\r\n255\r\n"),
        ({"l": 1.0}, b"1.00\r\n25\r\n251\r\n"),
    ],
)
def test_the_special_cases_of_the_ramp(values: dict[str, float], first_lines: bytes) -> None:
    assert boot_text(Constants().with_values(values)).startswith(first_lines)
