"""Each mode's dialogue as data: what a master writes, and what it reads at which time."""

import pytest
from drive_rig import STEPPER, DriveRig, SimpleAxis, Switch
from drive_steps import Emcy, Read, Status, Step, Sync, Wait, Write, play, to, word

from hil.vocab.path import PathPiece

REACHED, ACK, B13, LIMIT, FOLLOWS = 0x400, 0x1000, 0x2000, 0x800, 0x1000
FAULT = Status(0x4F, 0x08)
# 360,000 units: a turn. At 360,000 units/s and 3,600,000 units/s2 a ramp takes 0.1 s and 18 degrees.


DIALOGUES: dict[str, list[Step]] = {
    "pp: one set-point": [
        Status(REACHED | ACK, REACHED),
        *to(90_000, 0x1F),
        Status(REACHED | ACK, ACK),
        word(0x0F),
        Status(REACHED | ACK, 0),
        Wait(175),
        Read(0x6064, 45_000),
        Read(0x606B, 360_000),
        Wait(174),
        Status(REACHED, 0),
        Wait(20),
        Status(REACHED | ACK, REACHED),
        Read(0x6064, 90_000),
    ],
    "pp: a bit that stays does not count again": [
        *to(90_000, 0x1F),
        *to(180_000, 0x1F),
        Wait(600),
        Read(0x6064, 90_000),
    ],
    "pp: set of set-points, one waits": [
        *to(90_000, 0x1F, 0x0F),
        *to(0, 0x1F),
        Status(ACK, ACK),
        word(0x0F),
        Status(ACK, ACK),  # there is no place for a third
        *to(300_000, 0x1F, 0x0F),
        Wait(360),
        Status(ACK | REACHED, 0),  # the second is under way
        Wait(360),
        Read(0x6064, 0),
        Status(ACK | REACHED, REACHED),
    ],
    "pp: changed immediately": [
        *to(90_000, 0x1F, 0x0F),
        Wait(175),
        *to(0, 0x3F, 0x0F),
        Wait(100),
        Read(0x606B, 0),  # it has turned round
        Read(0x6064, 63_000),
        Wait(400),
        Read(0x6064, 0),
        Status(REACHED, REACHED),
    ],
    "pp: what is changed immediately takes the waiting one's place": [
        *to(90_000, 0x1F, 0x0F),
        *to(180_000, 0x1F, 0x0F),
        *to(45_000, 0x3F, 0x0F),
        Wait(1000),
        Read(0x6064, 45_000),
    ],
    "pp: relative to the target before": [
        *to(90_000, 0x1F, 0x0F),
        *to(-30_000, 0x5F, 0x0F),
        Wait(800),
        Read(0x6064, 60_000),
        *to(-30_000, 0x5F, 0x0F),
        Wait(800),
        Read(0x6064, 30_000),
    ],
    "pp: changed on the set-point, without a stop": [
        *to(90_000, 0x1F, 0x0F),
        *to(180_000, 0x21F, 0x20F),
        Wait(300),
        Read(0x606B, 360_000),
        Read(0x6064, 90_000),
        Wait(150),
        Read(0x606B, 360_000),
        Wait(200),
        Read(0x6064, 180_000),
        Status(REACHED, REACHED),
    ],
    "pp: halt, and on": [
        *to(90_000, 0x1F, 0x0F),
        Wait(175),
        word(0x10F),
        Status(REACHED, 0),
        Wait(110),
        Status(REACHED, REACHED),
        Read(0x6064, 63_000),
        Read(0x606C, 0),
        word(0x0F),
        Status(REACHED, 0),
        Wait(500),
        Read(0x6064, 90_000),
        Status(REACHED, REACHED),
    ],
    "pp: software limits": [
        Write(0x607D, 50_000, 2),
        *to(90_000, 0x1F, 0x0F),
        Status(LIMIT, LIMIT),
        Wait(600),
        Read(0x6064, 50_000),
        *to(10_000, 0x1F, 0x0F),
        Status(LIMIT, 0),
        Wait(600),
        Read(0x6064, 10_000),
    ],
    "pp: limited jerk takes longer": [
        Write(0x6086, 3),
        *to(90_000, 0x1F, 0x0F),
        Wait(349),
        Status(REACHED, 0),
        Wait(40),
        Read(0x6064, 90_000),
    ],
    "pp: polarity": [
        word(0x00),
        Write(0x607E, 0x80),
        word(0x06),
        word(0x0F),
        *to(90_000, 0x1F, 0x0F),
        Wait(500),
        Read(0x6064, 90_000),
        Read(0x6063, -4096),
    ],
    "pp: gear and feed": [
        word(0x00),
        Write(0x6091, 10, 1),  # ten turns of the motor for one of the shaft
        Write(0x6092, 360, 1),  # degrees of the shaft
        Write(0x6081, 10),
        Write(0x6083, 1000),
        Write(0x6084, 1000),
        word(0x06),
        word(0x0F),
        *to(9, 0x1F, 0x0F),
        Wait(1000),
        Read(0x6064, 9),
        Read(0x6063, 4096),
    ],
    "pp: an error of the following": [
        *to(360_000, 0x1F, 0x0F),
        Wait(100),
        Emcy(()),
    ],
    "pv: ramps up, and to another direction": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Status(REACHED | ACK, ACK),
        Wait(50),
        Read(0x606B, 180_000),
        Wait(70),
        Read(0x606C, 360_000),
        Status(REACHED | ACK, REACHED),
        Write(0x60FF, -360_000),
        Wait(100),
        Read(0x606B, 0),
        Wait(120),
        Read(0x606C, -360_000),
        Status(REACHED | ACK, REACHED),
        Write(0x60FF, 0),
        Wait(150),
        Status(REACHED | ACK, REACHED | ACK),
    ],
    "pv: halt": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(200),
        word(0x10F),
        Wait(120),
        Status(REACHED | ACK, REACHED | ACK),
        word(0x0F),
        Wait(150),
        Read(0x606C, 360_000),
    ],
    "pv: no faster than 607Fh and 6080h": [
        Write(0x6060, 3),
        Write(0x607F, 90_000),
        Write(0x60FF, 360_000),
        Wait(200),
        Read(0x606C, 90_000),
        Status(REACHED, REACHED),
    ],
    "pv: a software limit ends it": [
        Write(0x607D, 90_000, 2),
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(600),
        Read(0x6064, 90_000),
        Status(LIMIT | REACHED, LIMIT),
        Write(0x60FF, -360_000),
        Wait(200),
        Read(0x606C, -360_000),
        Status(LIMIT, 0),
    ],
    "tq: slope, and maximum": [
        Write(0x6060, 4),
        Write(0x6071, 500),
        Status(REACHED, 0),
        Wait(250),
        Read(0x6074, 250),
        Wait(251),
        Read(0x6074, 500),
        Read(0x6077, 500),
        Status(REACHED | LIMIT, REACHED),
        Write(0x6072, 200),
        Wait(301),
        Read(0x6074, 200),
        Status(REACHED | LIMIT, REACHED | LIMIT),
        word(0x10F),
        Wait(201),
        Read(0x6074, 0),
        Status(REACHED, REACHED),
    ],
    "csp: a target with each SYNC": [
        Write(0x6060, 8),
        Status(FOLLOWS, 0),
        *[each for k in range(1, 11) for each in (Write(0x607A, 100 * k), Sync())],
        Status(FOLLOWS | LIMIT, FOLLOWS),
        Read(0x6064, 1000),
        Read(0x6062, 1000),
        Read(0x60F4, 0),
        Wait(49),
        Emcy((0x8700,)),
        FAULT,
    ],
    "csp: between two targets": [
        Write(0x60C2, 10, 1),
        Write(0x6060, 8),
        Write(0x607A, 1000),
        Sync(2.5),
        Read(0x6062, 250),
        Read(0x606B, 100_000),
    ],
    "csp: an early SYNC begins where the set-point is": [
        Write(0x60C2, 10, 1),
        Write(0x6060, 8),
        Write(0x607A, 1000),
        Sync(5),
        Read(0x6062, 500),
        Write(0x607A, 2000),
        Sync(5),
        Read(0x6062, 1250),
        Sync(10),
        Read(0x6062, 2000),
    ],
    "csp: no faster than the motor may": [
        Write(0x6080, 60),
        Write(0x6060, 8),
        Write(0x607A, 10_000),
        Sync(),
        Read(0x6062, 360),
        Status(LIMIT, LIMIT),
    ],
    "csp: software limits": [
        Write(0x607D, 50, 2),
        Write(0x6060, 8),
        Write(0x607A, 100),
        Sync(),
        Read(0x6062, 50),
        Status(LIMIT, LIMIT),
    ],
    "csp: without fault for those who want none": [
        Write(0x6007, 0),
        Write(0x6060, 8),
        Sync(1000),
        Emcy(()),
        Status(0x6F, 0x27),
    ],
    "csp: out of a motion": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(200),
        Write(0x6060, 8),
        Read(0x606B, 360_000),
        Wait(50),
        Read(0x606B, 180_000),
        Wait(60),
        Read(0x606B, 0),
        Write(0x607A, 73_000),
        Sync(),
        Read(0x6062, 73_000),
    ],
    "csp: an early SYNC while it comes to rest": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(200),
        Write(0x6060, 8),
        Wait(50),
        Read(0x6062, 67_500),
        Write(0x607A, 67_600),
        Sync(),
        Read(0x6062, 67_600),
        Read(0x606B, 0),
    ],
    "csv: a speed with each SYNC": [
        Write(0x6060, 9),
        Write(0x60FF, 360_000),
        Sync(),
        Read(0x6062, 180),
        Read(0x606B, 360_000),
        Sync(),
        Read(0x6062, 540),
        Write(0x60FF, 0),
        Sync(),
        Read(0x6062, 720),
        Read(0x606B, 0),
    ],
    "csv: it does not turn forever without SYNC": [
        Write(0x6060, 9),
        Write(0x60FF, 360_000),
        Sync(51),
        Emcy((0x8700,)),
        Wait(15),
        FAULT,
        Read(0x606C, 0),
    ],
    "a mode is changed on the way": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(200),
        Write(0x6060, 1),
        Read(0x6061, 1),
        Wait(110),
        Read(0x606C, 0),
        *to(0, 0x1F, 0x0F),
        Wait(1000),
        Read(0x6064, 0),
        Write(0x6060, 4),
        Wait(5),
        Write(0x6060, 8),
        Write(0x607A, 100),
        Sync(),
        Read(0x6064, 100),
    ],
}


@pytest.mark.parametrize("name", DIALOGUES)
def test_a_dialogue_goes_as_written(name: str) -> None:
    rig = DriveRig()
    rig.enable()
    play(rig, DIALOGUES[name])


OF_A_STEPPER: dict[str, list[Step]] = {
    "pp: there, and back when it stands": [
        *to(90_000, 0x1F, 0x0F),
        Wait(100),
        *to(0, 0x1F),
        Status(ACK, ACK),
        word(0x0F),
        Status(ACK, ACK),
        Wait(1000),
        Read(0x6064, 0),
        Status(ACK | REACHED, REACHED),
    ],
    "pp: at once, by a stop": [
        *to(90_000, 0x1F, 0x0F),
        Wait(100),
        *to(-90_000, 0x3F, 0x0F),
        Wait(1000),
        Read(0x6064, -90_000),
        Status(REACHED, REACHED),
    ],
    "pv: turns": [
        Write(0x6060, 3),
        Write(0x60FF, 360_000),
        Wait(100),
        Read(0x606C, 360_000),
        Status(REACHED, REACHED),
        word(0x07),
        Wait(5),
        Status(0x6F, 0x23),
        Read(0x606C, 0),
    ],
}


@pytest.mark.parametrize("name", OF_A_STEPPER)
def test_a_board_with_its_own_ramps_does_what_it_can(name: str) -> None:
    rig = DriveRig(SimpleAxis(verbs=STEPPER, follows_paths=False, index_deg=None))
    rig.enable()
    play(rig, OF_A_STEPPER[name])


UP: dict[str, Switch] = {"positive": lambda deg: deg >= 45, "negative": lambda deg: deg <= -45}
AT_SWITCHES: dict[str, list[Step]] = {
    "pp: stops, and goes back only": [
        *to(90_000, 0x1F, 0x0F),
        Wait(500),
        Read(0x6064, 47_000, 1000),
        Status(LIMIT | REACHED, LIMIT),
        Read(0x60FD, 2),
        *to(90_000, 0x1F, 0x0F),
        Wait(100),
        Read(0x6064, 47_000, 1000),
        *to(0, 0x1F, 0x0F),
        Wait(500),
        Read(0x6064, 0),
        Read(0x60FD, 0),
        Status(LIMIT | REACHED, REACHED),
    ],
    "pv: stops": [
        Write(0x6060, 3),
        Write(0x60FF, -360_000),
        Wait(500),
        Read(0x606C, 0),
        Read(0x60FD, 1),
        Status(LIMIT, LIMIT),
        Write(0x60FF, -100_000),
        Wait(50),
        Read(0x606C, 0),
        Write(0x60FF, 360_000),
        Wait(150),
        Read(0x606C, 360_000),
    ],
    "tq: makes no torque towards it": [
        Write(0x6060, 4),
        Write(0x607A, 0),
        Write(0x6071, 200),
        Wait(300),
        Read(0x6074, 200),
    ],
    "csp: stays where it is": [
        Write(0x6060, 8),
        *[each for k in range(60) for each in (Write(0x607A, 1000 * k), Sync())],
        Read(0x6064, 46_000, 1000),
        Status(LIMIT | FOLLOWS, LIMIT | FOLLOWS),
        Write(0x607A, 45_500),
        Sync(),
        Write(0x607A, 44_000),
        Sync(),
        Read(0x6064, 44_000),
        Sync(),
        Status(LIMIT, 0),
    ],
}


@pytest.mark.parametrize("name", AT_SWITCHES)
def test_a_limit_switch_ends_what_leads_to_it(name: str) -> None:
    rig = DriveRig(SimpleAxis(switches=UP))
    rig.enable()
    play(rig, AT_SWITCHES[name])


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
