"""Modes of CANopen drives on each kind of board, on a bus."""

import pytest

from bridges.can.testing.can_faces import DriveFace

STATE, REACHED = 0x6F, 1 << 10


def begun(drive: DriveFace, mode: int) -> DriveFace:
    drive.write(0x6060, 0, mode, 1)
    assert drive.enable() & STATE == 0x27
    return drive


def actual(drive: DriveFace) -> int:
    return drive.read(0x6064, is_signed=True)


@pytest.mark.parametrize("profile", ["mechaduino", "sac", "modbus_drive"])
def test_a_speed_is_kept_and_left(drive, profile: str) -> None:
    it = begun(drive(profile=profile), 3)
    bench = it.canbus.bench
    it.write(0x60FF, 0, 360_000, 4)
    bench.run(ms=2000)
    before = actual(it)
    bench.run(ms=1000)
    assert actual(it) - before == pytest.approx(360_000, rel=0.02)
    assert it.statusword & REACHED
    it.write(0x60FF, 0, -180_000, 4)
    bench.run(ms=2000)
    before = actual(it)
    bench.run(ms=1000)
    assert actual(it) - before == pytest.approx(-180_000, rel=0.02)
    it.controlword(0x10F)
    bench.run(ms=1000)
    before = actual(it)
    bench.run(ms=100)
    assert abs(actual(it) - before) < 200  # a fifth of a degree
    it.controlword(0x0F)
    bench.run(ms=1000)
    assert abs(actual(it) - before) > 10_000
    it.controlword(0x02)
    bench.run(ms=1000)
    assert it.statusword & 0x4F == 0x40, hex(it.statusword)


@pytest.mark.parametrize("profile", ["mechaduino", "sac", "modbus_drive"])
def test_a_target_may_change_on_the_way(drive, profile: str) -> None:
    it = begun(drive(profile=profile), 1)
    bench = it.canbus.bench
    it.write(0x607A, 0, 720_000, 4)
    it.controlword(0x1F)
    it.controlword(0x0F)
    bench.run(ms=700)
    it.write(0x607A, 0, -90_000, 4)
    it.controlword(0x3F)
    bench.run(ms=4000)
    assert actual(it) == pytest.approx(-90_000, abs=500)
    assert it.statusword & REACHED
    it.controlword(0x0F)
    for target in (0, 90_000):
        it.write(0x607A, 0, target, 4)
        it.controlword(0x1F)
        it.controlword(0x0F)
    bench.run(ms=4000)
    assert actual(it) == pytest.approx(90_000, abs=500)


SWITCHES = {
    "home": {"from_deg": 40, "to_deg": 60},
    "negative": {"below_deg": -720},
    "positive": {"above_deg": 720},
}
FULL_STEP_DEG = 1.8


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize(
    ("profile", "method", "home_deg"),
    [
        ("mechaduino", 24, 40),
        ("modbus_drive", 24, 40),
        ("sac", 24, 40),
        ("sac", 27, 60),
        ("mechaduino", 34, None),
        ("modbus_drive", 33, None),
    ],
)
def test_home_is_found(drive, profile: str, method: int, home_deg: float | None) -> None:
    it = begun(drive(profile=profile, switches=SWITCHES), 6)
    bench = it.canbus.bench
    it.write(0x6098, 0, method, 1)
    it.controlword(0x1F)
    bench.run(ms=12_000)
    assert it.statusword & 0x3400 == 0x1400, hex(it.statusword)
    zero_deg = bench.axis(it.axis).snapshot().position_deg - actual(it) / 1000
    if home_deg is None:  # an index pulse: it is there once a turn
        assert (zero_deg + 180) % 360 - 180 == pytest.approx(0, abs=0.5)
        return
    # A stepper knows no more than the full step in which the switch was seen.
    assert zero_deg == pytest.approx(home_deg, abs=FULL_STEP_DEG if profile == "sac" else 0.5)


@pytest.mark.parametrize("profile", ["mechaduino", "modbus_drive"])
def test_a_jam_is_a_following_error(drive, profile: str) -> None:
    it = begun(drive(profile=profile), 1)
    bench = it.canbus.bench
    it.write(0x607A, 0, 7_200_000, 4)
    with bench.fault("shaft_jam", it.axis):
        it.controlword(0x1F)
        bench.run(ms=2000)
        assert it.statusword & 0x4F == 0x08
        assert it.read(0x603F) == 0x8611
    it.controlword(0x80)
    assert it.statusword & 0x4F == 0x40
    begun(it, 1)


@pytest.mark.parametrize("profile", ["mechaduino", "modbus_drive"])
def test_the_position_is_told_while_the_loop_is_off(drive, profile: str) -> None:
    it = drive(profile=profile)
    bench = it.canbus.bench
    axis = bench.axis(it.axis)
    assert actual(it) == pytest.approx(axis.snapshot().position_deg * 1000, abs=100)
    begun(it, 1)
    bench.run(ms=200)
    before = actual(it)
    it.controlword(0x00)
    axis.load_torque_Nm = 0.05
    bench.run(ms=100)
    axis.load_torque_Nm = 0.0
    bench.run(ms=500)
    assert abs(actual(it) - before) > 1000
    assert actual(it) == pytest.approx(axis.snapshot().position_deg * 1000, abs=500)


def test_a_torque_turns_the_shaft(drive) -> None:
    it = begun(drive(profile="mechaduino"), 4)
    it.write(0x6071, 0, 100, 2)
    it.canbus.bench.run(ms=300)
    assert it.read(0x6077) == pytest.approx(100, abs=20)
    assert actual(it) > 10_000
