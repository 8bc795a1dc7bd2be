"""Every homing method finds its edge, from wherever the axis begins."""

import pytest
from drive_rig import STEPPER, DriveRig, SimpleAxis, Switch

from bridges.can.canopen.node.application import SdoAbort
from hil.firmware.homing_methods import METHODS
from hil.vocab.path import PathPiece

DONE, ATTAINED, ERROR = 0x1400, 0x1000, 0x2000
BITS = 0x3400
LEFT_DEG, RIGHT_DEG, INDEX_DEG = 100.0, 110.0, 17.0
LIMITS: dict[str, Switch] = {"negative": lambda deg: deg < -200, "positive": lambda deg: deg > 400}
CAM: dict[str, Switch] = {**LIMITS, "home": lambda deg: LEFT_DEG <= deg <= RIGHT_DEG}
UPPER: dict[str, Switch] = {"home": lambda deg: deg >= LEFT_DEG}
LOWER: dict[str, Switch] = {"home": lambda deg: deg <= RIGHT_DEG}
SLOW_DEG_PER_LOOK = 36.0 * 250e-6
"""Way between two looks of the slow leg."""
EDGES = {
    17: (LIMITS, -200.0, 1),
    18: (LIMITS, 400.0, -1),
    19: (UPPER, LEFT_DEG, -1),
    20: (UPPER, LEFT_DEG, 1),
    21: (LOWER, RIGHT_DEG, 1),
    22: (LOWER, RIGHT_DEG, -1),
    23: (CAM, LEFT_DEG, -1),
    24: (CAM, LEFT_DEG, 1),
    25: (CAM, RIGHT_DEG, -1),
    26: (CAM, RIGHT_DEG, 1),
    27: (CAM, RIGHT_DEG, 1),
    28: (CAM, RIGHT_DEG, -1),
    29: (CAM, LEFT_DEG, 1),
    30: (CAM, LEFT_DEG, -1),
}
"""Switches, edge and the direction in which it is crossed at last, by the figures of the standard."""
STARTS_DEG = (-150.0, 50.0, 105.0, 200.0)


def rig(switches: dict[str, Switch], start_deg: float = 0.0, method: int = 37, **axis: object) -> DriveRig:
    made = SimpleAxis(switches=switches, index_deg=INDEX_DEG, **axis)  # type: ignore[arg-type]
    made.path = (PathPiece(0, start_deg),)
    drive = DriveRig(made)
    drive.write(0x6098, method)
    drive.enable(6)
    return drive


def homed(drive: DriveRig, limit_ms: float = 20_000) -> float:
    """Begin homing; answers the angle of the zero position in degrees."""
    assert drive.control(0x1F) & 0x1000 == 0 or drive.read(0x6098) in (35, 37)
    while drive.status & BITS not in (DONE, 0x2400):
        assert drive.now_ns < limit_ms * 1e6, hex(drive.status)
        drive.run(10)
    assert drive.status & BITS == DONE
    return drive.axis.look().position_deg - drive.read(0x6064) / 1000


@pytest.mark.parametrize("start_deg", STARTS_DEG)
@pytest.mark.parametrize("method", sorted(EDGES))
def test_an_edge_is_found(method: int, start_deg: float) -> None:
    switches, edge_deg, _ = EDGES[method]
    assert abs(homed(rig(switches, start_deg, method)) - edge_deg) <= SLOW_DEG_PER_LOOK + 0.001


@pytest.mark.parametrize("start_deg", STARTS_DEG[1:3])
@pytest.mark.parametrize("method", sorted(EDGES))
def test_the_index_behind_an_edge_is_found(method: int, start_deg: float) -> None:
    switches, edge_deg, direction = EDGES[method]
    turns = (edge_deg - INDEX_DEG) / 360
    index_deg = INDEX_DEG + 360 * (turns // 1 + (1 if direction > 0 else 0))
    assert abs(homed(rig(switches, start_deg, method - 16)) - index_deg) <= 0.001


@pytest.mark.parametrize(("method", "index_deg"), [(33, INDEX_DEG), (34, INDEX_DEG + 360)])
def test_the_next_index_is_found(method: int, index_deg: float) -> None:
    assert abs(homed(rig({}, 200.0, method)) - index_deg) <= 0.001


@pytest.mark.parametrize("method", [35, 37])
def test_home_may_be_here(method: int) -> None:
    drive = rig({}, 123.0, method)
    assert homed(drive) == 123.0
    assert drive.axis.paths[-1][1] == (PathPiece(0, 123.0),)  # it has not moved


def test_zero_is_as_far_from_home_as_the_offset_says() -> None:
    drive = rig({}, 123.0)
    drive.write(0x607C, 5000)
    homed(drive)
    assert drive.read(0x6064) == -5000


def test_limits_count_from_home_whatever_the_offset() -> None:
    drive = rig({}, 123.0)
    drive.write(0x607C, 5000)
    drive.write(0x607D, 20_000, 2)
    homed(drive)
    drive.write(0x6060, 1)
    drive.write(0x607A, 90_000)
    drive.control(0x0F, 0x1F)
    drive.run(1000)
    assert drive.axis.look().position_deg == 143.0
    assert drive.status & 0x800


def test_a_narrow_cam_that_is_run_over_is_found_again() -> None:
    drive = rig({**LIMITS, "home": lambda deg: 100 <= deg <= 100.5}, 0.0, 24)
    assert abs(homed(drive) - 100.0) <= SLOW_DEG_PER_LOOK + 0.001


def test_a_limit_switch_in_the_way_is_an_error() -> None:
    drive = rig({**LIMITS, "home": lambda deg: deg >= 1000}, 0.0, 20)
    drive.control(0x1F)
    drive.run(5000)
    assert drive.status & BITS == 0x2400
    assert 400 < drive.axis.look().position_deg < 430
    drive.control(0x0F)
    drive.write(0x6098, 37)
    homed(drive)  # another one begins again


def test_without_a_method_it_is_an_error() -> None:
    drive = rig({}, 0.0, 0)
    drive.control(0x1F)
    drive.run(20)
    assert drive.status & BITS == 0x2400


def test_homing_is_interrupted_without_its_bit() -> None:
    drive = rig(CAM, 0.0, 24)
    drive.control(0x1F)
    drive.run(100)
    assert drive.status & BITS == 0
    drive.control(0x0F)
    drive.run(500)
    assert drive.status & BITS == 0x400
    assert not drive.axis.look().is_moving
    homed(drive)


def test_a_halt_holds_the_search_up() -> None:
    drive = rig(CAM, -150.0, 24)
    drive.control(0x1F)
    drive.run(100)
    drive.control(0x11F)
    drive.run(500)
    assert not drive.axis.look().is_moving
    assert drive.status & BITS == 0x400
    drive.control(0x1F)
    drive.run(100)
    assert drive.axis.look().is_moving
    assert abs(homed_already(drive) - LEFT_DEG) <= SLOW_DEG_PER_LOOK + 0.001


def homed_already(drive: DriveRig) -> float:
    drive.run(8000)
    assert drive.status & BITS == DONE
    return drive.axis.look().position_deg - drive.read(0x6064) / 1000


def test_home_stays_known_in_other_modes() -> None:
    drive = rig({}, 50.0)
    homed(drive)
    drive.control(0x0F)
    drive.write(0x6060, 1)
    drive.write(0x6060, 6)
    drive.run(20)
    assert drive.status & BITS == DONE


@pytest.mark.parametrize(
    ("switches", "index_deg", "methods"),
    [
        ({}, None, {35, 37}),
        ({}, 0.0, {33, 34, 35, 37}),
        ({"positive": LIMITS["positive"]}, None, {18, 35, 37}),
        (CAM, None, {*range(17, 31), 35, 37}),
        (CAM, 0.0, set(METHODS)),
    ],
)
def test_only_methods_that_can_be_done_are_taken(
    switches: dict[str, Switch], index_deg: float | None, methods: set[int]
) -> None:
    drive = DriveRig(SimpleAxis(switches=switches, index_deg=index_deg))
    told = {drive.read(0x60E3, place) for place in range(1, drive.read(0x60E3) + 1)}
    assert told == methods
    for method in set(range(1, 38)) - methods:
        with pytest.raises(SdoAbort) as refused:
            drive.write(0x6098, method)
        assert refused.value.code == 0x0609_0030
    for method in methods:
        drive.write(0x6098, method)


def test_a_board_with_its_own_ramps_finds_a_switch() -> None:
    drive = rig(CAM, 0.0, 24, verbs=STEPPER, follows_paths=False)
    assert abs(homed(drive) - LEFT_DEG) <= SLOW_DEG_PER_LOOK + 0.001
