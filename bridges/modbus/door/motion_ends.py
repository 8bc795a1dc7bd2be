"""Ends of motions that writes started: each verb's bit says when its motion has ended."""

import asyncio
from typing import Any

from bridges.modbus.door.door_units import DoorUnit
from bridges.modbus.registers.control_word import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from hil.vocab.desk_protocol import Desk, Done, Source
from hil.vocab.verbs import Effect, VerbRefused


class MotionEnds:
    """Ends of motions that are awaited: one of each verb of each unit, the last that was started."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._waits: dict[tuple[DoorUnit, int], asyncio.Task[None]] = {}

    def follow(self, unit: DoorUnit, wanted: Wanted, source: Source, answer: Any) -> None:
        """Note in the unit that a verb was carried out, and later that its motion has ended."""
        if (number := wanted.number) is None:
            return
        self._drop(unit, number)
        verb = unit.info.verbs[str(wanted.given["name"])]
        if verb.effect is not Effect.ENDS or not unit.info.is_seen or not isinstance(answer, Done):
            unit.registers.note(wanted, VerbStage.DONE)
            return
        unit.registers.note(wanted, VerbStage.BUSY)
        task = asyncio.get_running_loop().create_task(self._wait(unit, wanted, source, answer))
        self._waits[unit, number] = task
        task.add_done_callback(lambda ended: self._forget(unit, number, ended))

    async def _wait(self, unit: DoorUnit, wanted: Wanted, source: Source, done: Done) -> None:
        given = {name: done.answer[name] for name in ("ends_after_ns", "set_point") if name in done.answer}
        given["effective_at_ns"] = done.effective_at_ns
        try:
            ended = await self._desk.ask(source, "wait", unit.info.name, given)
        except VerbRefused:
            unit.registers.note(wanted, VerbStage.REFUSED)
        else:
            unit.registers.note(wanted, VerbStage.REFUSED if ended["interrupted"] else VerbStage.DONE)

    def _forget(self, unit: DoorUnit, number: int, ended: asyncio.Task[None]) -> None:
        if self._waits.get((unit, number)) is ended:
            del self._waits[unit, number]

    def _drop(self, unit: DoorUnit, number: int) -> None:
        if before := self._waits.pop((unit, number), None):
            before.cancel()

    async def close(self) -> None:
        waits = list(self._waits.values())
        for wait in waits:
            wait.cancel()
        await asyncio.gather(*waits, return_exceptions=True)
