"""A Modbus node: the interface card of an axis, a station of a segment of its own."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from bridges.modbus.card.register_server import CardAxis, RegisterServer
from bridges.modbus.card.rtu_receiver import RtuReceiver
from bridges.modbus.protocol.diagnostics import Diagnostics, report
from bridges.modbus.protocol.frame import TO_ALL, encode
from bridges.modbus.protocol.pdu import Code, Function, Refused, Request, exception, parse
from hil.sim.firmware_guard import place_of
from hil.sim.flight import flight_of, heard
from hil.vocab.faults import MODBUS_NODE, Fault
from hil.vocab.framing import Item
from hil.vocab.segment import HeardCharacter, Segment
from hil.vocab.time import NS_PER_MS, NS_PER_S, Clock, SimTimeNs
from hil.wire.byte_faults import Chance


class AnswerFaults:
    """Faults in force on a node's answers, the oldest first. Each draws its own chance, for each request."""

    target = MODBUS_NODE

    def __init__(self) -> None:
        self._faults: dict[int, tuple[Fault, Chance]] = {}

    @property
    def numbers(self) -> list[int]:
        """Numbers of the faults, the oldest first."""
        return list(self._faults)

    def begin(self, number: int, fault: Fault) -> None:
        self._faults[number] = fault, Chance(int(fault.number("seed")))

    def end(self, number: int) -> None:
        self._faults.pop(number, None)

    def exception(self) -> int | None:
        """Code of the exception that a request gets instead of being carried out, or None."""
        return self._last("modbus_exception", "code")

    def is_silent(self) -> bool:
        """True if there is no answer."""
        return any(list(self._struck("modbus_no_answer")))

    def late_ns(self) -> int:
        """Delay that the faults add to the answer."""
        late_ms = [fault.number("late_ms") for fault in self._struck("modbus_late")]
        return round(late_ms[-1] * NS_PER_MS) if late_ms else 0

    def unit(self, own: int) -> int:
        """Number of the unit in the answer."""
        unit = self._last("modbus_wrong_unit", "unit")
        if unit is None:
            return own
        return unit or own % 247 + 1

    def _last(self, kind: str, parameter: str) -> int | None:
        values = [int(fault.number(parameter)) for fault in self._struck(kind)]
        return values[-1] if values else None

    def _struck(self, kind: str) -> Iterator[Fault]:
        """Faults of a kind that strike this time. All of them draw."""
        for fault, chance in self._faults.values():
            if fault.kind == kind and chance.below(fault.number("rate")):
                yield fault


Passed = Callable[[str, SimTimeNs, bytes], None]
"""Told of a frame at a node: "board" (to it) or "client" (from it), when it began, and its bytes."""


class ModbusNode:
    """Station ``name`` with a unit's number. It hears frames, acts at exactly the end of each, when the line
    has been silent for 3.5 characters, and answers ``response_ns`` later.

    Its power is the board's: without it nobody answers, and with each power-up the registers start again.
    """

    def __init__(
        self,
        name: str,
        unit: int,
        of: CardAxis,
        segment: Segment,
        clock: Clock,
        *,
        baud: int,
        response_ns: int,
    ) -> None:
        self.name, self.unit, self.wire = name, unit, segment
        self.device = of.device
        self.faults = AnswerFaults()
        self.listeners: list[Callable[[SimTimeNs, bytes], None]] = []
        """Called with each answer, at the time at which its first start bit is on the line."""
        self.watchers: list[Passed] = []
        self._of, self._clock, self._baud, self._response_ns = of, clock, baud, response_ns
        self._receiver = RtuReceiver(clock, baud, segment.line_format, self._frame)
        self._power_up()
        self._seen: Counter[str] = Counter()
        segment.join(name, self)
        segment.set_address(name, unit)

    def counters(self) -> dict[str, Any]:
        """Statistics since the start, for JSON; ``refusal``: reason of the last exception."""
        kinds = ("requests", "answers", "exceptions")
        counts: dict[str, Any] = {kind: self._seen[kind] for kind in kinds}
        return {"unit": self.unit, **counts, "refusal": self._server.refusal or None}

    def _power_up(self) -> None:
        self._ups = self.device.power.ups
        self._server = RegisterServer(self._clock, self._of)
        self._diagnosis = Diagnostics()
        self._has_raised = False
        """True if its registers have raised an error: it is silent until the next power-up."""
        self._deaf_until_ns = 0
        """End of the silence behind its last answer, by its map: what begins before is not heard."""
        self._sent = 0
        """Number of own answers since."""
        self._line = self._line_counts()

    def _line_counts(self) -> tuple[int, int]:
        """Good and bad frames on the line, so far."""
        counters = self.wire.counters(0)
        errors: dict[str, int] = counters["errors"]
        return counters["packets"] - errors.get("CRC", 0), sum(errors.values())

    # ---- hil.vocab.segment.Receiver ----

    @property
    def baud_now(self) -> int:
        return self._baud

    def hear(
        self, start_ns: SimTimeNs, data: bytes, baud: int, packets: Sequence[Item] | None = None
    ) -> None:
        line_format = self.wire.line_format
        if flight := heard(start_ns, data, baud, self._baud, line_format=line_format):
            self._receiver.feed(flight)

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        if characters:
            self._receiver.feed(flight_of(tuple(characters)))

    def retract(self, after_ns: SimTimeNs) -> None:
        self._receiver.retract(after_ns)

    # ---- a frame ----

    def _frame(self, now_ns: SimTimeNs, start_ns: SimTimeNs, raw: bytes) -> None:
        """Act on a frame that began at ``start_ns`` and has ended now."""
        if raw[0] not in (self.unit, TO_ALL) or not self.device.power.is_there:
            return
        if self._ups != self.device.power.ups:
            self._server.close()
            self._power_up()
        if self._has_raised or start_ns < self._deaf_until_ns:
            return
        self._seen["requests"] += 1
        for watcher in self.watchers:
            watcher("board", start_ns, raw)
        try:
            pdu = self._answer(now_ns, raw[1:-2], is_to_all=raw[0] == TO_ALL)
            if pdu is not None and raw[0] != TO_ALL:
                self._send(now_ns, pdu)
        except Exception as error:  # registers may be a board's own: nobody else stops for its mistake
            self._has_raised = True
            self.device.power.fail(f"its Modbus node: {type(error).__name__}: {error}{place_of(error)}")

    def _answer(self, now_ns: SimTimeNs, pdu: bytes, *, is_to_all: bool) -> bytes | None:
        """Carry out a request, of a broadcast what is written; None: it gets no answer."""
        request, refused = None, None
        try:
            request = parse(pdu, is_serial_line=True)
        except Refused as error:
            refused = error
        diagnosis = self._diagnosis
        if not diagnosis.takes(request):
            return None
        if is_to_all and not (request and (request.write or request.mask)):
            diagnosis.answered(None, is_to_all=True)
            return None
        code = self.faults.exception()
        if code is not None:
            answer: bytes | None = bytes((pdu[0] & 0x7F | 0x80, code))
        elif request is None:
            assert refused
            answer = self._server.refuse(pdu[0], refused)
        elif not self._server.has_function(pdu[0]):
            answer = self._server.refuse(pdu[0], Refused(Code.ILLEGAL_FUNCTION, f"no function {pdu[0]}"))
        else:
            answer = self._done(request, now_ns)
        if answer is not None and answer[0] & 0x80:
            self._seen["exceptions"] += 1
        diagnosis.answered(answer, is_to_all=is_to_all)
        return answer

    def _done(self, request: Request, now_ns: SimTimeNs) -> bytes | None:
        if request.function == Function.REPORT_SERVER_ID:
            is_running = self.device.failed is None
            return report(self.unit, self.device.profile.encode("ascii", "replace"), is_running=is_running)
        if request.function != Function.DIAGNOSTICS:
            return self._server.answer(request, now_ns)
        self._count_line()
        try:
            return self._diagnosis.answer(request)
        except Refused as error:
            return exception(request.function, error.code)

    def _count_line(self) -> None:
        """Count what has been on the line since the last time. The card is not told of frames for others;
        the segment counts them once for all, and what it has sent itself it has not heard."""
        good, bad = self._line_counts()
        before, self._line = self._line, (good, bad)
        self._diagnosis.count_line(max(good - before[0] - self._sent, 0), bad - before[1])
        self._sent = 0

    def _send(self, now_ns: SimTimeNs, pdu: bytes) -> None:
        late_ns, unit = self.faults.late_ns(), self.faults.unit(self.unit)
        if self.faults.is_silent():
            return
        late_ns += self.wire.reactions.delay_ns(self.name)
        at_ns = SimTimeNs(now_ns + self._response_ns + late_ns)
        raw = encode(unit, pdu[0], pdu[1:])
        self._seen["answers"] += 1
        self._clock.at(at_ns, lambda now_ns: self._begin(now_ns, raw))

    def _begin(self, now_ns: SimTimeNs, raw: bytes) -> None:
        if not self.device.power.is_there:
            return
        self._sent += 1
        for listener in self.listeners:
            listener(now_ns, raw)
        for watcher in self.watchers:
            watcher("client", now_ns, raw)
        self.wire.transmit(self.name, now_ns, raw, self._baud)
        if pause_ns := self._server.manners.pause_ns:
            character_ns = self.wire.line_format.bits * NS_PER_S // self._baud
            self._deaf_until_ns = now_ns + len(raw) * character_ns + pause_ns
