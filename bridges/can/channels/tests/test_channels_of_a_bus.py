"""Channels at a desk that notes what it is asked: the media of python-can, holding up, faults."""

import asyncio
import socket
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import Any

import can
import pytest
from can.interfaces.udp_multicast.utils import pack_message

from bridges.can.bridge import Options, make
from bridges.can.bus.bus_events import BusEvent
from bridges.can.channels.bus_channel import BusChannel
from bridges.can.channels.channel_medium import frame_of, message_of
from bridges.can.channels.channel_options import UDP_GROUP, Channel
from bridges.can.channels.udp_medium import UdpMedium
from bridges.can.frames.can_frame import CanFrame
from hil.testing import RecordingDesk, check_bridge
from hil.vocab.address import Address
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Done
from hil.vocab.time import SimTimeNs
from hil.vocab.verbs import VerbRefused

NODE = Address("can0", "virtual")
FRAME = CanFrame(0x123, b"\1\2")
PATIENCE_S = 60.0


def in_loop(test: Callable[..., Coroutine[Any, Any, None]]) -> Callable[..., None]:
    """Make a test of a coroutine function."""

    @wraps(test)
    def run(*given: Any, **named: Any) -> None:
        asyncio.run(test(*given, **named))

    return run


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        return int(free.getsockname()[1])


class BusDesk(RecordingDesk):
    """Desk of a bus whose node has room for so many frames."""

    def __init__(self, free: int = 1024) -> None:
        super().__init__()
        self.free = free
        self.sent: list[str] = []
        self.calls: list[Callable[[BusEvent], object]] = []

    def ask(self, source: Any, operation: str, target: str, given: Any) -> Any:
        if self.refusal:
            raise self.refusal
        self.asked.append((source, operation, target))
        if operation == "attach":
            return Done(0, {"node": f"{target}.{given['node']}", "free": self.free})
        if operation == "transmit":
            self.sent += given["frames"]
            self.free -= len(given["frames"])
            return Done(0, {"refused": 0, "free": self.free})
        assert operation == "detach"
        return Done(0, {})

    def watch(self, source: Any, what: Any, target: str, call: Any, **more: Any) -> Any:
        self.calls.append(call)
        return super().watch(source, what, target, call, **more)

    def carry(self, frame: CanFrame, node: str = "m1.canopen") -> None:
        for call in self.calls:
            call(BusEvent(SimTimeNs(0), SimTimeNs(5_000_000_000), node, frame))


async def until(condition: Callable[[], object], what: str) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.002)
    assert condition(), what


def channel(desk: BusDesk, **options: Any) -> BusChannel:
    return BusChannel(desk, NODE, Channel(**{"interface": "virtual", **options}))


@in_loop
async def test_frames_pass_both_ways_with_their_times() -> None:
    desk = BusDesk()
    opened = channel(desk, channel="both")
    await opened.open()
    with can.Bus("both", "virtual", preserve_timestamps=True) as outside:
        outside.send(message_of(FRAME, 0.0))
        await until(lambda: desk.sent == ["123#0102"], "the frame at the desk")
        desk.carry(CanFrame(0x705, b"\0"))
        heard = outside.recv(1)
        assert heard is not None
        assert frame_of(heard) == CanFrame(0x705, b"\0")
        assert heard.timestamp == 1_700_000_000.0
        desk.carry(FRAME, "can0.virtual")
        assert outside.recv(0) is None, "its own frames are not told again"
        outside.send(can.Message(is_error_frame=True))
        outside.send(can.Message(is_fd=True, data=bytes(64)))
        await until(lambda: opened.status()["refused"] == 2, "what is no frame")
    assert {name: opened.status()[name] for name in ("in", "out", "dropped")} == {
        "in": 1,
        "out": 1,
        "dropped": 0,
    }
    await opened.close()
    assert [asked[1:] for asked in desk.asked] == [
        ("attach", "can0"),
        ("transmit", "can0.virtual"),
        ("detach", "can0.virtual"),
    ]
    assert not desk.watches


@in_loop
async def test_programs_are_held_up_when_the_node_has_no_room() -> None:
    desk = BusDesk(free=150)
    opened = channel(desk, channel="held")
    await opened.open()
    with can.Bus("held", "virtual") as outside:
        for number in range(1000):
            outside.send(message_of(CanFrame(number), 0.0))
        await asyncio.sleep(0.2)
        assert 86 < len(desk.sent) <= 150
        while len(desk.sent) < 1000:
            before = len(desk.sent)
            for _ in range(before + 150 - desk.free - before):
                desk.free += 1
                desk.carry(FRAME, "can0.virtual")
            await until(lambda before=before: len(desk.sent) > before, "more")  # type: ignore[misc]
            assert desk.free >= 0
    assert desk.sent == [str(CanFrame(number)) for number in range(1000)]
    await opened.close()


@in_loop
async def test_a_desk_that_refuses_does_not_end_a_channel() -> None:
    desk = BusDesk()
    opened = channel(desk, channel="refused")
    await opened.open()
    with can.Bus("refused", "virtual") as outside:
        desk.refusal = VerbRefused("not_now", "no")
        outside.send(message_of(FRAME, 0.0))
        await until(lambda: opened.status()["refused"] == 1, "the refusal")
        desk.refusal = None
        outside.send(message_of(FRAME, 0.0))
        await until(lambda: desk.sent == ["123#0102"], "the next frame")
    desk.refusal = VerbRefused("no_place", "it has gone")
    await opened.close()


@in_loop
async def test_what_the_bus_refuses_is_told_at_the_start() -> None:
    desk = BusDesk()
    desk.refusal = VerbRefused("no_place", "there is no CAN bus 'can0'")
    bridge = make(Options(channels={"can0": Channel(interface="virtual")}), desk)
    with pytest.raises(BridgeError, match=r"channels\.can0: can0: there is no CAN bus"):
        await bridge.open()
    assert bridge.status()["links"] == 0


@in_loop
async def test_an_interface_that_is_not_there_is_told_at_the_start() -> None:
    bridge = make(Options(channels={"can0": Channel(interface="socketcan", channel="none9")}), BusDesk())
    with pytest.raises(BridgeError, match="socketcan none9: "):
        await bridge.open()


@pytest.mark.parametrize(
    ("is_open", "hosts", "heard"), [(False, set(), 0), (True, set(), 1), (False, None, 1)]
)
@in_loop
async def test_strangers_are_heard_with_leave_alone(
    is_open: bool, hosts: set[str] | None, heard: int
) -> None:
    """A program of this computer stands for one of another."""
    port = _free_port()
    medium, frames = UdpMedium(UDP_GROUP, port, is_open=bool(is_open)), list[CanFrame]()
    medium.open(asyncio.get_running_loop(), frames.extend)
    if hosts is not None:
        medium._hosts = hosts
    assert medium.send(FRAME, 0.0), "it does not hear itself"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(pack_message(message_of(CanFrame(0x321), 0.0)), (UDP_GROUP, port))
    await until(lambda: len(frames) + medium.strangers == 1, "the frame")
    assert (frames, medium.strangers) == ([CanFrame(0x321)] * heard, 1 - heard)
    await medium.close()


@pytest.mark.parametrize(
    "message",
    [
        can.Message(arbitration_id=0x123, is_extended_id=False, data=b"\1\2"),
        can.Message(arbitration_id=0x1ABCDEF0, data=bytes(8)),
        can.Message(arbitration_id=0x123, is_extended_id=False, is_remote_frame=True, dlc=5),
    ],
)
def test_a_message_is_the_same_behind_a_frame(message: can.Message) -> None:
    frame = frame_of(message)
    assert frame is not None
    assert message_of(frame, 0.0).equals(message)


@pytest.mark.parametrize(
    "wrong",
    [{"arbitration_id": 0x800, "is_extended_id": False}, {"data": bytes(9), "dlc": 9}, {"is_fd": True}],
)
def test_a_message_that_is_none_of_classic_can_is_no_frame(wrong: dict[str, Any]) -> None:
    assert frame_of(can.Message(**wrong)) is None


@pytest.mark.long
def test_it_keeps_to_what_bridges_keep_to() -> None:
    """The probe sends a frame through the bridge, and finds it at the desk."""
    desks: list[BusDesk] = []

    def desk() -> BusDesk:
        desks.append(BusDesk())
        return desks[-1]

    async def ask(status: Any) -> str:
        made = desks[-1]
        before = len(made.sent)
        with can.Bus("checked", "virtual") as outside:
            outside.send(message_of(FRAME, 0.0))
            while len(made.sent) == before:
                await asyncio.sleep(0.002)
        return made.sent[-1]

    group = Channel(interface="udp_multicast", port=_free_port())
    checked = Channel(interface="virtual", channel="checked")
    options = Options(channels={"can0": checked, "can1": group})
    check_bridge(lambda made: make(options, made), ask=ask, desk=desk, patience_s=1.0)
