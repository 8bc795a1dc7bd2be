"""Channels: a frame from one program of python-can to another through a bench's bus, in one process.

``can_channel_pair``: time for a frame from a program at one ``virtual`` channel over the simulated bus, at
1 Mbit/s and with an input for each burst, to a program at another channel; beside python-can's ``virtual``
alone, in turns, on which it is sent and received once. Here it is sent and received twice, and passes a
thread; at most eight times as much is wanted, which is more than a full bus has.

``can_kit_pair``: the same by ``python_can()`` of the kit, whose ``recv`` lets simulated time pass; at most
twice as much as python-can's bus is wanted.

``can_channel_in`` and ``can_channel_out``: core for each frame from a group of UDP to the bus, and from the
bus to the group, without the programs there.
"""

import asyncio
import statistics
import time
from collections.abc import Callable
from typing import Any

import can
from _report import is_quick, report
from can.interfaces.udp_multicast.utils import pack_message

from bridges.can.channels.bus_channel import BusChannel
from bridges.can.channels.channel_medium import message_of
from bridges.can.channels.channel_options import UDP_GROUP, Channel
from bridges.can.channels.udp_medium import UdpMedium
from bridges.can.frames.can_frame import CanFrame
from hil.compose.build import bench_runtime
from hil.compose.find import find_catalogue
from hil.compose.replay import MemoryOptions
from hil.config import from_dict
from hil.operations.device_operations import ChannelOperations
from hil.operations.table import Asked
from hil.testing import Bench
from hil.vocab.address import Address
from hil.vocab.desk_protocol import LOCAL
from hil.vocab.time import SimTimeNs

FRAMES = 2_000 if is_quick() else 10_000
RUNS = 3 if is_quick() else 7
FRAME_NS = 140_000
CONFIG = {
    "bench": "b",
    "devices": {"m1": {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}},
    "can": {"can0": {"bit_rate": 1_000_000, "nodes": {"m1": 5}}},
}
DATA = bytes(range(8))
PORT = 43199


class BusDesk:
    """Desk of a bench in virtual time, which goes on by what frames take."""

    def __init__(self) -> None:
        catalogue = find_catalogue({"memory": MemoryOptions})
        self.sim = bench_runtime(from_dict(CONFIG, catalogue), catalogue, {}, _NoStore())
        self._channels = ChannelOperations(self.sim)
        self.sim.advance(SimTimeNs(10**7))

    def ask(self, source: Any, operation: str, target: str, given: Any) -> Any:
        done = getattr(self._channels, operation)(Asked(LOCAL, target), **given)
        if operation == "transmit":
            self.sim.advance(SimTimeNs(self.sim.now_ns + FRAME_NS * len(given["frames"])))
            done.answer["free"] = 1024
        return done

    def watch(self, source: Any, what: Any, target: str, call: Callable[..., Any]) -> Any:
        watchers = self.sim.wires[target].watchers
        watchers.append(call)
        return _Watch(lambda: watchers.remove(call))

    def describe(self) -> Any:
        return self

    @property
    def clock(self) -> Any:
        return self

    def wall_ns(self, sim_ns: int) -> int:
        return sim_ns


class _NoStore:
    def commit(self, *given: Any) -> bool:
        return True


class _Watch:
    def __init__(self, close: Callable[[], None]) -> None:
        self.close = close


async def _through() -> float:
    desk: Any = BusDesk()
    channels = [
        BusChannel(desk, Address("can0", name), Channel(interface="virtual", channel=name))
        for name in ("left", "right")
    ]
    for channel in channels:
        await channel.open()
    message = can.Message(arbitration_id=0x123, data=DATA, is_extended_id=False)
    try:
        with can.Bus("left", "virtual") as left, can.Bus("right", "virtual") as right:
            began, heard = time.perf_counter(), 0
            for _ in range(FRAMES):
                left.send(message)
            while heard < FRAMES:
                await asyncio.sleep(0)
                while right.recv(0):
                    heard += 1
            return (time.perf_counter() - began) / FRAMES
    finally:
        for channel in channels:
            await channel.close()


def theirs() -> float:
    with can.Bus("bench", interface="virtual") as a, can.Bus("bench", interface="virtual") as b:
        message = can.Message(arbitration_id=0x123, data=DATA, is_extended_id=False)
        began = time.perf_counter()
        for _ in range(FRAMES):
            a.send(message)
            assert b.recv(0)
        return (time.perf_counter() - began) / FRAMES


def _in_the_kit() -> float:
    bench = Bench(CONFIG)
    message = can.Message(arbitration_id=0x123, data=DATA, is_extended_id=False)
    here = bench.canbus()
    with here.python_can("a") as a, here.python_can("b") as b:
        bench.run(10)
        began = time.perf_counter()
        for _ in range(FRAMES):
            a.send(message)
            assert b.recv(1)
        return (time.perf_counter() - began) / FRAMES


async def _udp_in() -> float:
    """Core time for a frame from the group to the bus; the packets are there when it begins."""
    desk: Any = BusDesk()
    heard = []
    desk.sim.wires["can0"].watchers.append(lambda event: heard.append(event) if event.frame else None)
    channel = BusChannel(desk, Address("can0", "udp"), _udp())
    await channel.open()
    sender = UdpMedium(UDP_GROUP, PORT, is_open=False)
    sender.open(asyncio.get_running_loop(), lambda frames: None)
    packed = pack_message(message_of(CanFrame(0x123, DATA), 0.0))
    spent, count = 0.0, 0
    assert sender._sender
    while count < FRAMES:
        for _ in range(50):
            sender._sender.send(packed)
        sender.hold(True)
        before, began = len(heard), time.process_time()
        while len(heard) < before + 50:
            await asyncio.sleep(0)
        spent, count = spent + time.process_time() - began, count + 50
    await sender.close()
    await channel.close()
    return spent / count


async def _udp_out() -> float:
    desk: Any = BusDesk()
    channel = BusChannel(desk, Address("can0", "udp"), _udp())
    await channel.open()
    desk.ask(LOCAL, "attach", "can0", {"node": "other"})
    text, count, spent = str(CanFrame(0x123, DATA)), 0, 0.0
    bare = BusDesk()
    bare.ask(LOCAL, "attach", "can0", {"node": "other"})
    while count < FRAMES:
        began = time.process_time()
        desk.ask(LOCAL, "transmit", "can0.other", {"frames": [text] * 50})
        between = time.process_time()
        bare.ask(LOCAL, "transmit", "can0.other", {"frames": [text] * 50})
        spent += 2 * between - began - time.process_time()
        count += 50
        await asyncio.sleep(0)
    await channel.close()
    return spent / count


def _udp() -> Channel:
    return Channel(interface="udp_multicast", port=PORT)


def main() -> None:
    rows: list[tuple[float, float]] = [(asyncio.run(_through()), theirs()) for _ in range(RUNS)]
    ours, other = (statistics.median(column) for column in zip(*rows, strict=True))
    about: dict[str, object] = {"reference": "python-can's virtual bus, once"}
    report("can_channel_pair", ours * 1e6, "us", other * 1e6, 8, about)
    print(f"  {1 / ours:,.0f} a second, python-can {1 / other:,.0f}")
    pairs = [(_in_the_kit(), theirs()) for _ in range(RUNS)]
    kit, other = (statistics.median(column) for column in zip(*pairs, strict=True))
    report("can_kit_pair", kit * 1e6, "us", other * 1e6, 2, about)
    for name, work in (("can_channel_in", _udp_in), ("can_channel_out", _udp_out)):
        value = statistics.median(asyncio.run(work()) for _ in range(RUNS))
        full: dict[str, object] = {"reference": "time of the shortest frame with 8 bytes at 1 Mbit/s"}
        report(name, value * 1e6, "us", 111, 1, full)


main()
