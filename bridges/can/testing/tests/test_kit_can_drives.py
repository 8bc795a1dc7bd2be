"""CANopen drives in a bench: CiA 402 over the boards' own axes, switches, memory."""

import struct

import pytest
from can_bench import M1, config

from bridges.can.testing.can_faces import CanBusFace, DriveFace, SdoAborted
from hil.testing import Bench

MODE, TARGET, SPEED, POSITION = 0x6060, 0x607A, 0x6081, 0x6064
ACCELERATIONS = (0x6083, 0x6084)
REACHED, HOMED, FAULT = 1 << 10, 1 << 12, 1 << 3
SAVE = int.from_bytes(b"save", "little")


def prepared(drive: DriveFace, mode: int, speed: int = 360_000) -> DriveFace:
    """A drive that is enabled in a mode; 0.001 deg is its unit."""
    drive.write(MODE, 0, mode, 1)
    drive.write(SPEED, 0, speed, 4)
    for index in ACCELERATIONS:
        drive.write(index, 0, 10 * speed, 4)
    assert drive.enable() & 0x6F == 0x27
    return drive


@pytest.mark.parametrize(("profile", "off_deg"), [("mechaduino", 0.5), ("sac", 0.01), ("modbus_drive", 0.5)])
def test_a_profile_position_move_moves_the_axis_of_each_board(drive, profile: str, off_deg: float) -> None:
    it = prepared(drive(profile=profile), 1)
    it.write(TARGET, 0, 90_000, 4)
    assert it.controlword(0x1F) & REACHED == 0
    it.canbus.bench.run(ms=1500)
    assert it.statusword & REACHED
    assert it.canbus.bench.axis(it.axis).snapshot().position_deg == pytest.approx(90, abs=off_deg)
    assert it.read(POSITION, is_signed=True) == pytest.approx(90_000, abs=1000 * off_deg)


def test_a_drive_is_not_ready_before_its_board(canbus) -> None:
    (it,) = canbus(1).drives()
    it.boot()
    assert it.statusword & 0x4F == 0
    it.await_ready()
    assert it.canbus.bench.now_ns > 3_900_000_000


def test_homing_finds_the_cam(drive) -> None:
    """Method 24: to the home switch from below, and back to its lower edge."""
    it = prepared(drive(switches={"home": {"from_deg": 40, "to_deg": 60}}), 6)
    it.write(0x6098, 0, 24, 1)
    it.write(0x6099, 1, 90_000, 4)
    it.write(0x6099, 2, 9_000, 4)
    it.write(0x609A, 0, 900_000, 4)
    it.controlword(0x1F)
    it.canbus.bench.run(ms=4000)
    assert it.statusword & (REACHED | HOMED) == REACHED | HOMED, hex(it.statusword)
    shaft_deg = it.canbus.bench.axis(it.axis).snapshot().position_deg
    assert shaft_deg - it.read(POSITION, is_signed=True) / 1000 == pytest.approx(40, abs=0.5)


def test_homing_finds_a_switch_of_the_bench() -> None:
    """As the cam, with hysteresis and bounces: it comes from below, so that the lower edge is home, and bit 2
    of 60FDh is the switch."""
    home = {"axis": "m1", "from_deg": 40, "to_deg": 60, "hysteresis_deg": 0.3, "bounce_ms": 1}
    made = config({"m1": {"id": 5, "switches": {"home": {"switch": "home"}}}})
    bench = Bench({**made, "switches": {"home": home}})
    (it,) = bench.canbus("can0").drives()
    it.await_ready()
    it = prepared(it, 6)
    it.write(0x6098, 0, 24, 1)
    it.write(0x6099, 1, 90_000, 4)
    it.write(0x6099, 2, 9_000, 4)
    it.write(0x609A, 0, 900_000, 4)
    assert it.read(0x60FD) & 4 == 0
    it.controlword(0x1F)
    bench.run(ms=5000)
    assert it.statusword & (REACHED | HOMED) == REACHED | HOMED, hex(it.statusword)
    shaft_deg = bench.axis("m1").snapshot().position_deg
    assert shaft_deg - it.read(POSITION, is_signed=True) / 1000 == pytest.approx(40 - 0.3, abs=0.5)


def test_a_switch_at_a_pin_is_seen_and_stops_the_drive(drive) -> None:
    it = prepared(drive(switches={"positive": {"pin": "D3", "active": "low"}}), 1, 90_000)
    bench = it.canbus.bench
    assert it.read(0x60FD) & 2, "the pin is low: the switch is active"
    bench.device(it.axis).pin("D3").set(1)
    assert it.read(0x60FD) & 2 == 0
    it.write(TARGET, 0, 360_000, 4)
    it.controlword(0x1F)
    bench.run(ms=500)
    bench.device(it.axis).pin("D3").set(0)
    bench.run(ms=1000)
    assert bench.axis(it.axis).snapshot().position_deg < 120


def cyclic(bus: CanBusFace) -> list[DriveFace]:
    """Drives in mode 8, each with RPDO1 (controlword, target) and TPDO1 (statusword, position) at SYNC."""
    drives = bus.drives()
    for it in drives:
        it.await_ready()
        for pdo, cob_id, objects in (
            (0x1400, 0x200 + it.node_id, (0x6040_0010, 0x607A_0020)),
            (0x1800, 0x180 + it.node_id, (0x6041_0010, 0x6064_0020)),
        ):
            it.write(pdo, 1, 1 << 31 | cob_id, 4)
            it.write(pdo, 2, 1, 1)
            it.write(pdo + 0x200, 0, 0, 1)
            for number, mapped in enumerate(objects, 1):
                it.write(pdo + 0x200, number, mapped, 4)
            it.write(pdo + 0x200, 0, 2, 1)
            it.write(pdo, 1, cob_id, 4)
        it.write(0x60C2, 1, 4, 1)
        it.write(0x60C2, 2, 0xFD, 1)
        it.write(MODE, 0, 8, 1)
        it.nmt("operational")
        it.enable()
    return drives


def test_two_drives_follow_set_points_at_sync_together(canbus) -> None:
    bus = canbus(2)
    bench, drives = bus.bench, cyclic(bus)
    start = [it.read(POSITION, is_signed=True) for it in drives]
    bus.read()
    for cycle in range(200):
        for it, at in zip(drives, start, strict=True):
            bus.send(0x200 + it.node_id, struct.pack("<Hi", 0x0F, at + 100 * cycle))
        bus.send(0x80)
        bench.run(ms=4)
    answers = [each for each in bus.read() if each.frame.id & 0x780 == 0x180]
    assert len(answers) == 400
    last = [struct.unpack("<Hi", each.frame.data) for each in answers[-2:]]
    assert [status & 0x6F for status, _ in last] == [0x27, 0x27]
    assert [position - at for (_, position), at in zip(last, start, strict=True)] == pytest.approx(
        [19_800] * 2, abs=600
    )
    assert (last[0][1] - start[0]) - (last[1][1] - start[1]) == pytest.approx(0, abs=500)


def test_what_is_saved_is_there_after_a_reset_of_the_board(drive) -> None:
    it = drive()
    it.write(0x6065, 0, 12_345, 4)
    it.write(0x6067, 0, 77, 4)
    it.write(0x1010, 1, SAVE, 4)
    it.write(0x6067, 0, 78, 4)
    it.canbus.bench.device(it.axis).reset()
    it.boot()
    assert (it.read(0x6065), it.read(0x6067)) == (12_345, 77)
    assert set(it.canbus.bench._runtime.devices[it.axis].nvm) == {"lookup", "canopen"}


def test_bus_off_while_it_moves_and_its_recovery(drive, fault) -> None:
    """The drive stops with a fault; it is back on the bus by itself, and a reset of the fault is enough."""
    it = prepared(drive(), 1, 90_000)
    it.write(0x6007, 0, 1, 2)  # a lost connection is a fault
    it.write(TARGET, 0, 360_000, 4)
    it.nmt("operational")
    it.controlword(0x1F)
    bench = it.canbus.bench
    bench.run(ms=300)
    fault(bench, "bus_off", f"{it.axis}.canopen")
    assert it.canbus.state(f"{it.axis}.canopen") == "bus-off"
    bench.run(ms=1000)
    assert it.canbus.state(f"{it.axis}.canopen") == "error-active"
    assert it.statusword & FAULT
    assert bench.axis(it.axis).snapshot().position_deg < 120
    it.controlword(0x80)
    assert it.enable() & 0x6F == 0x27


def test_an_abort_says_why(drive) -> None:
    it = drive()
    for index, value, size, code in (
        (0x6041, 0, 2, 0x06010002),
        (0x5FFF, 0, 2, 0x06020000),
        (0x6060, 99, 1, 0x06090030),
    ):
        with pytest.raises(SdoAborted) as caught:
            it.write(index, 0, value, size)
        assert caught.value.code == code


def test_a_reset_in_motion_and_a_hung_board_do_no_harm_to_others() -> None:
    with Bench(config({"m1": 1, "m2": 2})) as bench:
        first, second = bench.canbus().drives()
        for it in (first, second):
            it.await_ready()
            prepared(it, 1).write(TARGET, 0, 3_600_000, 4)
            it.controlword(0x1F)
        bench.run(ms=200)
        with bench.fault("node_hang", "m1"):
            bench.run(ms=200)
            assert first.statusword
        bench.device("m2").reset()
        bench.run(ms=5000)
        assert (second.statusword & 0x4F, bench.device("m2").failed) == (0x40, None)


def test_a_board_that_stops_is_a_fault_of_its_drive(drive) -> None:
    it = prepared(drive(), 1)
    it.canbus.bench._runtime.devices[it.axis].power.fail("it is a test")
    it.canbus.bench.run(ms=100)
    assert it.statusword & FAULT


def test_profiles_are_told_apart_by_their_identity() -> None:
    boards = {"m1": M1, "s1": {"profile": "sac"}}
    setup = config() | {"devices": boards}
    setup["can"]["can0"]["nodes"] = {"m1": 1, "s1": 2}
    with Bench(setup) as bench:
        bench.run(ms=5)
        names = [it.sdo.upload(0x1008) for it in bench.canbus().drives()]
        assert names == [b"simulated mechaduino", b"simulated sac"]
        identities = {tuple(it.read(0x1018, at) for at in range(1, 5)) for it in bench.canbus().drives()}
        assert len(identities) == 2
