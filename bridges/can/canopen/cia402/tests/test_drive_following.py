"""Following errors, targets that are reached, and axes that somebody else moves or stops."""

from drive_rig import DriveRig

from hil.vocab.path import PathPiece

REACHED = 0x400


def test_a_following_error_counts_after_its_time() -> None:
    rig = DriveRig()
    rig.enable()
    rig.axis.off_by_deg = -30.1
    rig.run(40)
    assert rig.emergencies == []
    assert rig.read(0x60F4) == 30_100
    rig.axis.off_by_deg = 0.0
    rig.run(20)
    rig.axis.off_by_deg = 30.1
    rig.run(70)
    assert rig.emergencies == [0x8611]
    assert rig.status & 0x204F == 0x2008
    rig.axis.off_by_deg = 0.0
    rig.control(0x80)
    assert rig.status & 0x2000 == 0


def test_any_following_error_does_with_the_greatest_window() -> None:
    rig = DriveRig()
    rig.write(0x6065, 2**32 - 1)
    rig.enable()
    rig.axis.off_by_deg = 1e5
    rig.run(100)
    assert rig.emergencies == []


def test_a_target_is_reached_only_in_its_window() -> None:
    rig = DriveRig()
    rig.enable()
    rig.axis.off_by_deg = 0.6
    rig.run(100)
    assert rig.status & REACHED == 0
    rig.axis.off_by_deg = 0.4
    rig.run(30)
    assert rig.status & REACHED


def test_what_somebody_else_has_moved_goes_on_from_there() -> None:
    rig = DriveRig()
    rig.enable(1)
    rig.run(5)
    rig.axis.follow((PathPiece(0, 50.0),))  # as by a run
    rig.run(30)
    assert rig.emergencies == []
    assert rig.read(0x6062) == 50_000
    rig.receive({0x6040: 0x5F, 0x607A: 10_000})
    rig.run(600)
    assert rig.axis.paths[-1][1][0].r == 50.0
    assert rig.read(0x6064) == 10_000


def test_what_somebody_else_has_stopped_goes_on_from_there() -> None:
    rig = DriveRig()
    rig.enable(3)
    rig.write(0x60FF, 360_000)
    rig.run(1000)
    rig.axis.stop("prejudice", 1.0)
    rig.run(500)
    stopped_deg = rig.axis.look().position_deg
    assert rig.status & REACHED == 0
    rig.write(0x60FF, 180_000)
    assert rig.axis.paths[-1][1][0].r == stopped_deg
    rig.run(200)
    assert rig.read(0x606C) == 180_000
