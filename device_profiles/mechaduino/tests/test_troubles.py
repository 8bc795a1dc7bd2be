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
