"""``timer_stepper.ino``: how fast its class goes, and where it arrives."""

from itertools import pairwise

import pytest

THERE, ACCELERATION, MOST = 3200, 8000, 4000


def rises(edges):
    return [at_ns / 1e9 for at_ns, level in edges if level]


def test_it_goes_there_and_back_and_tells(bench, built):
    b = bench(built("timer_stepper") / "bench.yaml")
    port, heard = b.port("u1"), []
    b.wait_until(lambda: heard.append(port.read()) or b"at 0\r\n" in b"".join(heard), within_ms=5000)
    lines = b"".join(heard).decode().split("\r\n")
    assert f"at {THERE}" in lines
    told = [tuple(map(int, line.split())) for line in lines if line[:1].isdigit()]
    assert max(speed for _, speed in told) == MOST
    assert min(speed for _, speed in told) == -MOST


def test_its_speed_grows_by_the_acceleration(bench, built):
    b = bench(built("timer_stepper") / "bench.yaml")
    step = b.device("u1").pin("D6")
    b.wait_until("d1", "steps_taken == 3200", within_ms=5000)
    at_s = rises(step.edges())
    for earlier, later in ((100, 400), (400, 900)):  # from standstill n steps take sqrt(2 n / a)
        asked_s = (2 / ACCELERATION) ** 0.5 * (later**0.5 - earlier**0.5)
        assert at_s[later] - at_s[earlier] == pytest.approx(asked_s, rel=0.01)
    fastest_s = min(later - earlier for earlier, later in pairwise(at_s))
    assert fastest_s == pytest.approx(1 / MOST, abs=10e-6)
    assert at_s[-1] - at_s[-2] > 1 / 200  # and as slow at the end as at the start


def test_the_motor_arrives(bench, built):
    b = bench(built("timer_stepper") / "bench.yaml")
    b.wait_until("d1", "steps_taken == 3200", within_ms=5000)
    b.run(ms=100)
    assert b.axis("d1").snapshot().lag_steps == pytest.approx(0, abs=0.1)


def test_a_motor_that_was_held_fast_does_not(bench, built):
    b = bench(built("timer_stepper") / "bench.yaml")
    b.run(ms=500)
    with b.fault("shaft_jam", "d1"):
        b.run(ms=300)
    b.wait_until("d1", "steps_taken == 3200", within_ms=5000)
    b.run(ms=300)
    axis = b.axis("d1").snapshot()
    assert axis.commanded_deg - axis.position_deg > 90
