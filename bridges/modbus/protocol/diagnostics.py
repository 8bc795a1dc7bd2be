"""Diagnostics of a serial line by its node: functions 8 and 17 (6.8, 6.13).

Source of what each counter counts: MODBUS over Serial Line, Specification and Implementation Guide V1.02,
appendix A.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum

from bridges.modbus.protocol.pdu import PDU_BYTES_MAX, Code, Function, Refused, Request

_NOTHING = b"\0\0"
_CLEAR_LOG = b"\xff\0"
_LINE_FEED = 0x0A
_REPORT_BYTES_MAX = PDU_BYTES_MAX - 2


class SubFunction(IntEnum):
    """Sub-functions of function 8 (6.8.1)."""

    RETURN_QUERY_DATA = 0
    RESTART_COMMUNICATIONS = 1
    RETURN_DIAGNOSTIC_REGISTER = 2
    CHANGE_ASCII_DELIMITER = 3
    FORCE_LISTEN_ONLY_MODE = 4
    CLEAR_COUNTERS = 10
    BUS_MESSAGES = 11
    BUS_ERRORS = 12
    EXCEPTIONS = 13
    SERVER_MESSAGES = 14
    NO_RESPONSES = 15
    NEGATIVE_ACKNOWLEDGES = 16
    BUSY = 17
    OVERRUNS = 18
    CLEAR_OVERRUNS = 20


@dataclass
class LineCounters:
    """Counters of a node. Decision: what is sent of them is modulo 65536, so that differences stay right."""

    bus_messages: int = 0
    """Frames on the line, to whomever, with a right CRC."""
    bus_errors: int = 0
    """Frames with a wrong CRC, too short ones, and characters with errors."""
    exceptions: int = 0
    """Exceptions, those included that a broadcast does not get."""
    server_messages: int = 0
    """Requests to this node or to all that were processed."""
    no_responses: int = 0
    """Requests to this node or to all that got no answer, not even an exception."""
    negative_acknowledges: int = 0
    busy: int = 0
    """Answers that the node is busy."""
    overruns: int = 0
    """Requests lost because characters came faster than they were taken."""

    def clear(self) -> None:
        for each in fields(self):
            setattr(self, each.name, 0)


class Diagnostics:
    """Diagnosis of one node, which tells it what happens: ``heard`` for each frame on the line, ``takes`` for
    a request to it or to all, and ``answered`` when that is done. ``answer`` does function 8.
    """

    def __init__(self) -> None:
        self.counters = LineCounters()
        self.register = 0
        """The diagnostic register, of 16 bits; what they mean is the device's."""
        self.is_listen_only = False
        self.ascii_delimiter = _LINE_FEED
        """Kept for those who ask; frames of RTU have none."""
        self._is_restarting = False

    def heard(self, *, is_good: bool) -> None:
        """Count a frame on the line, whomever it is for."""
        if is_good:
            self.counters.bus_messages += 1
        else:
            self.counters.bus_errors += 1

    def count_line(self, good: int, bad: int) -> None:
        """Count so many frames on the line, for a node that is not told of each."""
        self.counters.bus_messages += good
        self.counters.bus_errors += bad

    def takes(self, request: Request | None) -> bool:
        """True if a request to this node or to all is to be processed; None: one that ``parse`` refused. In
        listen-only mode a restart alone is; what else comes gets neither an effect nor an answer.
        """
        is_taken = not self.is_listen_only or _is_restart(request)
        self.counters.server_messages += is_taken
        self.counters.no_responses += not is_taken
        return is_taken

    def answer(self, request: Request) -> bytes | None:
        """Do what function 8 asks. None: it has no answer. A restart takes effect with ``answered``.

        Raises:
            Refused: an unknown sub-function (01), or data that it does not have (03).
        """
        sub_function, data = request.sub_function, request.data
        assert sub_function is not None
        act = _ACTS.get(sub_function)
        if act is None:
            raise Refused(Code.ILLEGAL_FUNCTION, f"sub-function {sub_function} is not known")
        said = act(self, data)
        if said is None:
            return None
        return bytes((request.function, sub_function >> 8, sub_function & 0xFF)) + said

    def answered(self, pdu: bytes | None, *, is_to_all: bool = False) -> None:
        """Count the answer to a request that was taken, or that it has none. What would answer a request
        ``is_to_all`` is counted, and is not sent.
        """
        if self._is_restarting:
            self._is_restarting = self.is_listen_only = False
            self.counters.clear()
            return
        if pdu is not None and pdu[0] & 0x80:
            self.counters.exceptions += 1
            self.counters.busy += pdu[1] == Code.SERVER_DEVICE_BUSY
            self.counters.negative_acknowledges += pdu[1] == Code.NEGATIVE_ACKNOWLEDGE
        if pdu is None or is_to_all:
            self.counters.no_responses += 1

    def _return_query_data(self, data: bytes) -> bytes:
        if not data or len(data) % 2:
            raise Refused(Code.ILLEGAL_DATA_VALUE, f"{len(data)} bytes to be returned; they come in pairs")
        return data

    def _restart(self, data: bytes) -> bytes | None:
        if data != _CLEAR_LOG:
            _check_nothing(data)
        self._is_restarting = True
        return None if self.is_listen_only else data

    def _return_register(self, data: bytes) -> bytes:
        _check_nothing(data)
        return (self.register & 0xFFFF).to_bytes(2, "big")

    def _change_delimiter(self, data: bytes) -> bytes:
        if len(data) != 2 or data[1]:
            raise Refused(Code.ILLEGAL_DATA_VALUE, f"a delimiter is a character and 00, not {data.hex(' ')}")
        self.ascii_delimiter = data[0]
        return data

    def _listen_only(self, data: bytes) -> None:
        _check_nothing(data)
        self.is_listen_only = True

    def _clear(self, data: bytes) -> bytes:
        _check_nothing(data)
        self.counters.clear()
        self.register = 0
        return data

    def _clear_overruns(self, data: bytes) -> bytes:
        _check_nothing(data)
        self.counters.overruns = 0
        return data


_Act = Callable[[Diagnostics, bytes], bytes | None]


def _counter(name: str) -> _Act:
    def read(diagnostics: Diagnostics, data: bytes) -> bytes:
        _check_nothing(data)
        count: int = getattr(diagnostics.counters, name)
        return (count & 0xFFFF).to_bytes(2, "big")

    return read


_ACTS: dict[int, _Act] = {
    SubFunction.RETURN_QUERY_DATA: Diagnostics._return_query_data,
    SubFunction.RESTART_COMMUNICATIONS: Diagnostics._restart,
    SubFunction.RETURN_DIAGNOSTIC_REGISTER: Diagnostics._return_register,
    SubFunction.CHANGE_ASCII_DELIMITER: Diagnostics._change_delimiter,
    SubFunction.FORCE_LISTEN_ONLY_MODE: Diagnostics._listen_only,
    SubFunction.CLEAR_COUNTERS: Diagnostics._clear,
    SubFunction.CLEAR_OVERRUNS: Diagnostics._clear_overruns,
    **{SubFunction[each.name.upper()]: _counter(each.name) for each in fields(LineCounters)},
}


def _check_nothing(data: bytes) -> None:
    if data != _NOTHING:
        raise Refused(Code.ILLEGAL_DATA_VALUE, f"the data of this sub-function is 00 00, not {data.hex(' ')}")


def _is_restart(request: Request | None) -> bool:
    if request is None or request.sub_function != SubFunction.RESTART_COMMUNICATIONS:
        return False
    return request.data in (_NOTHING, _CLEAR_LOG)


def report(server_id: int, more: bytes = b"", *, is_running: bool) -> bytes:
    """Make the answer to function 17: an identification of one byte, whether the device runs, and what it
    adds, as a text. The protocol leaves the length of the first to the device; masters take the two bytes
    behind the count for it and for the state.

    Raises:
        ValueError: more than fits into an answer.
    """
    said = bytes((server_id, 0xFF if is_running else 0)) + more
    if len(said) > _REPORT_BYTES_MAX:
        raise ValueError(f"a report of {len(said)} bytes; {_REPORT_BYTES_MAX} fit into an answer")
    return bytes((Function.REPORT_SERVER_ID, len(said))) + said
