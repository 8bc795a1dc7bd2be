"""Axes of a bench, real boards beside twins, as runs find them."""

import asyncio
from dataclasses import replace
from typing import Any

from hil.live.configured import Configured
from hil.live.drives.drive_axes import DriveAxes
from hil.live.places import Places
from hil.live.runs.real_axis import RealAxis
from hil.runs import bounds_of
from hil.sim.bench import BenchRuntime
from hil.vocab.axis import Axes, Axis, AxisNow
from hil.vocab.dialogue import Dialogue

LEAD_NS = 250_000_000
"""Time to tell a SAC its motion before a phrase: 20 ms at 38400 baud, and 32 ms of a USB adapter."""


class RealAxes:
    """Axes of the real boards of a bench, as ``hil.vocab.axis.Axes``. ``bench``: the one whose time they go
    by."""

    def __init__(self, places: Places, configured: Configured, bench: BenchRuntime) -> None:
        self._places = places.boards
        self._configured = configured
        self._bench = bench
        self._boards: dict[str, RealAxis] = {}
        """Boards that were asked for, by name."""

    def __contains__(self, name: str) -> bool:
        return name in self._places

    def _board(self, name: str) -> RealAxis | None:
        """Board of a name, renewed when the name is another's, as after a reload. None: no use for runs."""
        through, config = self._places[name].end, self._configured.config.devices[name]
        board = self._boards.get(name)
        if board is not None and board.through is through:
            return board
        if (make := self._configured.catalogue.boards[config.profile].terminal_axis) is None:
            return None
        delay_ns = round(config.line_delay_ms * 1e6)
        board = self._boards[name] = RealAxis(
            self._bench, through, make(delay_ns), round(1e9 / config.setpoint_rate_Hz), LEAD_NS + delay_ns
        )
        return board

    async def carry_out(self, name: str, verb: str, dialogue: Dialogue[Any]) -> None:
        """Carry out a verb of a board that no run has. ``RealAxis.taken_by`` is the verb that takes control.

        Raises:
            DialogueError: it is away, or does not answer as it should.
        """
        board = self._board(name)
        if board and verb == board.taken_by:
            await board.acquire()
            return
        if board:
            board.forget()
        await self._places[name].end.talk(dialogue)

    async def close(self) -> None:
        """Stop what still moves."""
        await asyncio.gather(*(board.end() for board in self._boards.values()))

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def axes(self) -> dict[str, AxisNow]:
        return {name: self._now(name) for name in self._places}

    def _now(self, name: str) -> AxisNow:
        if board := self._board(name):
            verbs = self._configured.catalogue.boards[self._configured.config.devices[name].profile].table
            now = board.now()
            now = replace(now, bounds=bounds_of(verbs, follows_paths=now.follows_paths))
            if (speed := self._configured.config.speed) != 1:
                why = f"the bench goes at {speed:g} times the speed of its real boards"
                return replace(now, why_not=why, remedy="write `speed: 1` in its configuration")
            return now
        profile = self._configured.config.devices[name].profile
        why = f"a real {profile} has nothing for runs at its terminal"
        return AxisNow(0.0, follows_paths=False, why_not=why, tells_position=False)

    def __getitem__(self, device: str) -> Axis:
        return self._boards[device]


class AllAxes:
    """Axes of a bench, of twins, real boards and real drives, as ``hil.vocab.axis.Axes``."""

    def __init__(self, twins: Axes, real: RealAxes, drives: DriveAxes) -> None:
        self._twins = twins
        self._real = real
        self._drives = drives

    @property
    def now_ns(self) -> int:
        return self._twins.now_ns

    def axes(self) -> dict[str, AxisNow]:
        return self._twins.axes() | self._real.axes() | self._drives.axes()

    def __getitem__(self, device: str) -> Axis:
        if device in self._drives:
            return self._drives[device]
        return self._real[device] if device in self._real else self._twins[device]
