"""Builds of the firmware for other motors and uses, and what a wrong one does."""

import pytest

from hil.testing import Bench

NINE_TENTHS = {"rotor_teeth": 100}
"""A motor of 0.9 degree."""


def _bench(**keys):
    bench = Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino", **keys}}})
    port = bench.port("m1")
    bench.run(ms=4100)
    return bench, port, port.read()


def _calibrated(bench, port, ms=60_000):
    port.write(b"c")
    bench.run(ms=ms)
    return port.read()


def _goes_to_90(bench, port):
    """True if the shaft turns by as much as the set-point does."""
    port.write(b"xy")
    bench.run(ms=500)
    begun = bench.axis("m1").snapshot()
    port.write(b"r%.2f\n" % (begun.r + 90))
    bench.run(ms=2000)
    now = bench.axis("m1").snapshot()
    return abs(now.e) < 0.2 and now.position_deg - begun.position_deg == pytest.approx(90, abs=0.3)


@pytest.mark.parametrize("motor", [{"axis": NINE_TENTHS}, {"motor": "nema17-2A-400"}])
def test_a_motor_of_400_steps_with_its_build_is_calibrated_and_holds_angles(motor):
    bench, port, _ = _bench(**motor, parameters={"spr": 400}, flash={"table": "empty"})
    said = _calibrated(bench, port)
    assert said.count(b"%") == 20
    assert b"\r\n95% " in said
    assert b"Calibration complete!" in said
    assert pytest.approx(0.9) == bench.axis("m1").snapshot().PA
    assert _goes_to_90(bench, port)


@pytest.mark.parametrize(
    ("teeth", "spr", "turns"), [(100, 200, 0.5), (50, 400, 2)], ids=["400 steps, 200", "200 steps, 400"]
)
def test_a_build_for_another_motor_says_that_it_is_complete_and_holds_no_angle(teeth, spr, turns):
    bench, port, _ = _bench(axis={"rotor_teeth": teeth}, parameters={"spr": spr}, flash={"table": "empty"})
    begun_deg = bench.axis("m1").snapshot().position_deg
    said = _calibrated(bench, port)
    assert b"Calibration complete!" in said
    assert b"Wired backwards" not in said
    turned_deg = bench.axis("m1").snapshot().position_deg - begun_deg
    assert turned_deg == pytest.approx(turns * 360, abs=5)
    assert not _goes_to_90(bench, port)


def test_what_the_user_edits_is_there_from_the_first_command_on():
    parameters = {"pKp": 20, "vLPF": 50, "iMAX": 1.5, "PA": 2.0, "identifier": "elbow"}
    bench, _, said = _bench(parameters=parameters)
    assert b"\r\nIdentifier: elbow\r\n" in said
    now = bench.axis("m1").snapshot()
    assert (now.pKp, now.vLPF, now.uMAX, now.PA, now.vref1) == (20, 50, 173, 2.0, 57)
    assert (now.pKi, now.mode, now.loop_on) == (pytest.approx(0.2), 0, 0)


def test_it_may_start_in_closed_loop_and_does_so_after_each_reset():
    bench, _, _ = _bench(parameters={"starts_in": "position"}, flash={"table": "identity"})
    bench.run(ms=1000)
    for _ in range(2):
        now = bench.axis("m1").snapshot()
        assert (now.loop_on, chr(now.mode), now.r) == (1, "x", 0)
        assert abs(now.yw) < 0.2
        bench.device("m1").reset()
        bench.run(ms=3900)
        assert not bench.axis("m1").snapshot().loop_on
        bench.run(ms=1500)


def test_the_stock_build_is_the_one_of_the_sources():
    bench, _, said = _bench()
    assert b"\r\nIdentifier: x\r\n" in said
    now = bench.axis("m1").snapshot()
    assert (now.uMAX, now.PA, now.vref1) == (115, pytest.approx(1.8), 37)


@pytest.mark.parametrize(("coils", "is_backwards"), [("A", True), ("B", True), ("AB", False)])
def test_a_swapped_phase_is_said_by_the_calibration_and_two_are_none(coils, is_backwards):
    faults = [{"fault": "phase_swapped", "target": "m1", "coil": coil} for coil in coils]
    device = {"profile": "mechaduino", "axis": {"start_deg": 40}, "flash": {"table": "empty"}}
    bench = Bench({"bench": "t", "devices": {"m1": device}, "faults": faults})
    port = bench.port("m1")
    bench.run(ms=4100)
    assert (b"Wired backwards" in _calibrated(bench, port, 2000)) == is_backwards


@pytest.mark.parametrize("kind", ["motor_unplugged", "motor_power_off"])
def test_a_calibration_without_a_motor_says_that_it_is_complete_and_writes_nothing(kind):
    bench, port, _ = _bench(flash={"table": "empty"})
    bench.fault(kind, "m1")
    said = _calibrated(bench, port, 30_000)
    assert b"page size PSZ=3 \r\n" in said
    assert b"Calibration complete!" in said
    bench.device("m1").reset()
    bench.run(ms=5000)
    assert b"Lookup table is empty" in port.read()


def test_a_torque_is_the_motors_for_either_build():
    """The commutation of both is the same electrical angle: a quarter of a tooth's pitch before the rotor."""
    held_Nm = []
    for teeth, spr in ((50, 200), (100, 400)):
        bench, port, _ = _bench(
            axis={"rotor_teeth": teeth}, parameters={"spr": spr}, flash={"table": "identity"}
        )
        bench.fault("shaft_jam", "m1")
        port.write(b"ty")
        bench.run(ms=200)
        port.write(b"r100\n")
        bench.run(ms=100)
        held_Nm.append(abs(bench.axis("m1").snapshot().torque_Nm))
    assert all(0 < each < 0.23 for each in held_Nm)
