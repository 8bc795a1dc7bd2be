"""Times of a poll cycle on a line of Modbus RTU: requests, answers and silences, to the nanosecond.

A master sends a request, waits for its answer and for the silence behind it (3.5 characters), and sends the
next. A node acts when the silence behind the request is over, and its answer begins a response time later. A
broadcast has no answer: the master waits for a turnaround time instead (MODBUS over Serial Line V1.02,
2.4.1).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bridges.modbus.protocol import pdu
from bridges.modbus.protocol.client_side import encode, mask_write, read, read_write, write, write_single
from bridges.modbus.protocol.frame import TO_ALL
from bridges.modbus.protocol.pdu import Function, Request, Table
from hil.vocab.line_format import LineFormat
from hil.wire.serial_line import character_ns, gap_ns, silence_ns

_ADDRESS_AND_CRC_BYTES = 3
_HOLDING, _COILS = Table.HOLDING_REGISTERS, Table.COILS
_REQUESTS: dict[int, tuple[int, Callable[[int], Request]]] = {
    Function.READ_COILS: (pdu.READ_BITS_MAX, lambda n: read(_COILS, 0, n)),
    Function.READ_DISCRETE_INPUTS: (pdu.READ_BITS_MAX, lambda n: read(Table.DISCRETE_INPUTS, 0, n)),
    Function.READ_HOLDING_REGISTERS: (pdu.READ_REGISTERS_MAX, lambda n: read(_HOLDING, 0, n)),
    Function.READ_INPUT_REGISTERS: (pdu.READ_REGISTERS_MAX, lambda n: read(Table.INPUT_REGISTERS, 0, n)),
    Function.WRITE_SINGLE_COIL: (1, lambda n: write_single(_COILS, 0, 0)),
    Function.WRITE_SINGLE_REGISTER: (1, lambda n: write_single(_HOLDING, 0, 0)),
    Function.WRITE_MULTIPLE_COILS: (pdu.WRITE_BITS_MAX, lambda n: write(_COILS, 0, (0,) * n)),
    Function.WRITE_MULTIPLE_REGISTERS: (pdu.WRITE_REGISTERS_MAX, lambda n: write(_HOLDING, 0, (0,) * n)),
    Function.MASK_WRITE_REGISTER: (1, lambda n: mask_write(0, 0, 0)),
    Function.READ_WRITE_MULTIPLE_REGISTERS: (
        pdu.READ_WRITE_REGISTERS_MAX,
        lambda n: read_write(0, n, 0, (0,) * n),
    ),
}
FUNCTIONS = tuple(int(function) for function in _REQUESTS)


class Poll(NamedTuple):
    """Poll of a unit (0: a broadcast): the function, and how many bits or registers; of function 23 so many
    are written and read."""

    unit: int
    function: int
    count: int = 1  # type: ignore[assignment]  # the protocol's word; a tuple's own is not missed

    @property
    def problem(self) -> str | None:
        """Reason why there is no such poll, or None."""
        if not 0 <= self.unit <= 247:
            return f"unit {self.unit}: write 1 to 247, or 0 for a broadcast"
        if self.function not in _REQUESTS:
            return f"function {self.function}: write one of {', '.join(map(str, FUNCTIONS))}"
        most = _REQUESTS[self.function][0]
        if not 1 <= self.count <= most:
            return f"count {self.count}: function {self.function} takes 1 to {most}"
        if self.unit == TO_ALL and _request(self).write is None and _request(self).mask is None:
            return f"function {self.function} to all: a broadcast only writes"
        return None

    @property
    def request_bytes(self) -> int:
        return len(encode(_request(self))) + _ADDRESS_AND_CRC_BYTES

    @property
    def answer_bytes(self) -> int:
        """0: it gets no answer."""
        if self.unit == TO_ALL:
            return 0
        request = _request(self)
        values = (0,) * request.read.count if request.read else ()
        return len(pdu.answer(request, values)) + _ADDRESS_AND_CRC_BYTES


def _request(poll: Poll) -> Request:
    return _REQUESTS[poll.function][1](poll.count)


class PollTimes(NamedTuple):
    """Times of one poll, in ns. ``start_ns``: of its request, counted from the cycle's start; ``wait_ns``:
    from the end of the request to the start of the answer, or of a broadcast to the end of the turnaround;
    ``silence_ns``: behind the answer, before the next request."""

    poll: Poll
    start_ns: int
    request_ns: int
    wait_ns: int
    answer_ns: int
    silence_ns: int

    @property
    def end_ns(self) -> int:
        """Time at which the next request may begin."""
        return self.start_ns + self.request_ns + self.wait_ns + self.answer_ns + self.silence_ns


@dataclass(frozen=True)
class PollCycle:
    """Cycle of polls on a line. ``response_ns``: from the end of a request, t3.5 behind its last character,
    to the start of its answer; ``turnaround_ns``: behind a broadcast, t3.5 at least; ``pause_ns``: what the
    master lets pass beside t3.5 before the next request."""

    baud: int
    line_format: LineFormat
    polls: Sequence[Poll]
    response_ns: int
    turnaround_ns: int = 100_000_000
    pause_ns: int = 0

    @property
    def gap_ns(self) -> int:
        """Longest silence within a frame, t1.5."""
        return gap_ns(self.baud, self.line_format.bits)

    @property
    def silence_ns(self) -> int:
        """Shortest silence between frames, t3.5."""
        return silence_ns(self.baud, self.line_format.bits)

    def times(self) -> Iterator[PollTimes]:
        """Times of all polls, in their order."""
        start_ns = 0
        for poll in self.polls:
            request_ns = self._ns(poll.request_bytes)
            if poll.unit == TO_ALL:
                wait_ns = max(self.turnaround_ns, self.silence_ns)
                times = PollTimes(poll, start_ns, request_ns, wait_ns, 0, 0)
            else:
                wait_ns, behind_ns = self.silence_ns + self.response_ns, self.silence_ns + self.pause_ns
                answer_ns = self._ns(poll.answer_bytes)
                times = PollTimes(poll, start_ns, request_ns, wait_ns, answer_ns, behind_ns)
            yield times
            start_ns = times.end_ns

    def _ns(self, count: int) -> int:
        return character_ns(count, self.baud, self.line_format.bits)

    def summary(self) -> dict[str, float]:
        """Sum of the cycle: its time in ns, polls and cycles in a second, and the line's load."""
        times = list(self.times())
        cycle_ns = times[-1].end_ns if times else 0
        busy_ns = sum(each.request_ns + each.answer_ns for each in times)
        per_ns = 1e9 / cycle_ns if cycle_ns else 0.0
        return {
            "cycle_ns": cycle_ns,
            "polls_per_s": len(times) * per_ns,
            "cycles_per_s": per_ns,
            "load": busy_ns / cycle_ns if cycle_ns else 0.0,
        }
