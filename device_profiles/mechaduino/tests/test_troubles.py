"""Symptoms of ``docs/how-to/mechaduino-troubles.md`` on the bench."""

import pytest

from hil.testing import Bench


def _bench(**keys):
    bench = Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino", **keys}}})
    bench.run(ms=4100)
    port = bench.port("m1")
    port.read()
    return bench, port


@pytest.mark.parametrize(
    ("register", "said", "is_good"),
    [(0x05FF, b"MAGL - ", False), (0x0900, b"MAGH - ", False), (0x0180, b"Looks good!", True)],
)
def test_a_magnet_too_far_or_too_near_is_said_by_the_diagnostics(register, said, is_good):
    bench, port = _bench(registers={"diaagc": register})
    port.write(b"e")
    bench.run(ms=10)
    answer = port.read()
    assert said in answer
    assert (b"MAG" not in answer) == is_good


def _error_deg(bench, port):
    """Range of the differences between the angles of board and shaft, over a turn of set-points."""
    port.write(b"xy")
    bench.run(ms=500)
    errors = []
    for step in range(12):
        port.write(b"r%d\n" % (30 * step))
        bench.run(ms=700)
        now = bench.axis("m1").snapshot()
        errors.append(now.yw - now.position_deg)
    return max(errors) - min(errors)


def test_a_magnet_off_the_axis_swings_once_a_turn_until_it_is_calibrated():
    bench, port = _bench(plant="full", axis={"encoder_eccentricity_deg": 1}, flash={"table": "identity"})
    assert _error_deg(bench, port) > 1.5
    port.write(b"n")
    bench.run(ms=10)
    port.write(b"c")
    bench.run(ms=60_000)
    assert b"Calibration complete!" in port.read()
    assert _error_deg(bench, port) < 0.7


def _rest_deg(load_Nm):
    """Angle that the table has for a step's place, calibrated under a load, less the shaft's."""
    bench, port = _bench(flash={"table": "empty"})
    fault = bench.fault("shaft_load", "m1", torque_Nm=load_Nm) if load_Nm else None
    bench.run(ms=500)
    port.write(b"c")
    bench.run(ms=30_000)
    if fault:
        fault.clear()
    port.write(b"xy")
    bench.run(ms=1000)
    now = bench.axis("m1").snapshot()
    return (now.yw - now.position_deg + 180) % 360 - 180


def test_a_calibration_under_load_keeps_its_offset():
    assert abs(_rest_deg(0.03) - _rest_deg(0.0)) > 0.2


def test_a_hung_main_program_is_silent_and_holds():
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr30\n")
    bench.run(ms=1500)
    port.read()
    bench.fault("node_hang", "m1")
    port.write(b"m")
    bench.axis("m1").load_torque_Nm = 0.05
    bench.run(ms=1000)
    assert port.read() == b""
    assert bench.axis("m1").snapshot().yw == pytest.approx(30, abs=1)


def test_a_reset_by_itself_prints_the_menu_and_frees_the_motor():
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr30\n")
    bench.run(ms=1500)
    bench.fault("node_reset", "m1")
    port.read()
    bench.run(ms=4100)
    assert b"Main menu" in port.read()
    assert (bench.axis("m1").snapshot().loop_on, bench.axis("m1").snapshot().r) == (0, 0)


@pytest.mark.parametrize("is_reset", [False, True])
def test_a_rotor_that_the_loop_has_left_between_steps_may_look_wired_backwards(is_reset):
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr90\n")
    bench.run(ms=1500)
    port.write(b"n")
    bench.run(ms=500)
    if is_reset:
        bench.device("m1").reset()
        bench.run(ms=4100)
    port.write(b"c")
    bench.run(ms=60_000)
    assert (b"Calibration complete!" if is_reset else b"Wired backwards") in port.read()


def test_a_magnet_whose_counts_hardly_change_is_calibrated_and_nothing_is_written():
    bench, port = _bench(flash={"table": "empty"})
    bench.fault("encoder_freeze", "m1")
    port.write(b"c")
    bench.run(ms=60_000)
    assert b"Calibration complete!" in port.read()
    bench.device("m1").reset()
    bench.run(ms=4100)
    assert b"WARNING: Lookup table is empty!" in port.read()


@pytest.mark.parametrize(("counts", "holds"), [(50, True), (200, False)])
def test_a_magnet_that_has_slipped_is_off_by_its_angle_or_runs_away(counts, holds):
    """A quarter of an electrical turn, 82 counts, is as far as the commutation bears it."""
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr90\n")
    bench.run(ms=1500)
    before_deg = bench.axis("m1").snapshot().position_deg
    bench.fault("encoder_slip", "m1", counts=counts)
    bench.run(ms=1500)
    shot = bench.axis("m1").snapshot()
    off_deg = before_deg - shot.position_deg
    if holds:
        assert shot.yw == pytest.approx(90, abs=0.2)
        assert off_deg == pytest.approx(counts * 360 / 16384, abs=0.3)
        return
    assert abs(off_deg) > 360
    bench.device("m1").reset()
    bench.run(ms=4100)
    port.write(b"c")
    bench.run(ms=60_000)
    port.write(b"xyr30\n")
    bench.run(ms=2000)
    assert bench.axis("m1").snapshot().yw == pytest.approx(30, abs=0.2)


def test_a_monitor_whose_port_was_away_loses_text_and_the_loop_goes_on():
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr30\n")
    bench.run(ms=1500)
    port.read()
    begun = bench.axis("m1").snapshot().control_steps
    bench.fault("host_close", "m1", for_s=2)
    port.write(b"m")
    bench.run(ms=1900)
    assert port.read() == b""
    shot = bench.axis("m1").snapshot()
    assert shot.yw == pytest.approx(30, abs=0.2)
    assert shot.control_steps - begun == pytest.approx(1.9 * 6500, rel=0.01)
    bench.run(ms=200)
    port.write(b"m")
    bench.run(ms=100)
    assert port.read() != b""


def test_a_driver_that_trips_lets_go_and_comes_back_with_a_wound_up_integral():
    bench, port = _bench(flash={"table": "identity"})
    port.write(b"xyr30\n")
    bench.run(ms=1500)
    bench.axis("m1").load_torque_Nm = 0.02
    bench.run(ms=500)
    before = bench.axis("m1").snapshot()
    bench.fault("thermal_trip", "m1", start_s=1, for_s=2, every_s=10)
    bench.run(ms=2900)
    limp = bench.axis("m1").snapshot()
    assert (limp.current_a_A, limp.current_b_A, limp.loop_on) == (0, 0, 1)
    assert abs(limp.yw - 30) > 5
    assert abs(limp.ITerm) > abs(before.ITerm) + 20
    rows = bench.axis("m1").record("yw", interval_ms=1)
    bench.run(ms=2000)
    assert min(abs(row[1] - 30) for row in rows.rows) < 1
    bench.run(ms=8000)
    assert bench.axis("m1").snapshot().current_a_A == 0  # every ten seconds


@pytest.mark.parametrize(("start_deg", "jumps"), [(190, True), (350, True), (170, False)])
def test_a_first_step_beyond_half_a_turn_counts_a_turn_that_was_none(start_deg, jumps):
    bench, port = _bench(axis={"start_deg": start_deg}, flash={"table": "identity"})
    before_deg = bench.axis("m1").snapshot().position_deg
    port.write(b"xy")
    bench.run(ms=1500)
    moved_deg = abs(bench.axis("m1").snapshot().position_deg - before_deg)
    assert moved_deg == pytest.approx(360 if jumps else 0, abs=5)
