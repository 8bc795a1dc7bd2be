"""An event loop whose time is simulated: a bench with a twin, and real boards, which are twins of another
bench behind their serial lines."""

import asyncio
import selectors
from types import SimpleNamespace
from typing import Any, cast

from hil.compose import find_catalogue
from hil.live.board_backend import BoardBackend
from hil.live.devices.bench_devices import DeviceAxes, Devices
from hil.live.devices.board_device import BoardDevice
from hil.live.devices.twin_device import TwinDevice, TwinHome
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.port_link import PortLink
from hil.testing import Bench
from hil.vocab.desk_protocol import Done
from hil.vocab.ports import Port

SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
BOARDS = {"m2": SERVO, "s2": {"profile": "sac"}}
SLICE_S = 0.001
UP_S = 4.2
"""Time from power-up until all boards take commands."""


class Programs:
    """Port of a real board without a program at it."""

    address = "nowhere"

    def backlog(self) -> int:
        return 0

    def write(self, data: bytes) -> None:
        """Ignored: nobody reads it."""

    def resume_reading(self) -> None:
        """Ignored: nothing was held up."""


class Line(Programs):
    """Serial line of a board. ``written``: what was typed, with the time in seconds; ``late_s``: delay of
    what is typed from now on."""

    def __init__(self, world: "World", name: str) -> None:
        self._world, self._name = world, name
        self.address = f"/dev/{name}"
        self.is_there, self.connects, self.late_s = True, 1, 0.0
        self.written: list[tuple[float, bytes]] = []

    def stats(self) -> Any:
        return SimpleNamespace(clients=int(self.is_there), connects=self.connects)

    def write(self, data: bytes) -> None:
        self.written.append((self._world.time(), data))
        if self.is_there:
            self._world.call_later(self.late_s, self._world.far.port(self._name).write, data)


class World(asyncio.SelectorEventLoop):
    """Loop in which nothing takes time but what sleeps. ``near``: the bench with the twin ``m1``; ``far``:
    that of the boards behind ``lines``; ``axes``: all three as a run sees them."""

    def __init__(self, line_delay_ms: float = 0.0) -> None:
        self._now_s = 0.0
        self.near = Bench({"bench": "near", "devices": {"m1": SERVO}})
        self.far = Bench({"bench": "far", "devices": BOARDS})
        self.lines = {name: Line(self, name) for name in BOARDS}
        self.places = Places()
        for name, line in self.lines.items():
            link = PortLink[BoardBackend](name, cast(Port, Programs()))
            link.occupy(BoardBackend(link, cast(Port, line)))
            self.places[name] = link
        known, near, delay_ns = find_catalogue().boards, self.near._runtime, round(line_delay_ms * 1e6)
        home = TwinHome(near, Places(), cast(Commits, None), self.near._time.sampler, {}, 1)
        self.devices = Devices({"m1": TwinDevice(home, near.devices["m1"], known["mechaduino"])})
        for name, board in BOARDS.items():
            profile = str(board["profile"])
            self.devices[name] = BoardDevice(
                near,
                self.places[name],
                (profile, known[profile]),
                self.lines[name].address,
                1,
                period_ns=20_000_000,
                delay_ns=delay_ns,
            )
        self.axes = DeviceAxes(self.devices, near)
        super().__init__(_Sleeping(self))

    def time(self) -> float:
        return self._now_s

    def end(self, name: str) -> BoardBackend:
        return cast(BoardBackend, self.places[name].backend)

    def pass_time(self, most_s: float) -> None:
        """Let time pass, until a board says something."""
        end_s = self._now_s + most_s
        while self._now_s < end_s - 1e-12:
            self._now_s = min(self._now_s + SLICE_S, end_s)
            for bench in (self.near, self.far):
                bench.run_until(self._now_s * 1e3)
            heard = {name: self.far.port(name).read() for name in BOARDS}
            for name, data in heard.items():
                if data and self.lines[name].is_there:
                    self.call_soon(self.end(name).from_board.received, data)
            if any(heard.values()):
                return

    async def taken(self) -> None:
        """Switch all axes on and take control of the boards."""
        await asyncio.sleep(UP_S)
        self.near.axis("m1").do("enable")
        for name, verb in (("m2", "enable"), ("s2", "reset")):
            doing = self.devices[name].do("", verb, {})
            assert not isinstance(doing, Done)
            await doing


class _Sleeping(selectors.DefaultSelector):
    def __init__(self, world: World) -> None:
        super().__init__()
        self._world = world

    def select(self, timeout: float | None = None) -> Any:
        assert timeout is not None, "everybody waits, and nothing will happen"
        if timeout > 0:
            self._world.pass_time(timeout)
        return super().select(0)


def in_world(doing: Any, line_delay_ms: float = 0.0) -> None:
    """Carry out ``await doing(world)``. ``line_delay_ms``: as in the configuration of both boards."""
    world = World(line_delay_ms)

    async def alone() -> None:
        try:
            await doing(world)
        finally:  # else a dialogue that goes on is found in a later test, when it is thrown away
            left = asyncio.all_tasks() - {asyncio.current_task()}
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)

    try:
        world.run_until_complete(alone())
    finally:
        world.close()
