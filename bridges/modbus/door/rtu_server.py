"""Modbus RTU on a port: frames told apart by silence, units of one line, broadcasts, diagnosis of the line.

Source: MODBUS over Serial Line, Specification and Implementation Guide V1.02, 2.2, 2.4.1 and 2.5.1.
"""

import asyncio
import logging
from collections import Counter, deque
from collections.abc import Coroutine, Mapping
from functools import partial
from inspect import isawaitable
from typing import Any

from bridges.modbus.door.request_handler import Asker, DoorUnit, DoorUnits, RequestHandler
from bridges.modbus.protocol.diagnostics import Diagnostics, report
from bridges.modbus.protocol.exchange import sole_of_frame
from bridges.modbus.protocol.frame import FRAME_BYTES_MAX, FRAME_BYTES_MIN, TO_ALL, Frame, encode
from bridges.modbus.protocol.pdu import Function, Refused, Request, exception, parse
from hil.net.silence_timer import SilenceTimer
from hil.vocab.desk_protocol import Source
from hil.vocab.ports import EchoPort, EchoStats, Port
from hil.vocab.verbs import Role
from hil.wire.serial_line import silence_ns

log = logging.getLogger("hil")

HALVES_S = 10.0
"""Time after a line's last write, from which on the halves of values that it wrote are forgotten: nobody sees
whether another master is on it."""
FRAMES = 16
"""Maximum number of frames that wait: a master sends the next one when it has the answer."""
_ROOM_BYTES = 4096
_Later = Coroutine[Any, Any, bytes]


class RtuServer:
    """Units on one line, a ``hil.vocab.ports.PortHost``. The silence within a frame (t1.5) is not asked for:
    a pty and an adapter hand over a frame in pieces, whose times are the computer's."""

    def __init__(self, port: Port, baud: int, handler: RequestHandler, units: DoorUnits) -> None:
        self._port, self._handler, self._units = port, handler, units
        if isinstance(port, EchoPort):
            port.tell_sole(lambda data: sole_of_frame(data, _answers_here), in_pieces=False)
        self._silence_ns = silence_ns(baud)
        self._held = bytearray()
        self._frames: deque[tuple[Asker, bytes, float]] = deque()
        self._wrote_s = self._began_s = 0.0
        self._deaf_until_s: dict[int, float] = {}
        """Ends of the pauses behind answers of units whose maps have one."""
        self._diagnoses: dict[int, Diagnostics] = {}
        self._silence: SilenceTimer | None = None
        self._work: asyncio.Task[None] | None = None
        self._seen: Counter[str] = Counter()

    @property
    def address(self) -> str:
        return self._port.address

    @property
    def echo(self) -> EchoStats | None:
        """Echo of the line's adapter; None: it has none."""
        return self._port.stats().echo

    def counters(self) -> Mapping[str, int]:
        return {kind: self._seen[kind] for kind in ("frames", "errors", "answers", "overruns")}

    async def open(self) -> None:
        """Open the port. Raises PortError."""
        self._loop = asyncio.get_running_loop()
        self._source = Source("modbus line", Role.OPERATOR, door="modbus")
        self._asker = Asker(self._source)
        self._silence = SilenceTimer(self._is_silent)
        await self._port.open(self)
        self._source = Source(f"modbus line {self.address}", Role.OPERATOR, door="modbus")
        self._asker = Asker(self._source)

    async def close(self) -> None:
        if self._silence:
            self._silence.close()
            self._silence = None
        self._frames.clear()
        if self._work:
            self._work.cancel()
            await asyncio.gather(self._work, return_exceptions=True)
        await self._port.close()

    def received(self, data: bytes) -> None:
        if not self._held:
            self._began_s = self._loop.time()
        self._held += data[: FRAME_BYTES_MAX + 1 - len(self._held)]
        if self._silence:
            self._silence.start(self._silence_ns)

    def room(self) -> int:
        return _ROOM_BYTES

    def drained(self) -> None:
        """Nothing waits for it."""

    def client_left(self, baud: int | None) -> None:
        """Take what came for a frame: nothing follows it. The next client is another one, to which no answer
        for this one goes."""
        gone, self._asker = self._asker, Asker(self._source)
        self._end_frame(gone)

    def port_failed(self, reason: str) -> None:
        log.error("bridges.modbus: %s: %s", self.address, reason)

    def _is_silent(self) -> None:
        self._end_frame(self._asker)

    def _end_frame(self, asker: Asker) -> None:
        """Take what came since the last silence for a frame."""
        if not (raw := bytes(self._held)):
            return  # the client has left
        self._held.clear()
        is_good = FRAME_BYTES_MIN <= len(raw) <= FRAME_BYTES_MAX and not Frame(0, raw).fault
        self._seen["frames" if is_good else "errors"] += 1
        for unit in self._units.all():
            self._diagnosis(unit).heard(is_good=is_good)
        if not is_good:
            return
        if len(self._frames) >= FRAMES:
            self._seen["overruns"] += 1
            return
        self._frames.append((asker, raw, self._began_s))
        self._serve()

    def _serve(self) -> None:
        """Serve frames that wait, up to one that takes time: a read is answered in this pass of the loop."""
        while self._frames and self._work is None:
            asker, raw, began_s = self._frames.popleft()
            address, pdu = raw[0], raw[1:-2]
            is_to_all = address == TO_ALL
            units = [
                unit
                for unit in self._units.all()
                if (is_to_all or unit.number == address) and began_s >= self._deaf_until_s.get(unit.number, 0)
            ]
            later: list[tuple[Diagnostics, _Later]] = []
            for unit in units:
                answer = self._begin(asker, unit, pdu, is_to_all=is_to_all)
                if isawaitable(answer):
                    later.append((self._diagnosis(unit), answer))
                elif answer is not None:
                    self._write(asker, address, answer)
            if later:
                self._work = self._loop.create_task(self._finish(asker, address, later))
                self._work.add_done_callback(partial(self._finished, later))

    async def _finish(self, asker: Asker, address: int, later: list[tuple[Diagnostics, _Later]]) -> None:
        for diagnosis, each in later:
            answer = await each
            diagnosis.answered(answer, is_to_all=address == TO_ALL)
            self._write(asker, address, answer)

    def _finished(self, later: list[tuple[Diagnostics, _Later]], work: asyncio.Task[None]) -> None:
        for _, each in later:
            each.close()  # if it was never begun
        self._work = None
        self._serve()

    def _write(self, asker: Asker, address: int, answer: bytes) -> None:
        if address != TO_ALL and asker is self._asker:
            self._port.write(encode(address, answer[0], answer[1:]))
            self._seen["answers"] += 1
            pauses = [each.registers.manners.pause_ns for each in self._units.all() if each.number == address]
            if any(pauses):
                self._deaf_until_s[address] = self._loop.time() + pauses[0] / 1e9

    def _begin(self, asker: Asker, unit: DoorUnit, pdu: bytes, *, is_to_all: bool) -> bytes | _Later | None:
        """Carry out a request, of a broadcast what is written; None: it gets no answer."""
        try:
            request: Request | None = parse(pdu, is_serial_line=True)
        except Refused:
            request = None  # the handler answers with the exception
        diagnosis = self._diagnosis(unit)
        if not diagnosis.takes(request):
            return None
        is_done = not is_to_all or (request and (request.write or request.mask))
        answer = self._done(asker, unit, diagnosis, request, pdu) if is_done else None
        if not isawaitable(answer):
            diagnosis.answered(answer, is_to_all=is_to_all)
        return answer

    def _done(
        self, asker: Asker, unit: DoorUnit, diagnosis: Diagnostics, request: Request | None, pdu: bytes
    ) -> bytes | _Later | None:
        functions = unit.registers.manners.functions
        has_it = request and (functions is None or request.function in functions)
        if request and has_it and request.function == Function.DIAGNOSTICS:
            try:
                return diagnosis.answer(request)
            except Refused as error:
                return exception(request.function, error.code)
        if request and has_it and request.function == Function.REPORT_SERVER_ID:
            return report(unit.number, unit.info.profile.encode("ascii", "replace"), is_running=True)
        self._forget_old_halves(asker, request)
        return self._handler.answer_of(asker, unit, pdu)

    def _forget_old_halves(self, asker: Asker, request: Request | None) -> None:
        now_s = self._loop.time()
        if now_s - self._wrote_s > HALVES_S:
            asker.halves.clear()
        if request and (request.write or request.mask):
            self._wrote_s = now_s

    def _diagnosis(self, unit: DoorUnit) -> Diagnostics:
        return self._diagnoses.setdefault(unit.number, Diagnostics())


def _answers_here(unit: int) -> bool:
    """True: what goes out are answers of units at this door, which nobody else gives."""
    return True
