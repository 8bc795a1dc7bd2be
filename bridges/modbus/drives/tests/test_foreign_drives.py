"""Real drives of another hand: they are read, moved, streamed to and stopped, over TCP and a serial line."""

import asyncio
import statistics
from collections.abc import Awaitable, Callable

import pytest
from drive_world import in_drive_world
from foreign_drives import ForeignDrives, drive_map
from modbus_world import ModbusWorld

from bridges.modbus.drives.map_orders import MapOrders
from bridges.modbus.drives.register_drive import RegisterDrive
from bridges.modbus.maps.drive_map_text import read_drive_map
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS
from hil.vocab.verbs import VerbRefused

pytestmark = pytest.mark.long


def with_drives(
    doing: Callable[[ModbusWorld, ForeignDrives, str], Awaitable[None]],
    *units: int,
    pty: bool = False,
    echoes: bool = False,
) -> None:
    async def run(world: ModbusWorld) -> None:
        foreign = ForeignDrives(*units)
        if pty:
            at = f"modbus+rtu://{await foreign.sit_at_pty(echoes=echoes)}?format=8N1&baud=19200&unit="
        else:
            at = f"modbus+tcp://127.0.0.1:{await foreign.listen()}?unit="
        try:
            await doing(world, foreign, at)
        finally:
            await world.close()
            await foreign.close()

    in_drive_world(ModbusWorld, run)


@pytest.mark.parametrize(("pty", "echoes"), [(False, False), (True, False), (True, True)])
def test_verbs_move_a_drive(pty: bool, echoes: bool) -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x = await world.there(world.add("x", f"{at}3"))
        with pytest.raises(VerbRefused, match="its loop is off; enable it first"):
            await x.do("move_abs", {"position_deg": 90.0})
        await x.do("enable", {})
        assert x.drive.is_on
        answer = await x.do("move_abs", {"position_deg": 30.5, "velocity_rpm": 100.0})
        assert answer == {"set_point": 30.5}
        assert await foreign.word(3, 12) == 100
        await world.until(lambda: not x.axis.motion.is_under_way, "the end")
        assert x.axis.failure is None
        assert x.drive.values()["position_deg"] == pytest.approx(30.5, abs=0.5)
        if pty:
            state = "yes" if echoes else "no"
            await world.until(lambda: x.drive.echo and x.drive.echo.state == state, f"the echo is {state}")
            assert x.drive.echo
            assert x.drive.echo.collisions == 0
        assert x.drive.commanded_deg == 30.5
        await x.do("move_rel", {"angle_deg": -10.5})
        await world.until(lambda: not x.axis.motion.is_under_way, "the end")
        await world.until(lambda: abs(x.drive.values()["position_deg"] - 20.0) < 0.02, "the angle")
        assert foreign.ramps[3].starts == 2
        await x.do("disable", {})
        assert not x.drive.is_on

    with_drives(doing, 3, pty=pty, echoes=echoes)


def test_what_is_told_of_a_drive() -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        await asyncio.sleep(0)
        x = await world.there(world.add("x", f"{at}1"))
        await world.until(lambda: x.drive.link.counters.polls > 20, "polls")
        told = x.drive.values()
        assert told["connected"] == 1
        assert 0 <= told["age_ms"] < 500
        assert told["polls"] > 20
        assert (told["time_outs"], told["exceptions"], told["reconnects"]) == (0, 0, 0)
        assert 0 < told["round_trip_p50_ms"] <= told["round_trip_p99_ms"] < 200
        await x.set("pKp", 1.5)
        assert x.drive.values()["pKp"] == 1.5
        assert (await foreign.word(1, 30), await foreign.word(1, 31)) == (0x3FC0, 0)
        with pytest.raises(VerbRefused, match="pKp: write a number"):
            await x.set("pKp", "much")
        with pytest.raises(VerbRefused, match="pKp: the registers of the drive cannot hold 1e"):
            await x.set("pKp", 1e300)
        await foreign.set_word(1, 30, 0x4000)
        await world.until(lambda: x.drive.values()["pKp"] == 2.0, "the parameter that somebody else wrote")

    with_drives(doing, 1)


def test_two_drives_share_a_line() -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x, y = world.add("x", f"{at}3"), world.add("y", f"{at}4")
        for each in (x, y):
            await world.there(each)
            await each.do("enable", {})
        await x.do("move_abs", {"position_deg": 20.0})
        await y.do("move_abs", {"position_deg": -20.0})
        for each in (x, y):
            await world.until(lambda each=each: not each.axis.motion.is_under_way, "the end")
            assert each.axis.failure is None
        assert foreign.ramps[3].position_deg == pytest.approx(20.0, abs=0.5)
        assert foreign.ramps[4].position_deg == pytest.approx(-20.0, abs=0.5)

    with_drives(doing, 3, 4, pty=True)


def test_a_unit_that_is_not_there_does_not_hold_up_the_others_on_its_line() -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x, gone = world.add("x", f"{at}3"), world.add("gone", f"{at}9")
        await world.there(x)
        await world.until(lambda: gone.drive.link.counters.time_outs > 3, "time-outs")
        before = x.drive.link.counters.polls
        await world.until(lambda: x.drive.link.counters.polls - before > 20, "polls beside the time-outs")
        assert not gone.drive.link.is_there
        assert gone.drive.link.why == "no answer within 0.2 s"
        assert x.drive.link.is_there

    with_drives(doing, 3, pty=True)


def test_a_path_is_streamed_and_comes_to_its_end() -> None:
    path = (PathPiece(500 * NS_PER_MS, 0.0, 90.0), PathPiece(0, 45.0))

    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x = await world.there(world.add("x", f"{at}1"))
        await x.do("enable", {})
        axis = x.axis
        now = axis.now()
        assert (now.why_not, now.follows_paths, now.position_deg) == (None, True, 0.0)
        axis.hold()
        with pytest.raises(VerbRefused, match="a run has this drive"):
            await x.do("move_abs", {"position_deg": 1.0})
        axis.follow(path, world.now_ns + 100 * NS_PER_MS)
        await world.until(lambda: not axis.state().is_under_way, "the end")
        state = axis.state()
        assert (axis.failure, state.commanded_deg, state.is_moving) == (None, 45.0, False)
        samples = axis.samples()
        assert len(samples) > 20
        # The median: a computer that is busy may be a fifth of a second behind for one of them.
        assert statistics.median(abs(wanted - is_at) for _, wanted, is_at in samples) < 10
        axis.release()
        await world.until(lambda: not x.drive.reading.bits["control.follow"], "no following any more")

    with_drives(doing, 1)


def test_a_stream_that_is_stopped_rests_on_a_ramp_where_the_drive_has_no_bit_for_it() -> None:
    path = (PathPiece(5000 * NS_PER_MS, 0.0, 90.0), PathPiece(0, 450.0))

    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x = await world.there(world.add("x", f"{at}1", map=drive_map(without="stop")))
        await x.do("enable", {})
        x.axis.hold()
        x.axis.follow(path, world.now_ns + 100 * NS_PER_MS)
        await world.until(lambda: foreign.ramps[1].position_deg > 20, "some way")
        x.axis.stop("grace", 100.0)
        stopped_deg = foreign.ramps[1].position_deg
        await world.until(lambda: not x.axis.state().is_moving, "rest")
        assert stopped_deg + 3 < foreign.ramps[1].position_deg < stopped_deg + 30
        assert x.axis.failure is None

    with_drives(doing, 1)


def test_a_drive_that_only_follows_is_moved_by_ramps_of_the_daemon() -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x = await world.there(world.add("x", f"{at}1", map=drive_map(without="start")))
        await x.do("enable", {})
        answer = await x.do(
            "move_abs", {"position_deg": 45.0, "velocity_rpm": 60.0, "acceleration_rpm_per_s": 600.0}
        )
        assert answer["set_point"] == 45.0
        await world.until(lambda: not x.axis.motion.is_under_way, "the end")
        assert foreign.ramps[1].position_deg == pytest.approx(45.0, abs=0.5)
        assert foreign.ramps[1].starts == 0

    with_drives(doing, 1)


@pytest.mark.thorough
def test_why_a_run_fails() -> None:
    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        x = await world.there(world.add("x", f"{at}1"))
        ramp, axis = foreign.ramps[1], x.axis

        async def fails(why: str) -> None:
            await world.until(lambda: axis.failure, why)
            assert why in str(axis.failure)
            axis.stop("prejudice", 100.0)
            axis.release()
            await world.until(lambda: not axis.motion.is_under_way, "the end")

        async def begin() -> None:
            await x.do("reset", {})
            await x.do("enable", {})
            await world.until(lambda: axis.now().why_not is None, "rest")
            axis.hold()
            here_deg = axis.now().position_deg
            path = (PathPiece(3000 * NS_PER_MS, here_deg, 10.0), PathPiece(0, here_deg + 30))
            axis.follow(path, world.now_ns)
            await asyncio.sleep(0.2)

        await begin()
        ramp.fault = 7
        await fails("the drive has fault 7")
        await begin()
        await foreign.set_word(1, 20, FOLLOWING)
        await fails("its loop is off; somebody disabled it")
        await begin()
        await x.do("stop", {})
        await fails("somebody gave it the verb stop")
        await begin()
        ramp.is_stuck = True
        await fails("the drive does not follow")

    with_drives(doing, 1)


FOLLOWING = 16


def test_a_write_of_some_bits_leaves_the_others_as_the_drive_has_them() -> None:
    text = """
modbus_map: 2
position_deg: {input: 0, type: i32, scale: 0.01}
set_velocity_rpm: {holding: 40, mask: 0x0FF0}
cells: {filter: {holding: 40, mask: 0xF00F}}
"""

    async def doing(world: ModbusWorld, foreign: ForeignDrives, at: str) -> None:
        of = read_drive_map(text, "map.yaml")
        x = await world.there(world.add("x", f"{at}3", map=of))
        assert isinstance(x.drive, RegisterDrive)
        await foreign.set_word(3, 40, 0xA125)
        writes = MapOrders(of, lambda cell: 0).value("set_velocity_rpm", 0x77)
        await x.drive.write_all(writes, x.drive.link.session)
        assert await foreign.word(3, 40) == 0xA775

    with_drives(doing, 3)
