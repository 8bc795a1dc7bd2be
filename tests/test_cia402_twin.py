"""A drive of CiA 402 over a twin: every mode moves the shaft, and a stream of targets is a run's path."""

import math
from itertools import pairwise

from twin_motor import MECHADUINO, TwinDrive, TwinMotor

from hil.sim.inputs import Follow
from hil.testing import Bench
from hil.vocab.path import PathPiece

UNITS = 1000
"""User units of a degree."""


def test_it_is_ready_when_its_board_is() -> None:
    bench = Bench({"bench": "t", "devices": {"m1": MECHADUINO}})
    drive = TwinDrive(bench)
    assert drive.read(0x6041) & 0x6F == 0x40


def test_a_set_point_is_reached() -> None:
    drive = TwinDrive()
    drive.enable(1)
    drive.write(0x607A, 90 * UNITS)
    assert drive.control(0x1F) & 0x1400 == 0x1000
    drive.run(300)
    assert not drive.read(0x6041) & 0x400
    drive.run(300)
    assert drive.read(0x6041) & 0x400
    assert abs(drive.read(0x6064) - 90 * UNITS) <= 100
    assert drive.read(0x6062) == 90 * UNITS


def test_a_speed_is_reached_and_left() -> None:
    drive = TwinDrive()
    drive.enable(3)
    drive.write(0x60FF, 360 * UNITS)
    drive.run(500)
    assert drive.read(0x6041) & 0x1400 == 0x400
    assert abs(drive.read(0x606C) - 360 * UNITS) < 60 * UNITS
    drive.write(0x60FF, 0)
    drive.run(500)
    assert drive.read(0x6041) & 0x1400 == 0x1400


def test_a_torque_turns_the_shaft() -> None:
    drive = TwinDrive()
    drive.enable(4)
    drive.write(0x6071, 100)
    drive.run(400)
    assert drive.read(0x6074) == 100
    assert abs(drive.read(0x6077) - 100) <= 2
    assert drive.read(0x606C) > 100 * UNITS
    drive.control(0x06)  # shutdown
    assert drive.read(0x6041) & 0x6F == 0x21
    assert not drive.motor.look().is_on


def test_the_index_is_home() -> None:
    drive = TwinDrive()
    drive.write(0x6098, 34)
    drive.write(0x6099, 360 * UNITS, 2)
    drive.enable(6)
    begin_deg = drive.motor.look().position_deg
    assert drive.control(0x1F) & 0x3400 == 0
    drive.run(2000)
    assert drive.read(0x6041) & 0x3400 == 0x1400
    home_deg = drive.motor.look().position_deg - drive.read(0x6064) / UNITS
    assert abs(home_deg % 360) < 0.001 or abs(home_deg % 360 - 360) < 0.001
    assert 0 < home_deg - begin_deg <= 360


def test_a_shaft_that_is_held_is_a_fault() -> None:
    drive = TwinDrive()
    drive.enable(1)
    drive.write(0x607A, 3600 * UNITS)
    drive.control(0x1F)
    with drive.bench.fault("shaft_jam", "m1"):
        drive.run(1000)
    assert drive.emergencies == [0x8611]
    assert drive.read(0x6041) & 0x4F == 0x08
    assert not drive.motor.look().is_on
    drive.control(0x80, 0x06, 0x07, 0x0F)
    assert drive.read(0x6041) & 0x6F == 0x27


def test_a_loop_that_is_switched_off_is_a_fault() -> None:
    drive = TwinDrive()
    drive.enable(1)
    drive.bench.axis("m1").do("disable")
    drive.run(20)
    assert drive.emergencies == [0xFF01]


def targets(count: int) -> list[int]:
    """Positions of a wave in user units, a millisecond apart."""
    return [round(90 * UNITS * (1 - math.cos(2 * math.pi * 0.5 * k / 1000))) for k in range(1, count + 1)]


def test_a_stream_of_targets_is_the_path_of_a_run() -> None:
    """The path is worked out here from the targets, the drive has it piece by piece."""
    begin_ms, count = 5000.0, 1500
    streamed = TwinDrive()
    streamed.enable(8)
    streamed.run_until(begin_ms)
    from_deg = streamed.motor.look().commanded_deg
    assert from_deg is not None
    seen = []
    for target in targets(count):
        streamed.write(0x607A, target)
        streamed.sync()
        streamed.run(1)
        seen.append(streamed.bench.axis("m1").snapshot())
    run = Bench({"bench": "t", "devices": {"m1": MECHADUINO}})
    run.run_until(4500)
    run.axis("m1").do("enable")
    run.run_until(begin_ms)
    path, r = [], from_deg
    for target in targets(count):
        path.append(PathPiece(1_000_000, r, (target / UNITS - r) / 1e-3))
        r = target / UNITS
    run._runtime.apply_input("m1", Follow(0, (*path, PathPiece(0, r))))
    worst_deg = 0.0
    for streamed_now in seen:
        run.run(1)
        now = run.axis("m1").snapshot()
        assert now.at_ns == streamed_now.at_ns
        worst_deg = max(worst_deg, abs(now.position_deg - streamed_now.position_deg))
    assert worst_deg <= 1e-9
    assert abs(seen[-1].position_deg - from_deg) > 10


def test_pieces_of_a_stream_join_to_the_bit() -> None:
    drive = TwinDrive()
    drive.enable(8)
    for target in targets(200):
        drive.write(0x607A, target)
        drive.sync()
        drive.run(1)
    paths = drive.motor.paths
    assert len(paths) == 200
    for (_, (piece,)), (_, (after,)) in pairwise(paths):
        assert piece.r + piece.duration_ns * 1e-9 * piece.per_s == after.r


def test_a_twin_motor_says_what_it_is_told() -> None:
    bench = Bench({"bench": "t", "devices": {"m1": MECHADUINO}})
    assert not TwinMotor(bench).look().is_ready
