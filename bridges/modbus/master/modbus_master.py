"""Master of a line of Modbus RTU without I/O: polls of units in a cycle, and requests in between.

It takes its turns as ``NodeMaster`` does (``hil.master.sans_io.line_turns``): one request at a time, no write
twice, no answer believed that belongs to another request.

Source: MODBUS over Serial Line V1.02, 2.4 and 2.5.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from bridges.modbus.protocol import pdu
from bridges.modbus.protocol._crc16 import crc16
from bridges.modbus.protocol.client_side import Answer, AnswerError, encode, parse_answer
from bridges.modbus.protocol.frame import ADDRESSES, FRAME_BYTES_MAX, TO_ALL
from bridges.modbus.protocol.pdu import Refused, Request
from hil.master.sans_io.line_turns import LineTiming, LineTurns
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.vocab.line_format import LineFormat
from hil.vocab.time import NS_PER_MS
from hil.wire.serial_line import silence_ns

EXCEPTION_BYTES = 5
"""Address, function, code, CRC: the shortest answer."""
TURNAROUND_NS = 100 * NS_PER_MS
"""Time that units need behind a broadcast (2.4.1: 100 to 200 ms)."""
RESPONSE_NS = 200 * NS_PER_MS
TRIES = 2
_ADDRESS_AND_CRC_BYTES = 3
Ended = Callable[[Transaction], None]


@dataclass
class UnitPoll:
    """Poll of a unit: what is read, and what the last answer said. Times are the master's."""

    unit: int
    request: Request
    answer: Answer | None = None
    """Last answer."""
    at_ns: int | None = None
    """Time of the last answer."""
    polls: int = 0
    missed: int = 0
    """Polls without an answer, or with an exception, since the last answer."""
    why: str = ""
    """Reason why the last poll has no answer."""


class ModbusMaster:
    """Master of one line of Modbus RTU. Times are nanoseconds of one clock.

    ``polls`` are done one after the other, in a cycle that begins every ``interval_ns`` at most; 0: at once
    again. ``response_ns``: maximum time that a unit needs for an answer; ``latency_ns``: maximum delay of
    what lies between this program and the line, there and back.

    Long because polls and requests in between share one line and its silences.
    """

    def __init__(
        self,
        polls: Sequence[UnitPoll] = (),
        *,
        baud: int,
        line_format: LineFormat,
        interval_ns: int = 0,
        response_ns: int = RESPONSE_NS,
        latency_ns: int = 0,
        tries: int = TRIES,
        polled: Callable[[UnitPoll], None] = lambda poll: None,
    ) -> None:
        quiet_ns = silence_ns(baud, line_format.bits)
        self.polls = tuple(polls)
        self.cycles = 0
        """Number of cycles that have ended."""
        self.cycle_ns: int | None = None
        """Time that the last cycle took."""
        for each in self.polls:
            self._transaction(each.unit, each.request, 1)
        self._response_ns, self._latency_ns, self._tries = response_ns, latency_ns, tries
        self._interval_ns, self._polled = interval_ns, polled
        self._turns = LineTurns(
            LineTiming(
                baud,
                line_format.bits,
                latency_ns + response_ns,
                quiet_ns,
                quiet_ns,
                FRAME_BYTES_MAX,
                EXCEPTION_BYTES,
                TURNAROUND_NS,
            )
        )
        self._requests: dict[Transaction, Request] = {}
        self._heard = b""
        self._place = 0
        self._begun_ns: int | None = None
        self._cycle_due_ns = 0
        self._is_polling: Transaction | None = None

    # ---- what is asked for ----

    def ask(
        self,
        unit: int,
        request: Request,
        at_ns: int,
        *,
        may_repeat: bool | None = None,
        is_urgent: bool = False,
        ended: Ended | None = None,
    ) -> Transaction:
        """Send a request behind the poll that has its turn, before all others. Its ``answer`` is an
        ``Answer`` when it is done.

        ``may_repeat``: whether twice is as good as once; None: of a read it is, of a write it is not.

        Raises:
            ValueError: no unit has this address, or a server would refuse the request by its form alone.
        """
        made = self._transaction(unit, request, self._tries)
        made.rest_ns = self._response_ns + self._latency_ns
        made.is_urgent = is_urgent
        if may_repeat is not None:
            made.may_repeat = may_repeat
        self._add(made, request, at_ns, ended)
        self.advance(at_ns)
        return made

    def _add(self, made: Transaction, request: Request, at_ns: int, ended: Ended | None) -> None:
        def over(sent: Transaction) -> None:
            self._requests.pop(sent, None)
            if ended:
                ended(sent)

        made.ended = over
        self._requests[made] = request
        self._turns.add(made, at_ns)

    def lose(self, at_ns: int, why: str) -> None:
        """Note that the port has gone."""
        self._turns.lose(at_ns, why)

    @property
    def outstanding(self) -> list[Transaction]:
        """Those that are not over, polls too."""
        return [*self._turns.under_way(), *self._turns.waiting]

    @property
    def is_idle(self) -> bool:
        """True if nothing is under way or waits, but the next poll."""
        return self._turns.is_idle

    def _transaction(self, unit: int, request: Request, tries: int) -> Transaction:
        if unit != TO_ALL and unit not in ADDRESSES:
            raise ValueError(f"unit {unit}: write 1 to 247, or 0 for all")
        body = bytes((unit,)) + encode(request)
        is_write = request.write is not None or request.mask is not None
        if unit == TO_ALL and (not is_write or request.read is not None):
            raise ValueError(f"function {request.function} to all: a broadcast only writes")
        frame = body + crc16(body).to_bytes(2, "little")
        return Transaction(unit, body[1:], frame, self._answer_bytes(unit, request), not is_write, tries)

    @staticmethod
    def _answer_bytes(unit: int, request: Request) -> int:
        if unit == TO_ALL:
            return 0
        if request.read is None and request.write is None and request.mask is None:
            return FRAME_BYTES_MAX
        values = (0,) * request.read.count if request.read else ()
        return len(pdu.answer(request, values)) + _ADDRESS_AND_CRC_BYTES

    # ---- bytes and time ----

    def receive(self, data: bytes, at_ns: int) -> None:
        """Take bytes of the line, the last of which came at ``at_ns``."""
        if not data:
            return
        self._heard = (self._heard + data)[-2 * FRAME_BYTES_MAX :]
        taken = self._answered(at_ns)
        self._turns.heard(at_ns, taken)
        self.advance(at_ns)

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""
        due_ns = self._turns.due_ns()
        if self.polls and not self._turns.is_lost and not self._is_polling and not self._turns.waiting:
            due_ns = min(due_ns, self._cycle_due_ns)
        return due_ns

    def advance(self, now_ns: int) -> None:
        """Do what is due: time-outs, the next request, or the next poll."""
        self._turns.advance(now_ns)
        if self.polls and not self._turns.is_lost and not self._is_polling and not self._turns.waiting:
            self._poll(now_ns)

    def to_send(self) -> bytes:
        """Bytes that go out now."""
        out = self._turns.to_send()
        if out:
            self._heard = b""
        return out

    # ---- polls ----

    def _poll(self, now_ns: int) -> None:
        if now_ns < self._cycle_due_ns:
            return
        poll = self.polls[self._place]
        if self._place == 0:
            if self._begun_ns is not None:
                self.cycle_ns = now_ns - self._begun_ns
            self._begun_ns = now_ns
        made = self._transaction(poll.unit, poll.request, 1)
        made.rest_ns = self._latency_ns
        self._is_polling = made
        self._add(made, poll.request, now_ns, lambda sent: self._poll_ended(poll, sent))
        self._turns.advance(now_ns)

    def _poll_ended(self, poll: UnitPoll, sent: Transaction) -> None:
        self._is_polling = None
        poll.polls += 1
        if sent.outcome in (Outcome.DONE, Outcome.SENT):
            poll.answer, poll.at_ns, poll.missed, poll.why = sent.answer, sent.ended_ns, 0, ""
        else:
            poll.missed, poll.why = poll.missed + 1, sent.why
        self._place = (self._place + 1) % len(self.polls)
        if self._place == 0:
            self.cycles += 1
            self._cycle_due_ns = (self._begun_ns or 0) + self._interval_ns
        self._polled(poll)

    # ---- answers ----

    def _answered(self, at_ns: int) -> bool:
        """Find the answer to something that is under way in what was heard; answers whether there is one."""
        for sent in self._turns.under_way():
            request = self._requests.get(sent)
            if request is None or not sent.answer_bytes:
                continue
            for size in dict.fromkeys((EXCEPTION_BYTES, *_sizes(sent, len(self._heard)))):
                raw = self._heard[-size:]
                if len(raw) < size or raw[0] != sent.unit or crc16(raw):
                    continue
                if self._take(sent, request, raw[1:-2], at_ns):
                    self._heard = b""
                    return True
        return False

    def _take(self, sent: Transaction, request: Request, body: bytes, at_ns: int) -> bool:
        answer: Answer | None = None
        try:
            answer = parse_answer(request, body)
        except Refused as error:
            sent.refusal = str(error)
            sent.tries = sent.sent  # an exception says so again
        except AnswerError:
            return False
        self._turns.answered(sent.unit, answer is not None, at_ns, answer)
        return True


def _sizes(sent: Transaction, heard: int) -> Sequence[int]:
    """Lengths that an answer may have, of so many bytes that were heard."""
    if sent.answer_bytes < FRAME_BYTES_MAX:
        return (sent.answer_bytes,)
    return range(EXCEPTION_BYTES, heard + 1)
