"""Serial line to real TMCL modules: asked one thing at a time. It opens itself, and again when it is lost."""

import asyncio
import logging
import os
from contextlib import suppress
from typing import Any

import serial

from hil.drives.drive_link import Denied, Garbled, NoAnswer, PlaceLost, Waits
from hil.drives.real_drive import RealDrive
from tmcl_bus.drives.tmcl_drive_address import SerialPlace
from tmcl_bus.frames import FRAME_BYTES, Reply, Request, Status, has_right_sum, reply_of
from tmcl_bus.words import reply_words

LATE_S = 0.05
"""Time for a reply that nobody waits for any more to pass by."""

log = logging.getLogger("hil")


class TmclLine:
    """Line at one place. ``timeout_s``: for a reply."""

    def __init__(self, place: SerialPlace, timeout_s: float) -> None:
        self.place, self.timeout_s = place, timeout_s
        self.members: list[RealDrive] = []
        self.is_open, self.why = False, f"{place}: it is not open yet"
        self._port: Any = None
        self._heard = bytearray()
        self._news, self._gone = asyncio.Event(), asyncio.Event()
        self._lock = asyncio.Lock()
        self._is_late = False
        """True if the last reply may still come."""
        self._waits = Waits()
        self._task = asyncio.get_running_loop().create_task(self._run())

    async def close(self) -> None:
        self._task.cancel()
        with suppress(asyncio.CancelledError):
            await self._task
        self._lose(f"{self.place}: the line is closed")

    async def ask(self, request: Request, host: int) -> Reply:
        """Ask a module when its turn comes.

        Raises:
            PlaceLost, NoAnswer, Garbled, Denied: there is no reply, or this one.
        """
        async with self._lock:
            if self._is_late:
                await asyncio.sleep(LATE_S)
            if not self.is_open:
                raise PlaceLost(self.why)
            self._heard.clear()
            self._is_late = True
            self._port.write(request.encode())
            raw = await self._reply()
            self._is_late = False
        reply = reply_of(raw)
        if not has_right_sum(raw) or (reply.host, reply.module) != (host, request.module):
            raise Garbled(f"its reply does not fit: {raw.hex(' ')}")
        if reply.status != Status.OK:
            raise Denied(f"it replied: {reply_words(reply).partition(': ')[2]}")
        if reply.command != request.command:
            raise Garbled(f"its reply is for another command: {raw.hex(' ')}")
        return reply

    async def _reply(self) -> bytes:
        try:
            async with asyncio.timeout(self.timeout_s):
                while len(self._heard) < FRAME_BYTES:
                    if not self.is_open:
                        raise PlaceLost(self.why)
                    self._news.clear()
                    await self._news.wait()
        except TimeoutError:
            raise NoAnswer(f"no reply within {self.timeout_s:g} s") from None
        return bytes(self._heard[:FRAME_BYTES])

    # ---- its port ----

    async def _run(self) -> None:
        while True:
            try:
                await self._open()
            except (OSError, ValueError) as error:  # of pyserial and the system
                self._lose(f"{self.place}: {_reason(error)}")
            else:
                self._waits.reset()
                await self._gone.wait()
            await asyncio.sleep(self._waits.take_ns() / 1e9)

    async def _open(self) -> None:
        loop, path, baud = asyncio.get_running_loop(), self.place.path, self.place.baud
        port = await loop.run_in_executor(
            None, lambda: serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
        )
        self._port = port
        self._gone.clear()
        self.is_open = True
        loop.add_reader(port.fileno(), self._read)
        for member in self.members:
            member.place_found()

    def _read(self) -> None:
        try:
            data = os.read(self._port.fileno(), 4096)
        except BlockingIOError:
            return
        except OSError as error:
            self._lose(f"{self.place}: {_reason(error)}")
            return
        if not data:
            self._lose(f"{self.place}: it was unplugged")
            return
        self._heard += data
        self._news.set()

    def _lose(self, why: str) -> None:
        self.is_open, self.why = False, why
        if port := self._port:
            self._port = None
            asyncio.get_running_loop().remove_reader(port.fileno())
            with suppress(OSError):
                port.close()
        self._gone.set()
        self._news.set()
        for member in self.members:
            member.place_lost(why)


class TmclLines:
    """Lines of a bench by place. One is open while a module is at its place."""

    def __init__(self) -> None:
        self._lines: dict[str, TmclLine] = {}

    def join(self, member: RealDrive, place: SerialPlace, timeout_s: float) -> TmclLine:
        """Give a module its line. The longest of the modules' times for a reply holds for all of them."""
        line = self._lines.get(place.where)
        if line is None or line.place != place:
            line = self._lines[place.where] = TmclLine(place, timeout_s)
        line.timeout_s = max(line.timeout_s, timeout_s)
        line.members.append(member)
        if line.is_open:
            member.place_found()
        return line

    async def leave(self, member: RealDrive, line: TmclLine) -> None:
        """Take a module off its line; the last one closes it."""
        if member in line.members:
            line.members.remove(member)
        if not line.members:
            if self._lines.get(line.place.where) is line:
                del self._lines[line.place.where]
            await line.close()


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    return os.strerror(number) if number else str(error)
