"""Tests of ``home.py``, the same in memory, with ``--hil=live`` at a daemon, with ``--hil=slide.yaml`` at the
slide itself."""

from pathlib import Path

import pytest

HERE = Path(__file__).parent
SWITCH_DEG = -180
DEG_PER_STEP = 1.8
LEAVE_STEPS = 100


@pytest.fixture
def b(bench):
    made = bench(HERE / "bench.yaml")
    assert made.start() == []
    return made


def test_it_goes_home_and_to_its_places(b):
    home = b.program([HERE / "home.py", "s1", "400", "-20"])
    assert home.wait() == 0, home.stderr
    assert home.stdout == "home\nat 400\nat -20\n"
    if b.kind != "real":
        at_deg = SWITCH_DEG + (LEAVE_STEPS - 20) * DEG_PER_STEP
        assert b.axis("s1").snapshot().position_deg == pytest.approx(at_deg, abs=5)


def test_without_the_switch_it_stops_the_motor(b):
    home = b.program([HERE / "home.py", "s1", "--home-within", "0.2"])
    assert home.wait() == 1
    assert home.stderr == "home.py: the switch did not come within 0.2 s; the motor was stopped\n"
    if b.kind != "real":
        b.wait_until("s1", "speed_rpm == 0", within_ms=10)


def test_a_cable_that_comes_out_is_told(b):
    home = b.program([HERE / "home.py", "s1"])
    b.run(ms=500)
    b.fault("host_close", "s1")
    assert home.wait() == 1
    assert home.stderr == "home.py: no answer to 'vd' within 1 s\n"


def test_lost_bytes_end_in_a_message(b):
    b.fault("byte_drop", "s1", rate=0.02)
    home = b.program([HERE / "home.py", "s1"])
    assert home.wait() == 1
    assert home.stderr.startswith("home.py: ")
    assert "Traceback" not in home.stderr
