"""Real Modbus drive: what is written to its registers, and what they tell."""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from bridges.modbus.drives.control_bits import RegisterWrite, bits_write, value_write
from bridges.modbus.drives.drive_line import DriveLine
from bridges.modbus.drives.modbus_client import Excepted, ModbusClient
from bridges.modbus.drives.modbus_drive_address import ModbusDriveAddress
from bridges.modbus.drives.poll_plan import PollPlan
from bridges.modbus.protocol.pdu import Span, Table
from bridges.modbus.registers.drive_map import DriveMap
from hil.drives.drive_fields import (
    FOLLOW_RPM,
    FOLLOW_RPM_PER_S,
    MOST_RPM,
    MOST_RPM_PER_S,
    common_verbs,
    drive_fields,
    drive_verb,
)
from hil.drives.drive_link import IN_TURN, Garbled, NoAnswer, PlaceLost, Reading
from hil.drives.real_drive import DrivePace, RealDrive, SentSetPoint
from hil.vocab.axis import TURNS_RPM
from hil.vocab.parameters import Parameter
from hil.vocab.ports import EchoStats
from hil.vocab.verbs import Verb


def map_verbs(of: DriveMap) -> dict[str, Verb]:
    """Verbs of a drive with this map, by name."""
    verbs = common_verbs(
        _ramps(of), "end all motion by the drive's own ramp, or where it is if it has no such bit"
    )
    if of.version > 1 and not _has_reset(of):
        pass
    elif "reset" in of.control or of.version > 1:
        verbs.append(drive_verb("clear_fault", "clear the drive's fault"))
        verbs.append(drive_verb("reset", "the same: the power of a real drive stays on"))
    if {"set_velocity_rpm", "run_velocity_rpm"} & of.values.keys() and of.version > 1:
        about = "turn at a speed until a stop; left out: as the drive has it"
        speed = Parameter("velocity_rpm", "speed", "rpm", -MOST_RPM, MOST_RPM, is_optional=True)
        own = [each for each in _ramps(of) if each.name == "acceleration_rpm_per_s"]
        verbs.append(drive_verb("run", about, speed, *own))
    return {verb.name: verb for verb in verbs}


def _has_reset(of: DriveMap) -> bool:
    """True if the fault can be cleared: by a bit, by a value, or by the control word of CiA 402."""
    commands = [part for _, part in of.parts.commands.values()]
    by_value = any("reset" in words for part in commands for words in part.words.values())
    return by_value or "reset" in of.control or any(part.standard for part in commands)


def _ramps(of: DriveMap) -> tuple[Parameter, ...]:
    """Parameters of the ramps of a move: those that the drive has registers for, or that the daemon makes."""
    is_ours = "start" not in of.control and of.version == 1
    moves = {name for name in of.parts.moves.names}
    rows: list[tuple[str, str, str, str, float, float]] = [
        ("velocity_rpm", "set_velocity_rpm", "largest speed on the way", "rpm", MOST_RPM, FOLLOW_RPM),
        (
            "acceleration_rpm_per_s",
            "acceleration_rpm_per_s",
            "of both ramps",
            "rpm/s",
            MOST_RPM_PER_S,
            FOLLOW_RPM_PER_S,
        ),
    ]
    found = []
    for name, register, about, unit, most, default in rows:
        if is_ours:
            found.append(Parameter(name, about, unit, 0.01, most, default))
        elif register in of.values or register in moves:
            kept = f"{about}; left out: as the drive has it"
            found.append(Parameter(name, kept, unit, 0.01, most, is_optional=True))
    return tuple(found)


TRIES = 2
"""Number of times that a write is sent, if it is not answered; a set-point of a stream is sent once."""

Answer = TypeVar("Answer")


@dataclass(frozen=True)
class RegisterSpec:
    """Configuration of a real Modbus drive."""

    name: str
    address: ModbusDriveAddress
    map: DriveMap
    pace: DrivePace


async def _with_settings(client: ModbusClient, unit: int, write: RegisterWrite) -> RegisterWrite:
    """Complete a write of some bits of a register with those that stay as the drive has them. Raises as
    ``ModbusClient.read``."""
    if not write.keeps:
        return write
    (known,) = await client.read(unit, Span(write.table, write.address, 1))
    return replace(write, words=(write.words[0] | known & write.keeps,), keeps=0)


def _told_names(values: Iterable[str]) -> set[str]:
    """Names of what a drive tells: of a speed without a sign, that with one, too."""
    names = set(values)
    return {*names, "velocity_rpm"} if "speed_rpm" in names else names


def _turns(of: DriveMap, reading: Reading | None) -> bool:
    """True if a drive of version 2 turns: it is on, whatever it was told."""
    velocity_rpm = reading.values.get("velocity_rpm", 0.0) if reading else 0.0
    return of.version > 1 and abs(velocity_rpm) > TURNS_RPM


class RegisterDrive(RealDrive):
    """Drive whose registers a map says."""

    def __init__(self, spec: RegisterSpec, now_ns: Callable[[], int]) -> None:
        super().__init__(spec.name, spec.address, spec.pace, now_ns)
        self.unit, self.place, self.map = spec.address.unit, spec.address.place, spec.map
        self.plan = PollPlan.of_map(spec.map)
        values, told = spec.map.values, _told_names(spec.map.values)
        self.fields = drive_fields(told, spec.map.parameters, has_position="position_deg" in values)
        self.verbs = map_verbs(spec.map)
        self.holding: dict[int, int] = {}
        """Words of the drive's holding registers, as they were read or written last."""
        self._told: dict[str, bool] = {}
        """Control bits as they were written last, in this session."""
        self._sent_words: tuple[int, ...] = ()
        self._line: DriveLine | None = None
        self._task: asyncio.Task[None] | None = None

    @property
    def echo(self) -> EchoStats | None:
        return self._line.echo if self._line else None

    # ---- begin and end ----

    def start(self, join: Callable[["RegisterDrive"], DriveLine], polls: Coroutine[Any, Any, None]) -> None:
        """Begin to ask it, on the line that ``join`` gives. ``polls``: what polls it forever."""
        self._line = join(self)
        self._line.extend_pause(self.map.parts.manners.pause_ns / 1e9)
        self._task = asyncio.get_running_loop().create_task(polls)

    async def close(self, leave: Callable[["RegisterDrive", DriveLine], Awaitable[None]]) -> None:
        """End, and leave the line."""
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        line, self._line = self._line, None
        if line:
            await leave(self, line)
        self.link.place_lost("it is not asked any more")

    # ---- what is asked ----

    async def ask(
        self,
        ask: Callable[[ModbusClient], Awaitable[Answer]],
        order: int = IN_TURN,
        session: int | None = None,
    ) -> Answer:
        """Ask it something. ``session``: the one in which it is wanted; None: any. Raises ``ASKING``."""
        if self._line is None:
            raise PlaceLost("it is not asked any more")
        loop, was_there, counters = asyncio.get_running_loop(), self.link.is_there, self.link.counters

        async def timed(client: ModbusClient) -> Answer:
            begun_s = loop.time()
            try:
                answer = await ask(client)
            except Excepted:
                self.link.answered(round(loop.time() * 1e9), round((loop.time() - begun_s) * 1e9))
                raise
            self.link.answered(round(loop.time() * 1e9), round((loop.time() - begun_s) * 1e9))
            return answer

        try:
            return await self._line.ask(timed, order, lambda: session is None or self.is_in(session))
        except NoAnswer as error:
            counters.time_outs += 1
            self.link.unanswered(str(error))
            raise
        except Garbled as error:
            counters.garbled += 1
            self.link.unanswered(str(error))
            raise
        except Excepted:
            counters.exceptions += 1
            raise
        finally:
            if was_there:
                self.note(was_there)

    @property
    def has_angle(self) -> bool:
        return self.map.has_angle

    def cell(self, name: str) -> float:
        """Value of a cell of the map, as it was read last, or else as the map has it at first."""
        if self.reading and (told := self.reading.values.get(f"cells.{name}")) is not None:
            return told
        return self.map.parts.cells[name][1].default if name in self.map.parts.cells else 1.0

    @property
    def tells_enabled(self) -> bool:
        """True if its map has where it tells that its loop is on."""
        return "status.enabled" in (self.reading.bits if self.reading else {})

    def note_told(self, **bits: bool) -> None:
        """Note what it was told by commands."""
        self._told |= bits

    async def write_all(self, writes: tuple[RegisterWrite, ...], session: int, order: int = IN_TURN) -> None:
        """Write one after the other, once each: a command that is sent twice may be two. Raises
        ``ASKING``."""
        await self._write(lambda client: self._written(client, writes), order, session, 1)

    async def write_value(
        self, name: str, value: float, session: int, order: int = IN_TURN, tries: int = TRIES
    ) -> None:
        """Write a value of the map, or a parameter. Raises ``ASKING``; ValueError: it cannot be held."""
        place = self.map.values.get(name) or self.map.parameters[name]
        write = value_write(self.map, place, value)
        await self._write(lambda client: self._written(client, (write,)), order, session, tries)
        if name == "set_point_deg":
            self.sent, self._sent_words = SentSetPoint(value, self.now_ns()), write.words
        if name in self.map.parameters:
            self.settings = {**self.settings, name: place.value(write.words, is_low_first=self._low_first)}

    async def write_bits(self, session: int, order: int = IN_TURN, **bits: bool) -> None:
        """Switch control bits, those that the map has; beside them stays what is there then. Raises
        ``ASKING``."""
        if any(name in self.map.control for name in bits):

            async def switch(client: ModbusClient) -> None:
                await self._written(client, bits_write(self.map, bits, self.holding))

            await self._write(switch, order, session, TRIES)
            self._told |= bits

    async def _write(
        self, write: Callable[[ModbusClient], Awaitable[None]], order: int, session: int, tries: int
    ) -> None:
        """Write what may be written twice."""
        for left in reversed(range(tries)):
            try:
                return await self.ask(write, order, session)
            except (NoAnswer, Garbled):
                if not left:
                    raise

    async def _written(self, client: ModbusClient, writes: tuple[RegisterWrite, ...]) -> None:
        for given in writes:
            write = await _with_settings(client, self.unit, given)
            await client.write(self.unit, write, self.map.parts.manners.functions)
            self.link.counters.writes += 1
            if write.table is Table.HOLDING_REGISTERS:
                self.holding |= {write.address + at: word for at, word in enumerate(write.words)}

    @property
    def _low_first(self) -> bool:
        return self.map.is_low_first

    def begin_session(self) -> None:
        """Begin a session: what was told in the one before counts no more."""
        self.sent, self._told = None, {}
        self.link.greeted()
        self.note(False)

    # ---- what it tells ----

    @property
    def follows_paths(self) -> bool:
        return "follow" in self.map.control

    @property
    def step_deg(self) -> float:
        place = self.map.values.get("position_deg")
        if place is None:
            return 0.0
        if (of := place.resolved(self.cell).conversion) is None:
            return abs(place.scale)
        return abs(of.value(place.scale) - of.value(0.0))

    @property
    def is_on(self) -> bool:
        """True if its loop is on, by what it tells, or else by what it was told, or because it turns."""
        bits = self.reading.bits if self.reading else {}
        told = bits.get("control.enable", self._told.get("enable", False)) or _turns(self.map, self.reading)
        return bits.get("status.enabled", told)

    @property
    def fault(self) -> str | None:
        if self.reading is None:
            return None
        code = self.reading.values.get("fault_code", 0)
        if self.reading.bits.get("status.fault", bool(code)):
            return f"the drive has fault {code:g}" if code else "the drive has a fault"
        return None

    @property
    def commanded_deg(self) -> float | None:
        told = self.reading.values.get("set_point_deg") if self.reading else None
        if self.sent is None:
            return self.position_deg if told is None and self.map.version > 1 else told
        if told is None or self.reading is None or self.reading.at_ns <= self.sent.at_ns:
            return self.sent.deg
        place = self.map.values.get("set_point_deg")
        if place is None or not self._sent_words:
            return self.sent.deg
        is_same = told == place.value(self._sent_words, is_low_first=self._low_first)
        return self.sent.deg if is_same else told
