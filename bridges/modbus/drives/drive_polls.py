"""Polls of a real drive: how it is read while it is there, and how it is looked for while it is not."""

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable
from contextlib import suppress

from bridges.modbus.drives.modbus_client import Excepted, ModbusClient
from bridges.modbus.drives.poll_plan import GAP_REGISTERS, Words
from bridges.modbus.drives.register_drive import RegisterDrive
from bridges.modbus.protocol.pdu import Span, Table
from hil.drives.drive_link import ASKING, IN_TURN, LOST_AFTER, Garbled, Reading
from hil.drives.real_drive import FOUND_S

SETTINGS_S = 1.0
"""Interval of reads of the parameters."""
_NO_SUCH_REGISTERS = (1, 2, 3)
"""Exceptions of a drive that has not all of the registers of a request."""
_WAYS = ((GAP_REGISTERS, True), (0, True), (GAP_REGISTERS, False), (0, False))
"""Ways to read a drive, tried in order: the most registers in a gap, and whether what is written to it can be
read."""

log = logging.getLogger("hil")


class DrivePolls:
    """Polls of one drive."""

    def __init__(self, drive: RegisterDrive) -> None:
        self._drive, self._link = drive, drive.link
        self._settings_due_s = 0.0
        self._way = _WAYS[0]
        self._refusals = 0

    async def run(self) -> None:
        """Poll forever."""
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while True:
            try:
                await self._once()
                self._refusals = 0
                due_s = max(due_s + self._drive.pace.interval_s, loop.time())
                pause_s = due_s - loop.time()
            except ASKING as error:
                pause_s = self._pause_s(error)
            except Exception as error:  # hil's own error: this drive is not used for a while, the others are
                self._link.refused(f"an error of hil, see its log: {error!r}")
                log.exception("%s: the drive at %s", self._drive.name, self._drive.address)
                pause_s = self._link.waits.take_ns() / 1e9
            await asyncio.sleep(pause_s)

    def _pause_s(self, error: Exception) -> float:
        """Wait after an error. A drive that refuses to be read, some times in a row, is not there."""
        was_there = self._link.is_there
        self._refusals += isinstance(error, Excepted)
        if was_there and self._refusals < LOST_AFTER:
            return self._drive.pace.interval_s
        if isinstance(error, Excepted):
            self._link.refused(str(error))
            self._drive.note(was_there)
        return self._link.waits.take_ns() / 1e9

    async def _once(self) -> None:
        """Wait for its place, and read its state; the first time all that has to be known of it."""
        if self._link.state == "away":
            with suppress(TimeoutError):
                async with asyncio.timeout(FOUND_S):
                    await self._drive.found.wait()
            return
        if not self._link.is_there:
            await self._greet()
            return
        session = self._link.session
        reading = await self._read(session)
        if asyncio.get_running_loop().time() >= self._settings_due_s:
            await self._read_settings(session)
        if self._drive.is_in(session):
            self._drive.note_reading(reading)

    async def _greet(self) -> None:
        """Find the way to read it, and read it."""
        self._drive.holding = {}
        for way in _WAYS:
            self._way = way
            try:
                reading = await self._read(None)
            except Excepted as error:
                if error.code not in _NO_SUCH_REGISTERS or way == _WAYS[-1]:
                    raise
                continue
            await self._read_settings(None)
            self._drive.begin_session()
            self._drive.note_reading(reading)
            return

    async def _read(self, session: int | None) -> Reading:
        gap, has_kept = self._way
        at_ns = self._drive.now_ns()
        words = await self._words(self._drive.plan.state(gap=gap, has_kept=has_kept), session)
        reading = self._drive.plan.reading(at_ns, words)
        if not math.isfinite(reading.values.get("position_deg", 0.0)):
            garbled = Garbled("its position is no number")
            self._link.counters.garbled += 1
            self._link.unanswered(str(garbled))
            raise garbled
        return reading

    async def _words(self, spans: tuple[Span, ...], session: int | None) -> Words:
        words: Words = {}
        for span in spans:
            found = await self._drive.ask(self._reader(span), IN_TURN, session)
            words.setdefault(span.table, {}).update(enumerate(found, span.address))
        return words

    def _reader(self, span: Span) -> Callable[[ModbusClient], Awaitable[list[int]]]:
        async def read(client: ModbusClient) -> list[int]:
            words = list(await client.read(self._drive.unit, self._drive.plan.asked(span)))
            if span.table is Table.HOLDING_REGISTERS:  # here, between the writes before and after
                self._drive.holding |= enumerate(words, span.address)
            return words

        return read

    async def _read_settings(self, session: int | None) -> None:
        """Read the parameters; a drive may refuse some, and tells them not."""
        self._settings_due_s = asyncio.get_running_loop().time() + SETTINGS_S
        if not self._drive.map.parameters:
            return
        for gap in (self._way[0], 0):
            try:
                words = await self._words(self._drive.plan.settings(gap=gap), session)
            except Excepted:
                continue
            told = self._drive.plan.reading(self._drive.now_ns(), words).values
            known = {name: told[name] for name in self._drive.map.parameters if name in told}
            self._drive.settings = known
            return
        self._drive.settings = {}
