"""Requests to units, carried out at the desk, and their answers. The same for all lines and connections."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Collection, Coroutine, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import isawaitable
from typing import Any

from bridges.modbus.door.door_options import UNITS
from bridges.modbus.protocol.identification import Identification
from bridges.modbus.protocol.pdu import Code, Refused, Request, exception, parse
from bridges.modbus.registers.cells import Halves
from bridges.modbus.registers.map_parts import USUAL, Manners
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from bridges.modbus.registers.registers_protocol import Registers, code_and_reason
from bridges.modbus.registers.units import unit_of
from bridges.modbus.unit_transaction import LOOK, Transaction, at_once, unit_transaction
from hil.net.visitors import Limit
from hil.vocab.address import owner_of
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import AxisLook, Desk, DeviceInfo, Done, Source
from hil.vocab.verbs import Effect, VerbRefused

_ANY = (0, 255)
"""Numbers with which clients mean a device that is no gateway (Messaging on TCP/IP V1.0b, 3.1.3)."""


@dataclass(eq=False)
class DoorUnit:
    """Unit of the door. ``info``: of its axis."""

    number: int
    info: DeviceInfo
    registers: Registers = field(repr=False)


def _is_unit(info: DeviceInfo) -> bool:
    """True if a device takes a number by itself: a twin with neither an axis nor fields has no registers but
    those of its verbs, and ``units`` may give it one."""
    return info.is_real or info.is_seen or info.own_map is not None


class DoorUnits:
    """Units by number. ``wanted``: numbers by axis; None: axes in the order of the bench, from 1 on, and
    boards without a motor that have fields of their own."""

    def __init__(self, desk: Desk, wanted: Mapping[str, int] | None, is_low_first: bool) -> None:
        self._desk, self._wanted, self._is_low_first = desk, wanted, is_low_first
        self._units: dict[int, DoorUnit] = {}

    def open(self) -> None:
        """Make the units. Raises BridgeError: an axis is not there, or two have one number."""
        devices, wanted = self._desk.describe().devices, self._wanted or {}
        if len(set(wanted.values())) < len(wanted):
            raise BridgeError(f"units: {dict(wanted)}: give each a number of its own")
        for axis in wanted:
            if axis not in devices:
                known = ", ".join(devices)
                raise BridgeError(f"units: there is no axis {axis!r}; there are {known}")
        self.renew(())

    def renew(self, names: Collection[str]) -> None:
        """Make the units of these devices again, and those of axes that have another number now."""
        devices, old = self._desk.describe().devices, self._units
        numbers = self._wanted or dict(
            zip(filter(lambda name: _is_unit(devices[name]), devices), UNITS, strict=False)
        )
        self._units = {}
        for axis, number in numbers.items():
            unit = old.get(number)
            if unit and unit.info.name == axis and owner_of(axis) not in names:
                self._units[number] = unit
            elif info := devices.get(axis):
                registers = unit_of(info, is_low_first=self._is_low_first)
                self._units[number] = DoorUnit(number, info, registers)

    def find(self, number: int) -> DoorUnit:
        """The unit that a number means. Raises Refused: as a gateway says it."""
        if unit := self._units.get(number):
            return unit
        if number in _ANY and len(self._units) == 1:
            return next(iter(self._units.values()))
        if self._wanted and number in self._wanted.values():
            raise Refused(Code.GATEWAY_TARGET_FAILED, f"the axis of unit {number} has gone")
        raise Refused(Code.GATEWAY_PATH_UNAVAILABLE, f"there is no unit {number}")

    def all(self) -> Sequence[DoorUnit]:
        """All units, by number."""
        return [self._units[number] for number in sorted(self._units)]

    def shown(self) -> dict[str, str]:
        """Axes by number, for the status."""
        return {str(unit.number): unit.info.name for unit in self.all()}


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


log = logging.getLogger("hil")


@dataclass(eq=False)
class Asker:
    """Client of the door. What it has written of a value, and not yet the rest, is its own."""

    source: Source
    halves: dict[DoorUnit, Halves] = field(default_factory=dict)


class RequestHandler:
    """Requests to the units of a bench. ``carried_out``: operations that were; ``exceptions``: by code."""

    def __init__(self, desk: Desk, units: DoorUnits, identify: Callable[[DoorUnit], Identification]) -> None:
        self._desk, self._units, self._identity = desk, units, identify
        self._ends = MotionEnds(desk)
        self._limits: dict[int, Limit] = {}
        self.requests = self.carried_out = 0
        self.exceptions: Counter[str] = Counter()

    def answer(self, asker: Asker, number: int, pdu: bytes) -> bytes | Coroutine[Any, Any, bytes]:
        """Carry out a request to the unit of a number; answers as ``answer_of``."""
        try:
            unit = self._units.find(number)
        except Refused as error:
            self.requests += 1
            return self._refuse(asker, number, pdu[0], error)
        return self.answer_of(asker, unit, pdu)

    def answer_of(self, asker: Asker, unit: DoorUnit, pdu: bytes) -> bytes | Coroutine[Any, Any, bytes]:
        """Carry out a request to a unit; answers the PDU for the client, an exception where it is refused.
        What is written may take time."""
        self.requests += 1
        try:
            request = parse(pdu)
            if request.write or request.mask:
                return self._awaited(asker, unit, request)
            return at_once(self._steps(asker, unit, request), lambda: self._look(asker, unit), _no_operation)
        except (Refused, VerbRefused) as error:
            return self._refuse(asker, unit.number, pdu[0], error, unit.registers.manners)

    def _steps(self, asker: Asker, unit: DoorUnit, request: Request) -> Transaction:
        halves = asker.halves.setdefault(unit, {})
        return unit_transaction(request, unit.registers, halves, lambda: self._identity(unit))

    async def _awaited(self, asker: Asker, unit: DoorUnit, request: Request) -> bytes:
        steps = self._steps(asker, unit, request)
        try:
            step = next(steps)
            while True:
                if step is LOOK:
                    step = steps.send(self._look(asker, unit))
                    continue
                try:
                    await self._carry_out(asker, unit, step)
                except VerbRefused as refusal:
                    step = steps.throw(refusal)
                else:
                    step = next(steps)
        except StopIteration as done:
            pdu: bytes = done.value
            return pdu
        except (Refused, VerbRefused) as error:
            return self._refuse(asker, unit.number, request.function, error, unit.registers.manners)

    def _refuse(
        self,
        asker: Asker,
        number: int,
        function: int,
        error: Refused | VerbRefused,
        manners: Manners = USUAL,
    ) -> bytes:
        code, why = code_and_reason(error, manners)
        self.exceptions[f"{code:02}"] += 1
        self._tell(code, f"bridges.modbus: {asker.source.name}: unit {number}: exception {code:02}: {why}")
        return exception(function, code)

    def _look(self, asker: Asker, unit: DoorUnit) -> AxisLook:
        look: AxisLook = self._desk.ask(asker.source, "look", unit.info.name, {})
        return look

    async def _carry_out(self, asker: Asker, unit: DoorUnit, wanted: Wanted) -> None:
        result = self._desk.ask(asker.source, wanted.operation, unit.info.name, wanted.given)
        if isawaitable(result):
            result = await result
        self.carried_out += 1
        self._ends.follow(unit, wanted, asker.source, result)

    def _tell(self, code: int, why: str) -> None:
        if (limit := self._limits.get(code)) is None:
            limit = self._limits[code] = Limit(log.info, asyncio.get_running_loop())
        limit.reached(why)

    async def close(self) -> None:
        for limit in self._limits.values():
            limit.close()
        await self._ends.close()


def _no_operation(wanted: Wanted) -> None:
    raise AssertionError(f"a reading asks for {wanted}")
