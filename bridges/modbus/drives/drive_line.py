"""Line to the drives at one place, which share one client: asked one thing at a time, in order.

The line opens itself, and opens again with growing waits when it is lost. What waits then is refused, never
sent later. A request that has begun is never broken off: its answer would be taken for the next one's.
"""

import asyncio
import heapq
import logging
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from typing import Any, TypeVar

from bridges.modbus.drives.modbus_client import Excepted, ModbusClient
from bridges.modbus.drives.modbus_drive_address import RtuPlace, TcpPlace
from hil.drives.drive_link import IN_TURN, LOST_AFTER, Garbled, NoAnswer, PlaceLost, Stale, Waits
from hil.drives.real_drive import RealDrive
from hil.vocab.ports import EchoStats

LATE_S = 0.03
"""Time on a serial line, beside that of an answer, in which a late answer is not taken for the next one."""
LEAST_GAP_S = 0.00175
"""Silence between two messages from 19200 baud on; below, it is 3.5 characters. MODBUS over Serial Line
V1.02, 2.5.1.1."""

log = logging.getLogger("hil")
Answer = TypeVar("Answer")


@dataclass(order=True)
class _Request:
    order: int
    number: int
    ask: Callable[[ModbusClient], Awaitable[Any]] = field(compare=False)
    is_wanted: Callable[[], bool] = field(compare=False)
    answer: "asyncio.Future[Any]" = field(compare=False)


class DriveLine:
    """Line to one place. ``timeout_s``: for an answer."""

    def __init__(self, place: TcpPlace | RtuPlace, timeout_s: float) -> None:
        self.place = place
        self.timeout_s = timeout_s
        self.members: list[RealDrive] = []
        self.is_open = False
        self.why = f"{place}: it is not open yet"
        """Reason why it is not open."""
        self._wake = asyncio.Event()
        self._client = ModbusClient(place, timeout_s, self._wake.set)
        self._waiting: list[_Request] = []
        self._numbers = count()
        self._waits = Waits()
        self._unanswered = 0
        self._is_closed = False
        self._gap_s = 0.0
        if isinstance(place, RtuPlace):
            self._gap_s = self._client.pause_s = max(3.5 * place.character_bits / place.baud, LEAST_GAP_S)
        self._task = asyncio.get_running_loop().create_task(self._run())

    @property
    def echo(self) -> EchoStats | None:
        """Echo of the line's adapter; None: it is no serial line."""
        return self._client.echo

    def extend_pause(self, pause_s: float) -> None:
        """Leave at least so much silence behind an answer from now on."""
        self._gap_s = self._client.pause_s = max(self._gap_s, pause_s)

    def extend_timeout(self, timeout_s: float) -> None:
        """Wait at least so long for answers from now on."""
        self.timeout_s = max(self.timeout_s, timeout_s)
        self._client.wait_for(self.timeout_s)

    async def close(self) -> None:
        """Close the line: what waits is refused."""
        self._is_closed = True  # pymodbus waits in a way that can lose a cancellation (bpo-37658)
        self._task.cancel()
        with suppress(asyncio.CancelledError):
            await self._task
        self._client.close()
        self._lost(f"{self.place}: the line is closed")

    async def ask(
        self,
        ask: Callable[[ModbusClient], Awaitable[Answer]],
        order: int = IN_TURN,
        is_wanted: Callable[[], bool] = lambda: True,
    ) -> Answer:
        """Ask something when its turn comes, if it is still wanted then.

        Raises:
            PlaceLost, NoAnswer, Garbled, Excepted: there is no answer, or this one.
            Stale: it was not asked.
        """
        if not self.is_open:
            raise PlaceLost(self.why)
        answer: asyncio.Future[Answer] = asyncio.get_running_loop().create_future()
        heapq.heappush(self._waiting, _Request(order, next(self._numbers), ask, is_wanted, answer))
        self._wake.set()
        return await answer

    async def _run(self) -> None:
        while not self._is_closed:
            try:
                await self._client.open()
                self._unanswered, self.is_open = 0, True
                for member in self.members:
                    member.place_found()
                why = await self._serve()
            except PlaceLost as error:
                why = str(error)
            except (
                Exception
            ) as error:  # hil's own error: this line stands still for a while, the others go on
                why = f"{self.place}: an error of hil, see its log: {error!r}"
                log.exception("the line to %s", self.place)
            self._client.close()
            self._lost(why)
            if not self._is_closed:
                await asyncio.sleep(self._waits.take_ns() / 1e9)

    def _lost(self, why: str) -> None:
        self.is_open, self.why = False, why
        waiting, self._waiting = self._waiting, []
        for request in waiting:
            if not request.answer.done():
                request.answer.set_exception(PlaceLost(why))
        for member in self.members:
            member.place_lost(why)

    async def _serve(self) -> str:
        """Send the requests in order until the connection is lost; answers why it was lost."""
        while self._client.is_open and not self._is_closed:
            if not self._waiting:
                self._wake.clear()
                await self._wake.wait()
                continue
            request = heapq.heappop(self._waiting)
            if request.answer.done():
                continue  # whoever asked has gone
            if not request.is_wanted():
                request.answer.set_exception(Stale("the drive was lost before it could be asked"))
                continue
            await self._carry_out(request)
            most = LOST_AFTER * max(len(self.members), 1)
            if isinstance(self.place, TcpPlace) and self._unanswered >= most:
                return f"{self.place}: {self._unanswered} requests in a row were not answered"
        return f"{self.place}: the connection was closed"

    async def _carry_out(self, request: _Request) -> None:
        pause_s = self._gap_s
        try:
            answer: Any = await request.ask(self._client)
        except asyncio.CancelledError:
            _refuse(request, PlaceLost(f"{self.place}: the line is closed"))
            raise
        except (NoAnswer, Garbled) as error:
            self._unanswered += 1
            pause_s = self._gap_s and self._gap_s + LATE_S
            _refuse(request, error)
        except Excepted as error:
            self._answered()
            _refuse(request, error)
        except Exception as error:
            _refuse(request, error)
        else:
            self._answered()
            if not request.answer.done():
                request.answer.set_result(answer)
        if pause_s:
            await asyncio.sleep(pause_s)

    def _answered(self) -> None:
        self._unanswered = 0
        self._waits.reset()


def _refuse(request: _Request, error: Exception) -> None:
    if not request.answer.done():
        request.answer.set_exception(error)
