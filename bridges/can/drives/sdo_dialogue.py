"""Dialogue with the SDO server of a real drive: one transfer at a time, begun again if it is not answered."""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from bridges.can.canopen.abort_codes import AbortCode
from bridges.can.canopen.master.sdo_transfer import SdoTransfer, TransferAborted, TransferGarbled
from hil.drives.drive_link import Denied, DriveLink, Garbled, NoAnswer, PlaceLost, Stale

TRIES = 2
"""Number of times that a transfer is begun, if it is not answered."""


class Aborted(Denied):
    """Abort of a transfer by the drive."""

    def __init__(self, sdo: TransferAborted) -> None:
        super().__init__(str(sdo))
        self.sdo = sdo


class SdoDialogue:
    """Dialogue with one server. ``send``: sends a request, and raises PlaceLost; ``unanswered``: told of each
    that was not answered, or wrongly."""

    def __init__(
        self,
        send: Callable[[bytes], None],
        unanswered: Callable[[str], None],
        link: DriveLink,
        timeout_s: float,
    ) -> None:
        self._send, self._unanswered, self._link, self._timeout_s = send, unanswered, link, timeout_s
        self._turn = asyncio.Lock()
        self._transfer: SdoTransfer | None = None
        self._answer: asyncio.Future[bytes] | None = None

    async def carry_out(self, what: SdoTransfer, is_wanted: Callable[[], bool]) -> bytes:
        """Carry out a transfer when its turn comes, if it is still wanted then. Raises ``ASKING``."""
        async with self._turn:
            for left in reversed(range(TRIES)):
                if not is_wanted():
                    raise Stale("the drive was lost before it could be asked")
                try:
                    return await self._tried(what)
                except (NoAnswer, Garbled) as error:
                    self._unanswered(str(error))
                    if not left:
                        raise
        raise AssertionError("the last try answers or raises")

    def hear(self, data: bytes) -> None:
        """Take an answer."""
        answer, transfer = self._answer, self._transfer
        if answer and not answer.done() and transfer and transfer.is_for_this(data):
            answer.set_result(data)

    def place_lost(self, why: str) -> None:
        """Wait for no answer any more."""
        if self._answer and not self._answer.done():
            self._answer.set_exception(PlaceLost(why))

    async def _tried(self, what: SdoTransfer) -> bytes:
        loop, counters = asyncio.get_running_loop(), self._link.counters
        self._transfer, begun_s = what, loop.time()
        request: bytes | None = what.first()
        try:
            while request is not None:
                answer = self._answer = loop.create_future()
                self._send(request)
                async with asyncio.timeout(self._timeout_s):
                    data = await answer
                request = what.hear(data)
        except TimeoutError:
            counters.time_outs += 1
            self._abort(what.abort(AbortCode.TIMED_OUT))
            raise NoAnswer(f"no answer to {what} within {self._timeout_s:g} s") from None
        except TransferGarbled as error:
            counters.garbled += 1
            self._abort(error.abort)
            raise Garbled(str(error)) from None
        except TransferAborted as error:
            counters.exceptions += 1
            self._answered(begun_s)
            raise Aborted(error) from None
        except asyncio.CancelledError:
            self._abort(what.abort(AbortCode.TIMED_OUT))
            raise
        finally:
            self._answer = self._transfer = None
        self._answered(begun_s)
        return what.result

    def _answered(self, begun_s: float) -> None:
        now_s = asyncio.get_running_loop().time()
        self._link.answered(round(now_s * 1e9), round((now_s - begun_s) * 1e9))

    def _abort(self, frame: bytes) -> None:
        with suppress(PlaceLost):
            self._send(frame)
