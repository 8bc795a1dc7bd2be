"""Real Modbus drive: its link, what is written to it, and what it has told."""

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, TypeVar

from hil.drives.control_bits import RegisterWrite, bits_write, value_write
from hil.drives.drive_fields import drive_fields
from hil.drives.drive_link import DriveLink
from hil.drives.drive_verbs import drive_verbs
from hil.drives.poll_plan import PollPlan, Reading
from hil.live.drives.drive_line import IN_TURN, DriveLine, Stale
from hil.live.drives.modbus_client import Excepted, Garbled, ModbusClient, NoAnswer, PlaceLost
from hil.registers.drive_map import DriveMap
from hil.wire.drive_address import DriveAddress
from hil.wire.modbus.pdu import Table

ASKING = (PlaceLost, NoAnswer, Garbled, Excepted, Stale)
"""Errors of a request."""
TRIES = 2
"""Number of times that a write is sent, if it is not answered; a set-point of a stream is sent once."""

log = logging.getLogger("hil")
Answer = TypeVar("Answer")


@dataclass(frozen=True)
class DriveSpec:
    """What a configuration says of a real drive."""

    name: str
    address: DriveAddress
    map: DriveMap
    interval_s: float
    """Interval of polls."""
    timeout_s: float
    """Time for an answer."""
    setpoint_s: float
    """Interval of set-points."""


@dataclass
class SentSetPoint:
    """Set-point that the drive confirmed last, at ``at_ns`` of simulated time."""

    deg: float
    at_ns: int
    words: tuple[int, ...] = field(default=())


class RealDrive:
    """Drive of a bench. ``now_ns``: simulated time, which goes as fast as the wall's; ``listeners``: called
    with each reading."""

    def __init__(self, spec: DriveSpec, now_ns: Callable[[], int]) -> None:
        self.spec = spec
        self.name, self.map = spec.name, spec.map
        self.now_ns = now_ns
        self.link = DriveLink()
        self.plan = PollPlan.of_map(spec.map)
        self.fields, self.verbs = drive_fields(spec.map), drive_verbs(spec.map)
        self.reading: Reading | None = None
        """Last reading, also of a session that has ended."""
        self.sent: SentSetPoint | None = None
        """Last set-point of this session."""
        self.listeners: list[Callable[[Reading], None]] = []
        self._settings: Mapping[str, float] = {}
        self.holding: dict[int, int] = {}
        """Words of the drive's holding registers, as they were read or written last."""
        self._told: dict[str, bool] = {}
        """Control bits as they were written last, in this session."""
        self._line: DriveLine | None = None
        self.found = asyncio.Event()
        """Set while its place is there."""
        self._task: asyncio.Task[None] | None = None

    # ---- begin and end ----

    def start(self, join: Callable[["RealDrive"], DriveLine], polls: Coroutine[Any, Any, None]) -> None:
        """Begin to ask it, on the line that ``join`` gives. ``polls``: what polls it for ever."""
        self._line = join(self)
        self._task = asyncio.get_running_loop().create_task(polls)

    async def close(self, leave: Callable[["RealDrive", DriveLine], Awaitable[None]]) -> None:
        """End, and leave the line."""
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        line, self._line = self._line, None
        if line:
            await leave(self, line)
        self.link.place_lost("it is not asked any more")

    # ---- its line ----

    def place_found(self) -> None:
        self.link.place_found()
        self.found.set()

    def place_lost(self, why: str) -> None:
        was_there = self.link.is_there
        self.link.place_lost(why)
        self.found.clear()
        self.note(was_there)

    def note(self, was_there: bool) -> None:
        """Log that the drive is there, or not any more."""
        if was_there == self.link.is_there:
            return
        if was_there:
            self.sent = None
            log.warning("%s: the drive at %s is lost: %s", self.name, self.spec.address, self.link.why)
        else:
            log.info("%s: the drive at %s is there", self.name, self.spec.address)

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

    def is_in(self, session: int) -> bool:
        """True if this session goes on."""
        return self.link.is_there and self.link.session == session

    async def write_value(
        self, name: str, value: float, session: int, order: int = IN_TURN, tries: int = TRIES
    ) -> None:
        """Write a value of the map, or a parameter. Raises ``ASKING``; ValueError: it cannot be held."""
        place = self.map.values.get(name) or self.map.parameters[name]
        write = value_write(self.map, place, value)
        await self._write(lambda client: self._written(client, (write,)), order, session, tries)
        if name == "set_point_deg":
            self.sent = SentSetPoint(value, self.now_ns(), write.words)
        if name in self.map.parameters:
            self._settings = {**self._settings, name: place.value(write.words, is_low_first=self._low_first)}

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
        for write in writes:
            await client.write(self.spec.address.unit, write)
            self.link.counters.writes += 1
            if write.table is Table.HOLDING_REGISTERS:
                self.holding |= {write.address + at: word for at, word in enumerate(write.words)}

    @property
    def _low_first(self) -> bool:
        return self.map.is_low_first

    def take(self, reading: Reading) -> None:
        """Take a reading over."""
        self.reading = reading
        self.link.counters.polls += 1
        for listener in list(self.listeners):
            listener(reading)

    def take_settings(self, settings: Mapping[str, float]) -> None:
        """Take over what the parameters are."""
        self._settings = settings

    def begin_session(self) -> None:
        """Begin a session: what was told in the one before counts no more."""
        self.sent, self._told = None, {}
        self.link.greeted()
        self.note(False)

    # ---- what it tells ----

    @property
    def is_on(self) -> bool:
        """True if its loop is on, by what it tells, or else by what it was told."""
        bits = self.reading.bits if self.reading else {}
        told = bits.get("control.enable", self._told.get("enable", False))
        return bits.get("status.enabled", told)

    @property
    def fault(self) -> str | None:
        """Its fault in words, or None."""
        if self.reading is None:
            return None
        code = self.reading.values.get("fault_code", 0)
        if self.reading.bits.get("status.fault", bool(code)):
            return f"the drive has fault {code:g}" if code else "the drive has a fault"
        return None

    @property
    def position_deg(self) -> float | None:
        return self.reading.values["position_deg"] if self.reading else None

    @property
    def commanded_deg(self) -> float | None:
        """Set-point: the last that it confirmed, unless it tells another one since."""
        told = self.reading.values.get("set_point_deg") if self.reading else None
        if self.sent is None:
            return told
        if told is None or self.reading is None or self.reading.at_ns <= self.sent.at_ns:
            return self.sent.deg
        place = self.map.values["set_point_deg"]
        is_same = told == place.value(self.sent.words, is_low_first=self._low_first)
        return self.sent.deg if is_same else told

    def values(self) -> dict[str, float]:
        """Values of its fields by name; NaN of what is not told."""
        link, reading = self.link, self.reading
        told: dict[str, float] = dict.fromkeys(self.fields, math.nan)
        counters = vars(link.counters) | {"reconnects": link.counters.reconnects}
        told |= {name: value for name, value in counters.items() if name in told}
        told |= {name: value for name, value in self._settings.items() if name in told}
        told["connected"] = int(link.is_there)
        for part, name in ((0.5, "round_trip_p50_ms"), (0.99, "round_trip_p99_ms")):
            if (trip_ns := link.round_trip_ns(part)) is not None:
                told[name] = trip_ns / 1e6
        told["at_ns"] = 0
        if reading:
            told |= {name: value for name, value in reading.values.items() if name in told}
            told["at_ns"], told["age_ms"] = reading.at_ns, max(self.now_ns() - reading.at_ns, 0) / 1e6
            told["moving"] = int(reading.bits.get("status.moving", False))
            told["enabled"], told["fault"] = int(self.is_on), int(self.fault is not None)
            if (commanded_deg := self.commanded_deg) is not None:
                told["commanded_deg"] = commanded_deg
        return told
