"""The relay board: its thermostat, its fields from outside, and what hil shows of them."""

from pathlib import Path

import pytest
import yaml

from hil.testing import check_profile

HERE = Path(__file__).parent


@pytest.fixture
def b(bench):
    made = yaml.safe_load((HERE / "bench.yaml").read_text())
    made["profile_path"] = [str(HERE / "boards")]
    return bench({key: value for key, value in made.items() if key != "bridges"})


def asked(b, line, ms=100):
    b.port("r1").write(line)
    b.run(ms=ms)
    return b.port("r1").read()


def test_it_answers_with_its_fields(b):
    assert asked(b, b"fan 1\r") == b"ok\r\n"
    assert asked(b, b"?\r") == b"21.0 heater 0 fan 1\r\n"
    now = b.axis("r1").snapshot()
    assert (now.fan, now.heater, now.switched, now.temperature_degC) == (1, 0, 1, 21.0)


def test_a_hot_oven_opens_the_heaters_relay(b):
    asked(b, b"heater 1\r")
    b.axis("r1").set("temperature_degC", 85)
    b.wait_until("r1", "heater == 0", within_ms=150)
    assert b.axis("r1").snapshot().switched == 2


def test_a_reset_opens_relays_and_leaves_the_oven_hot(b):
    asked(b, b"fan 1\r")
    b.axis("r1").set("temperature_degC", 50)
    b.device("r1").reset()
    now = b.axis("r1").snapshot()
    assert (now.fan, now.switched, now.temperature_degC) == (0, 0, 50.0)


def test_each_oven_begins_as_the_bench_says(b):
    assert b.axis("oven").snapshot().temperature_degC == 45.0


def test_a_recording_has_its_fields(b):
    recording = b.axis("r1").record("temperature_degC", "heater", interval_ms=10)
    asked(b, b"heater 1\r")
    assert max(recording.column("heater")) == 1


def test_it_passes_the_checks_of_all_boards():
    check_profile(HERE / "boards/relay_board")
