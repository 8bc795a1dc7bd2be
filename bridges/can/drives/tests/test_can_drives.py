"""Real CANopen drives, here those of the library ``canopen``, on a bus within this process."""

import asyncio
import random
import time
from collections.abc import Awaitable, Callable
from itertools import pairwise
from typing import Any

import can
import pytest
from can_world import CanWorld
from drive_world import in_drive_world
from scripted_can_drive import UNITS_PER_TURN, ScriptedDrive, virtual_bus

from bridges.can.drives.can_drive import CanDrive
from bridges.can.drives.can_drive_address import CanPlace
from hil.drives.drive_control import DriveControl
from hil.vocab.path import PathPiece
from hil.vocab.verbs import VerbRefused

pytestmark = pytest.mark.long


def with_drive(
    doing: Callable[[CanWorld, ScriptedDrive, DriveControl], Awaitable[None]],
    master: int | None = None,
    **options: Any,
) -> None:
    """Run a test with one drive, and hil as its master."""
    bus = virtual_bus()
    drive = ScriptedDrive(5, bus, **options)

    async def run(world: CanWorld) -> None:
        control = world.add_can("x", CanPlace("virtual", bus["channel"]), 5, master)
        await doing(world, drive, control)

    try:
        in_drive_world(CanWorld, run)
    finally:
        drive.power_off()


def test_a_drive_is_greeted_told_enabled_and_moved() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        drive = control.drive
        assert drive.identity == {
            "vendor": "00001234h", "product": "00000007h", "revision": "00000002h", "serial": "00000063h",
        }  # fmt: skip
        assert drive.follows_paths
        with pytest.raises(VerbRefused, match="its loop is off; enable it first"):
            await control.do("move_abs", {"position_deg": 90.0})
        await control.do("enable", {})
        assert await control.do("move_abs", {"position_deg": 90.0, "velocity_rpm": 120.0}) == {
            "set_point": 90.0
        }
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert control.motion.failure is None
        values = drive.values()
        assert values["position_deg"] == pytest.approx(90, abs=0.5)
        assert (values["enabled"], values["mode"], values["current_A"]) == (1, 1, 0.5)
        assert values["age_ms"] < 500
        assert (0x6081, 120 * UNITS_PER_TURN // 60) in far.writes
        await control.do("move_rel", {"angle_deg": -30.0})
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert far.position == pytest.approx(UNITS_PER_TURN / 6, abs=50)
        await control.do("disable", {})
        assert drive.values()["enabled"] == 0

    with_drive(run)


def test_a_path_is_streamed_with_sync() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        axis = control.axis
        axis.hold()
        path = (PathPiece(500_000_000, 0.0, 180.0), PathPiece(0, 90.0))
        axis.follow(path, world.now_ns + axis.lead_ns)
        await world.until(lambda: not axis.state().is_under_way, "the end")
        assert axis.failure is None
        samples = axis.samples()
        axis.release()
        off_deg = sorted(abs(commanded - position) for _, commanded, position in samples)
        assert off_deg[len(off_deg) // 2] < 8  # the far drive's thread may be late now and then
        assert far.position == pytest.approx(UNITS_PER_TURN / 4, abs=2)
        taken = [units for _, units in far.syncs]
        assert len(taken) > 40
        assert taken == sorted(taken)
        await world.until(lambda: control.drive.values()["mode"] == 1, "its own hold")

    with_drive(run)


def test_stop_is_the_quick_stop_and_the_loop_stays_on() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        await control.do("move_abs", {"position_deg": 7200.0, "velocity_rpm": 60.0})
        await world.until(lambda: far.position > 500, "some way")
        await control.do("stop", {})
        assert not control.motion.is_under_way
        assert (0x605A, 6) in far.writes
        here = far.position
        await asyncio.sleep(0.1)
        assert far.position == here
        assert far.state == 0x27
        assert far.writes[-1] == (0x6040, 0x0F)

    with_drive(run)


def test_a_drive_whose_quick_stop_is_fixed_is_halted_and_does_not_go_on() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        await control.do("move_abs", {"position_deg": 7200.0, "velocity_rpm": 60.0})
        await world.until(lambda: far.position > 500, "some way")
        await control.do("stop", {})
        here = far.position
        await asyncio.sleep(0.2)
        assert far.position == pytest.approx(here, abs=5)
        assert (far.state, far.writes[-1]) == (0x27, (0x6040, 0x0F))
        await control.do("move_rel", {"angle_deg": 5.0})
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert control.motion.failure is None

    with_drive(run, read_only=(0x605A,))


def test_a_fault_is_told_in_words_and_cleared() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        far.fail(0x8611)
        await world.until(lambda: control.drive.fault, "the fault")
        assert control.drive.fault == "the drive has fault 8611h (following error)"
        assert control.drive.notes == ("emergency 8611h (following error), maker's bytes 01 02 00 00 00",)
        with pytest.raises(VerbRefused, match="clear it first"):
            await control.do("enable", {})
        await control.do("clear_fault", {})
        await world.until(lambda: control.drive.notes == (), "the end of its emergency")
        await control.do("enable", {})
        assert control.drive.values()["emergencies"] == 2

    with_drive(run)


def test_a_drive_that_is_switched_off_is_lost_and_comes_back() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        control.axis.hold()
        path = (PathPiece(20_000_000_000, 0.0, 90.0), PathPiece(0, 1800.0))
        control.axis.follow(path, world.now_ns + control.axis.lead_ns)
        await world.until(lambda: far.position > 500, "some way")
        await asyncio.to_thread(far.power_off)
        begun_s = time.monotonic()
        await world.until(lambda: not control.drive.link.is_there, "the loss")
        assert time.monotonic() - begun_s < 1.0
        assert "heartbeat" in control.drive.link.why
        assert "is lost: no heartbeat" in (control.axis.failure or "")
        await asyncio.to_thread(far.power_on)
        far.writes.clear()
        await world.there(control)
        assert control.drive.link.counters.reconnects == 1
        assert " lost" in (control.axis.failure or "")
        await asyncio.sleep(0.2)
        assert not [index for index, _ in far.writes if index in (0x6040, 0x6060, 0x607A)]
        await asyncio.to_thread(far.power_off)  # and at once on again: only its boot-up tells
        await asyncio.to_thread(far.power_on)
        await world.until(lambda: control.drive.link.counters.connects == 3, "the third session")

    with_drive(run)


def test_reset_is_that_of_the_node() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        await control.do("reset", {})
        assert control.drive.link.session == 2

    with_drive(run)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"x1000": 0x191}, "it is no drive of CiA 402: its device type is 00000191h"),
        ({"without": (0x608F,)}, "it does not say how many units a turn has"),
        ({"x6502": 0x04}, "it has neither profile position nor cyclic synchronous position"),
    ],
)
def test_a_drive_that_cannot_be_used_says_why(options: dict[str, Any], why: str) -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.until(lambda: why in control.drive.link.why, why)
        assert not control.drive.link.is_there

    with_drive(run, **options)


def test_a_drive_without_process_data_is_read_by_sdo_and_makes_its_own_ramps() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        assert not control.drive.follows_paths
        await control.do("enable", {})
        await control.do("move_abs", {"position_deg": 45.0})
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert control.motion.failure is None
        assert control.drive.values()["position_deg"] == pytest.approx(45, abs=0.5)
        await asyncio.to_thread(far.power_off)
        await world.until(lambda: not control.drive.link.is_there, "the loss")
        await asyncio.to_thread(far.power_on)
        await world.there(control)

    with_drive(run, read_only=(0x1A00, 0x1017))


def test_a_blocked_shaft_fails_its_motion() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        await control.do("enable", {})
        far.is_blocked = True
        await control.do("move_abs", {"position_deg": 45.0})
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert "the drive does not follow: it stands at 0.00 deg, and was sent to 45.00" in (
            control.motion.failure or ""
        )

    with_drive(run)


def test_drives_of_one_bus_share_it_and_one_goes_without_the_other() -> None:
    bus = virtual_bus()
    drives = [ScriptedDrive(node, bus) for node in (5, 6)]

    async def run(world: CanWorld) -> None:
        place = CanPlace("virtual", bus["channel"])
        controls = [world.add_can(f"x{node}", place, node) for node in (5, 6)]
        for control in controls:
            await world.there(control)
            await control.do("enable", {})
        await asyncio.to_thread(drives[0].power_off)
        await world.until(lambda: not controls[0].drive.link.is_there, "the loss")
        await controls[1].do("move_abs", {"position_deg": 45.0})
        await world.until(lambda: not controls[1].motion.is_under_way, "the end")
        assert controls[1].drive.link.counters.reconnects == 0
        await world.end(world.drives.pop("x5"))
        assert controls[1].drive.link.is_there

    try:
        in_drive_world(CanWorld, run)
    finally:
        drives[1].power_off()


def test_a_drive_watches_its_master_while_it_is_asked() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        heard: list[float] = []
        far.network.subscribe(0x77F, lambda *_: heard.append(time.monotonic()))
        await world.there(control)
        assert far.watched == 127 << 16 | 500
        assert control.drive.notes == ()
        await asyncio.sleep(1)
        assert max(after - before for before, after in pairwise(heard)) < 0.3
        await world.end(world.drives.pop("x"))
        assert far.watched == 0

    with_drive(run, master=127)


def test_a_drive_that_cannot_watch_its_master_says_so() -> None:
    async def run(world: CanWorld, far: ScriptedDrive, control: DriveControl) -> None:
        await world.there(control)
        assert control.drive.notes == ("it does not watch its master: it has no 1016h",)

    with_drive(run, master=127, without=(0x1016,))


def test_garbage_on_the_bus_and_wrong_answers_break_nothing() -> None:
    bus = virtual_bus()
    far, chance = ScriptedDrive(5, bus), random.Random(5)

    async def run(world: CanWorld) -> None:
        control = world.add_can("x", CanPlace("virtual", bus["channel"]), 5)
        await world.there(control)
        await control.do("enable", {})
        with can.Bus(ignore_config=True, **bus) as other:
            for _ in range(2000):
                identifier = chance.choice((0x185, 0x285, 0x585, 0x585, 0x85, chance.randrange(0x800)))
                if identifier in (0, 0x205, 0x605, 0x705):
                    continue  # those are orders to the drive, or its death
                data = chance.randbytes(chance.randrange(9))
                other.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))
                if chance.random() < 0.1:
                    await asyncio.sleep(0.002)
        await asyncio.sleep(0.5)  # until the last of it was heard
        await world.there(control)
        await control.do("disable", {})
        await control.do("enable", {})
        await control.do("move_abs", {"position_deg": far.position / UNITS_PER_TURN * 360 + 30})
        await world.until(lambda: not control.motion.is_under_way, "the end")
        assert control.motion.failure is None

    try:
        in_drive_world(CanWorld, run)
    finally:
        far.power_off()


@pytest.mark.parametrize("is_bus_off", [False, True])
def test_an_adapter_that_is_gone_or_bus_off_is_opened_again(is_bus_off: bool) -> None:
    bus = virtual_bus()
    far = ScriptedDrive(5, bus)

    async def run(world: CanWorld) -> None:
        control = world.add_can("x", CanPlace("virtual", bus["channel"]), 5)
        await world.there(control)
        drive = control.drive
        assert isinstance(drive, CanDrive)
        adapter, why = drive.line._adapter, "No such device"
        if is_bus_off:  # as SocketCAN tells it
            adapter._heard(can.Message(arbitration_id=0x40, is_error_frame=True, is_extended_id=False))
            why = "the adapter is bus-off"
        else:
            adapter._end(f"{bus['channel']}: {why}")
        assert (drive.link.state, drive.link.why) == ("away", f"{bus['channel']}: {why}")
        with pytest.raises(VerbRefused, match=f"x is not there: {bus['channel']}: {why}"):
            await control.do("enable", {})
        await world.there(control)
        assert drive.link.counters.reconnects == 1
        await control.do("enable", {})

    try:
        in_drive_world(CanWorld, run)
    finally:
        far.power_off()
