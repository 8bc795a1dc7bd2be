"""``easydriver_ramp.ino``: the article's lines, the times of its steps, and what its ramp is good for."""

from itertools import pairwise

import pytest

from device_profiles.uno.constants import Constants, boot_text, ramp_of
from device_profiles.uno.ramp import pulses_of

CYCLES_PER_COUNT = 128
STEPS, RAMP, FULL = 1600, 10, 18
LATE_CYCLES = 160
"""Most by which a step is late: an instruction and the interrupt that counts milliseconds."""
HOLDING_NM = 0.48 * 0.135


def gaps_of(edges):
    """Cycles between rising edges, at 16 MHz."""
    rises_ns = [at_ns for at_ns, level in edges if level]
    return [(later - earlier) * 16 / 1000 for earlier, later in pairwise(rises_ns)]


def asked_gaps():
    """Cycles between steps by OCR2A's values, which the article takes for counts: one more than these."""
    rows = pulses_of(STEPS, ramp_of(FULL, RAMP))
    counts = [row.period_ns // 8000 for row in rows for _ in range(row.number)]
    return [(count + 1) * CYCLES_PER_COUNT for count in counts[1:]]


def test_it_prints_the_articles_lines(bench, built):
    b = bench(built("easydriver_ramp") / "bench.yaml")
    b.run(ms=500)
    assert b.port("u1").read() == boot_text(Constants())


def test_a_step_takes_152_us_where_the_article_says_144(bench, built):
    b = bench(built("easydriver_ramp") / "bench.yaml")
    step = b.device("u1").pin("D6")
    b.run(ms=1700)
    gaps, asked = gaps_of(step.edges()), asked_gaps()
    assert len(gaps) == len(asked) == STEPS - 1
    assert all(abs(gap - wanted) <= LATE_CYCLES for gap, wanted in zip(gaps, asked, strict=True))
    assert sum(gaps) == pytest.approx(sum(asked), abs=LATE_CYCLES)
    assert min(asked) == 152 * 16


def test_the_motor_turns_once_and_back(bench, built):
    b = bench(built("easydriver_ramp") / "bench.yaml")
    places = []
    for _ in range(2):
        b.run(ms=1500)
        places.append(b.axis("d1").snapshot().position_deg)
    assert places == pytest.approx([360.9, 0.9], abs=0.3)


def test_without_the_ramp_a_loaded_motor_stays(bench, built):
    """A third of what the motor holds is no load with the ramp, and too much without."""
    places = []
    for ramp in (RAMP, 0):
        folder = built("easydriver_ramp", {"RAMP_STEPS = 10": f"RAMP_STEPS = {ramp}"})
        b = bench(folder / "bench.yaml")
        b.axis("d1").load_torque_Nm = -0.3 * HOLDING_NM
        b.run(ms=1700)
        places.append(b.axis("d1").snapshot().position_deg)
    assert places[0] == pytest.approx(360.9, abs=1)
    assert places[1] < 0
