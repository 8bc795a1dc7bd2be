"""The drive at its registers: what a master writes, what the shaft does, what the registers tell."""

from collections.abc import Callable
from typing import Any

import pytest

from bridges.modbus.protocol.client_side import ask_identification, mask_write, read, write_single
from bridges.modbus.protocol.pdu import Table

ENABLE, START, STOP, RESET, FOLLOW = 1, 2, 4, 8, 16
CONTROL, FAULT_CODE = 4, 5
BAD_ADDRESS, BAD_VALUE, BUSY = 2, 3, 6
Make = Callable[..., Any]


def test_a_point_by_set_point_start_and_moving(master: Make) -> None:
    plc = master()
    assert plc.status == set()
    assert plc.position_deg == 0.0
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.status == {"enabled"}
    assert plc.target(90.0) == ()
    assert plc.put(CONTROL, ENABLE | START) == ()
    assert plc.status == {"enabled", "moving"}
    plc.run(100)
    (speed, current) = plc.told(2, 2)
    assert 580 <= speed <= 620  # 60 rpm, on the way
    assert 0 < current < 2200
    plc.run(500)
    assert plc.status == {"enabled"}
    assert plc.position_deg == pytest.approx(90.0, abs=0.1)


def test_all_of_a_point_in_one_request_and_the_next_one_on_the_way(master: Make) -> None:
    plc = master()
    assert plc.target(360.0, control=(120, 1200, ENABLE | START)) == ()
    plc.run(300)
    assert 0 < plc.position_deg < 360
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.target(-90.0, control=(300, 6000, ENABLE | START)) == ()
    plc.run(1500)
    assert plc.status == {"enabled"}
    assert plc.position_deg == pytest.approx(-90.0, abs=0.1)
    assert plc.kept(2, 3) == (300, 6000, ENABLE | START)


def test_the_speed_and_the_ramps_are_those_of_the_registers(master: Make) -> None:
    plc = master()
    recording = plc.axis.record("r")
    plc.target(60.0, control=(10, 20, ENABLE | START))  # 0.5 s of ramp, 15 deg each, 0.5 s between them
    plc.run(2000)
    times = [at for at, r in zip(recording.at_s(), recording.column("r"), strict=True) if 0 < r < 60]
    assert times[-1] - times[0] == pytest.approx(1.5, abs=0.01)


def test_stop_is_a_ramp_and_keeps_start_away_while_it_is_one(master: Make) -> None:
    plc = master()
    plc.target(3600.0, control=(60, 60, ENABLE | START))
    plc.run(2000)
    assert plc.put(CONTROL, ENABLE | STOP) == ()
    assert plc.status == {"enabled", "moving"}
    plc.run(1500)
    assert plc.status == {"enabled"}
    stands_at = plc.position_deg
    assert 300 < stands_at < 1000
    assert plc.put(CONTROL, ENABLE | STOP | START) == BUSY
    assert plc.put(CONTROL, ENABLE) == ()
    plc.run(200)
    assert plc.position_deg == pytest.approx(stands_at, abs=0.05)


def test_set_points_are_followed_while_follow_is_one(master: Make) -> None:
    plc = master()
    assert plc.put(CONTROL, ENABLE | FOLLOW) == ()
    plc.run(100)
    assert plc.position_deg == pytest.approx(0.0, abs=0.1)  # no jump: the set-point was preset
    for step in range(20):
        assert plc.target(step * 0.5) == ()
    assert plc.status == {"enabled", "moving"}
    plc.run(100)
    assert plc.status == {"enabled"}
    assert plc.position_deg == pytest.approx(9.5, abs=0.1)
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.target(50.0) == ()
    plc.run(100)
    assert plc.position_deg == pytest.approx(9.5, abs=0.1)


def test_a_set_point_comes_whole_or_not_at_all(master: Make) -> None:
    plc = master()
    plc.put(CONTROL, ENABLE | FOLLOW)
    high, low = 0xFFFF, 0x10000 - 1000  # -10 deg
    assert plc.ask(write_single(Table.HOLDING_REGISTERS, 0, high)) == ()
    plc.run(50)
    assert plc.position_deg == pytest.approx(0.0, abs=0.1)
    plc.ask(write_single(Table.HOLDING_REGISTERS, 1, low))
    plc.run(100)
    assert plc.position_deg == pytest.approx(-10.0, abs=0.1)
    assert plc.kept(0, 2) == (high, low)


@pytest.mark.parametrize(
    ("address", "words", "code"),
    [
        (2, (0,), BAD_VALUE),  # a speed of 0
        (2, (3001,), BAD_VALUE),
        (CONTROL, (32,), BAD_VALUE),  # a bit that means nothing
        (CONTROL, (ENABLE | START | FOLLOW,), BUSY),
        (CONTROL, (START,), BUSY),
        (5, (1,), BAD_ADDRESS),
        (3, (600, ENABLE, 1), BAD_ADDRESS),
        (0, (0x7FFF, 0xFFFF), BAD_VALUE),  # 21 million degrees
        (10, (0x7FC0, 0), BAD_VALUE),  # NaN
    ],
)
def test_what_is_refused_changes_nothing(
    master: Make, address: int, words: tuple[int, ...], code: int
) -> None:
    plc = master()
    before = plc.kept(0, 5), plc.kept(10, 6), plc.status
    assert plc.put(address, *words) == code
    assert (plc.kept(0, 5), plc.kept(10, 6), plc.status) == before


def test_a_start_that_is_refused_can_be_written_again(master: Make) -> None:
    plc = master()
    plc.target(20.0)
    assert plc.put(CONTROL, START) == BUSY
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.put(CONTROL, ENABLE | START) == ()
    plc.run(500)
    assert plc.position_deg == pytest.approx(20.0, abs=0.1)


def test_what_is_not_there_is_not_read(master: Make) -> None:
    plc = master()
    assert plc.told(0, 6) != BAD_ADDRESS
    assert plc.told(0, 7) == BAD_ADDRESS
    assert plc.kept(5) == BAD_ADDRESS
    assert plc.ask(read(Table.COILS, 0)) == BAD_ADDRESS


def test_a_mask_sets_a_bit_of_the_control_word(master: Make) -> None:
    plc = master()
    plc.ask(mask_write(CONTROL, 0xFFFF & ~ENABLE, ENABLE))
    assert plc.status == {"enabled"}
    plc.ask(mask_write(CONTROL, 0xFFFF & ~ENABLE, 0))
    assert plc.status == set()


def test_gains_are_parameters(master: Make) -> None:
    plc = master()
    assert plc.put(10, 0x41A0, 0) == ()  # 20
    assert plc.axis.snapshot().pKp == 20.0
    assert plc.kept(10, 2) == (0x41A0, 0)


def test_a_jammed_shaft_is_a_following_error_which_reset_clears(master: Make) -> None:
    plc = master()
    plc.put(CONTROL, ENABLE)
    with plc.bench.fault("shaft_jam", "m1"):
        plc.target(360.0, control=(60, 600, ENABLE | START))
        plc.run(500)
        assert plc.status == {"fault"}
        assert plc.told(FAULT_CODE) == (1,)
        assert "fault 1" in plc.drive.notes["fault"]
    assert plc.put(CONTROL, ENABLE) == ()  # a cyclic master goes on without an exception
    assert plc.put(CONTROL, 0) == ()
    assert plc.put(CONTROL, ENABLE) == BUSY
    assert plc.put(CONTROL, RESET) == ()
    assert plc.status == set()
    assert plc.told(FAULT_CODE) == (0,)
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.status == {"enabled"}
    assert plc.drive.notes == {}


def test_after_a_reset_the_loop_stays_off_until_enable_becomes_one_anew(master: Make) -> None:
    plc = master()
    plc.put(CONTROL, ENABLE)
    plc.drive.set_register("errfl", 1)
    assert plc.told(FAULT_CODE) == (2,)
    assert plc.put(CONTROL, ENABLE | RESET) == ()  # enable was one all the time
    assert plc.status == set()
    plc.put(CONTROL, 0)
    plc.put(CONTROL, ENABLE)
    assert plc.status == {"enabled"}


@pytest.mark.parametrize(
    ("device", "fault", "parameters"),
    [({}, "thermal_trip", {}), ({"plant": "full"}, "supply_sag", {"supply_V": 0.0})],
)
def test_a_motor_without_current_is_a_fault_once_it_has_to_hold(
    master: Make, device: dict[str, Any], fault: str, parameters: dict[str, float]
) -> None:
    plc = master(device)
    plc.target(0.0, control=(60, 600, ENABLE))
    plc.run(100)
    assert plc.status == {"enabled"}
    with plc.bench.fault(fault, "m1", **parameters):
        plc.axis.load_torque_Nm = 0.1
        plc.run(400)
    assert plc.told(FAULT_CODE)[0] in (1, 3)
    assert plc.status == {"fault"}


def test_who_is_without_power_forgets_and_starts_with_the_loop_off(master: Make) -> None:
    plc = master()
    plc.target(45.0, control=(30, 600, ENABLE | START))
    plc.run(1000)
    plc.drive.reset()
    plc.run(100)
    assert plc.put(CONTROL, ENABLE) == BUSY  # it starts
    plc.run(200)
    assert plc.kept(2, 3) == (60, 600, 0)
    assert plc.status == set()
    assert plc.position_deg == pytest.approx(45.0, abs=0.2)


def test_it_says_what_its_map_says(master: Make) -> None:
    plc = master()
    pieces = plc.raw(ask_identification()).identification
    assert list(pieces.objects.values()) == [b"hil", b"modbus_drive", b"1"]


def test_the_shaft_turned_by_hand_is_told_while_the_loop_is_off(master: Make) -> None:
    plc = master()
    plc.bench.fault("steps_lost", "m1", turn_deg=30.0)
    plc.run(50)
    assert plc.position_deg == pytest.approx(30.0, abs=0.1)


def test_a_start_that_would_do_nothing_is_refused_where_one_is_meant(master: Make) -> None:
    plc = master()
    plc.put(CONTROL, ENABLE)
    plc.target(90.0)
    assert plc.put(CONTROL, ENABLE | START) == ()
    plc.run(1500)
    plc.target(45.0)
    assert plc.put(CONTROL, ENABLE | START) == BUSY
    assert plc.put(CONTROL, ENABLE | START) == BUSY, "also when it is tried again"
    assert plc.put(CONTROL, ENABLE) == ()
    assert plc.put(CONTROL, ENABLE | START) == ()
    plc.run(1500)
    assert plc.position_deg == pytest.approx(45.0, abs=0.1)


def test_who_writes_in_a_cycle_is_not_refused(master: Make) -> None:
    """It has written the bit again before there was another set-point, or writes it with the set-point, or
    while the axis moves."""
    plc = master()
    plc.put(CONTROL, ENABLE)
    plc.target(90.0)
    for _ in range(40):
        assert plc.put(CONTROL, ENABLE | START) == ()
        plc.run(50)
    plc.target(45.0)
    for control in (ENABLE | START, ENABLE | START, ENABLE, ENABLE | START):
        assert plc.put(CONTROL, control) == ()
    plc.target(50.0)
    assert plc.put(CONTROL, ENABLE | START) == (), "it moves"
    plc.run(1500)
    assert plc.position_deg == pytest.approx(45.0, abs=0.1)
    for _ in range(3):
        assert plc.target(60.0, control=(60, 600, ENABLE | START)) == ()
        plc.run(500)


def test_a_set_point_that_is_written_again_is_no_other_one(master: Make) -> None:
    plc = master()
    plc.put(CONTROL, ENABLE)
    for _ in range(3):
        assert plc.target(90.0) == ()
        assert plc.put(CONTROL, ENABLE | START) == ()
        plc.run(1500)


COMMANDS = {
    "modbus_map": 1,
    "position_deg": {"input": 0, "type": "i32", "scale": 0.01},
    "status": {"enabled": {"input": 4, "bit": 0}, "moving": {"input": 4, "bit": 1}},
    "set_point_deg": {"holding": 0, "type": "i32", "scale": 0.01},
    "control": {
        "enable": {"holding": 4, "bit": 0},
        "start": {"holding": 5, "bit": 4, "on_write": True},
        "stop": {"holding": 5, "bit": 6, "on_write": True},
        "reset": {"coil": 0, "on_write": True},
    },
}


def test_each_write_is_a_command_where_the_map_says_so(master: Make) -> None:
    plc = master({"map": COMMANDS})
    plc.put(CONTROL, ENABLE)
    for target_deg in (90.0, 45.0, 45.0):
        plc.target(target_deg)
        assert plc.put(5, 0x10) == ()
        assert plc.kept(5) == (0,), "the register clears itself"
        plc.run(1500)
        assert plc.position_deg == pytest.approx(target_deg, abs=0.1)
    plc.target(3600.0)
    plc.put(5, 0x10)
    plc.run(300)
    assert plc.put(5, 0x40) == ()
    plc.run(500)
    here_deg = plc.position_deg
    assert (plc.kept(5), plc.status) == ((0,), {"enabled"})
    assert 45 < here_deg < 3500
    plc.target(3600.0)
    assert plc.put(5, 0x10) == (), "stop has cleared itself and keeps nothing away"
    plc.run(100)
    assert plc.status == {"enabled", "moving"}
