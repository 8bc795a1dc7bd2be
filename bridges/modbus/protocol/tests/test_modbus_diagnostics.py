"""A node's own view of its line: counters, listen-only mode, restart, and its report."""

import pytest

from bridges.modbus.protocol.client_side import ask_report, diagnose, encode, parse_answer, read
from bridges.modbus.protocol.diagnostics import Diagnostics, LineCounters, SubFunction, report
from bridges.modbus.protocol.pdu import Code, Refused, Request, Table, answer, exception, parse

READ_ONE = encode(read(Table.HOLDING_REGISTERS, 0))
TO_FILL = ("bus_messages", "bus_errors", "exceptions", "server_messages", "no_responses")
TO_FILL += ("negative_acknowledges", "busy", "overruns")
NO_EFFECT = None


class Node:
    """A node of one register, the simplest that there can be."""

    def __init__(self) -> None:
        self.line = Diagnostics()
        self.code: Code | None = None
        """Exception that it answers a read with."""

    def hear(self, pdu: bytes, *, is_to_all: bool = False) -> bytes | None:
        """Answer a request to this node or to all; None: it sends nothing."""
        self.line.heard(is_good=True)
        request, said = None, None
        try:
            request = parse(pdu, is_serial_line=True)
        except Refused as refused:
            said = exception(pdu[0], refused.code)
        if not self.line.takes(request):
            return None
        if request:
            said = self._act(request)
        self.line.answered(said, is_to_all=is_to_all)
        return None if is_to_all else said

    def _act(self, request: Request) -> bytes | None:
        try:
            if request.sub_function is not None:
                return self.line.answer(request)
            if self.code:
                raise Refused(self.code, "as the test wants it")
            return answer(request, [0])
        except Refused as refused:
            return exception(request.function, refused.code)

    def ask(self, sub_function: int, data: str = "0000") -> str | None:
        """Data of the answer to function 8 in hexadecimal; None: there is no answer."""
        request = diagnose(sub_function, bytes.fromhex(data))
        reply = self.hear(encode(request))
        return reply if reply is None else parse_answer(request, reply).data.hex()


def code_of(node: Node, sub_function: int, data: str) -> int:
    with pytest.raises(Refused) as refused:
        node.ask(sub_function, data)
    return refused.value.code


def test_each_counter_has_its_sub_function() -> None:
    node = Node()
    for value, name in enumerate(TO_FILL, 100):
        setattr(node.line.counters, name, value)
    said = [int(node.ask(sub_function) or "", 16) for sub_function in range(11, 19)]
    own = {11: 1, 14: 4}  # the questions are messages themselves
    assert said == [
        value + own.get(sub, 0) for sub, value in zip(range(11, 19), range(100, 108), strict=True)
    ]


def test_what_is_counted() -> None:
    node = Node()
    for _ in range(3):
        node.line.heard(is_good=True)  # to others
    node.line.heard(is_good=False)
    assert node.hear(READ_ONE) == bytes.fromhex("03 02 0000")
    assert node.hear(READ_ONE, is_to_all=True) is None
    node.code = Code.SERVER_DEVICE_BUSY
    assert node.hear(READ_ONE) == b"\x83\6"
    node.code = Code.NEGATIVE_ACKNOWLEDGE
    assert node.hear(READ_ONE) == b"\x83\7"
    assert node.hear(READ_ONE, is_to_all=True) is None
    assert node.hear(b"\x07") == b"\x87\1"
    node.line.counters.overruns += 1
    assert node.line.counters == LineCounters(
        bus_messages=9,
        bus_errors=1,
        exceptions=4,
        server_messages=6,
        no_responses=2,
        negative_acknowledges=2,
        busy=1,
        overruns=1,
    )


def test_a_counter_goes_round() -> None:
    node = Node()
    node.line.counters.bus_errors = 65536 + 5
    assert node.ask(SubFunction.BUS_ERRORS) == "0005"


def test_query_data_come_back() -> None:
    node = Node()
    for data in ("a537", "0000ffff", "00" * 250):
        assert node.ask(0, data) == data
    assert code_of(node, 0, "") == code_of(node, 0, "010203") == Code.ILLEGAL_DATA_VALUE


@pytest.mark.parametrize("sub_function", [2, 4, *range(10, 19), 20])
def test_data_that_a_sub_function_does_not_have(sub_function: int) -> None:
    for data in ("", "0001", "00000000"):
        assert code_of(Node(), sub_function, data) == Code.ILLEGAL_DATA_VALUE


@pytest.mark.parametrize("sub_function", [5, 9, 19, 21, 65535])
def test_a_sub_function_that_is_unknown(sub_function: int) -> None:
    for data in ("", "0000", "0001"):
        assert code_of(Node(), sub_function, data) == Code.ILLEGAL_FUNCTION


def test_clearing() -> None:
    node = Node()
    node.line.register = 0x12345
    node.line.counters.overruns = 3
    node.line.counters.bus_errors = 4
    assert node.ask(SubFunction.RETURN_DIAGNOSTIC_REGISTER) == "2345"
    assert node.ask(SubFunction.CLEAR_OVERRUNS) == "0000"
    assert (node.line.counters.overruns, node.line.counters.bus_errors) == (0, 4)
    assert node.ask(SubFunction.CLEAR_COUNTERS) == "0000"
    assert (node.line.counters, node.line.register) == (LineCounters(), 0)


def test_the_delimiter_is_kept() -> None:
    node = Node()
    assert node.line.ascii_delimiter == 0x0A
    assert node.ask(SubFunction.CHANGE_ASCII_DELIMITER, "2100") == "2100"
    assert node.line.ascii_delimiter == 0x21
    for data in ("2101", "21", ""):
        assert code_of(node, SubFunction.CHANGE_ASCII_DELIMITER, data) == Code.ILLEGAL_DATA_VALUE


@pytest.mark.parametrize("data", ["0000", "ff00"])
def test_a_restart_is_answered_and_clears_the_counters(data: str) -> None:
    node = Node()
    assert node.ask(SubFunction.RESTART_COMMUNICATIONS, data) == data
    assert node.line.counters == LineCounters()


@pytest.mark.parametrize("data", ["0000", "ff00"])
def test_in_listen_only_mode_a_restart_alone_has_an_effect(data: str) -> None:
    node = Node()
    assert node.ask(SubFunction.FORCE_LISTEN_ONLY_MODE) is None
    assert node.line.is_listen_only
    before = node.line.counters.server_messages
    for pdu in (READ_ONE, encode(diagnose(10)), b"\x07", encode(diagnose(1, b"\0\1")), encode(ask_report())):
        assert node.hear(pdu) is None
    assert (node.line.counters.server_messages, node.line.counters.exceptions) == (before, 0)
    assert (node.line.counters.bus_messages, node.line.counters.no_responses) == (6, 6)
    assert node.ask(SubFunction.RESTART_COMMUNICATIONS, data) is None
    assert not node.line.is_listen_only
    assert node.line.counters == LineCounters()
    assert node.ask(SubFunction.RESTART_COMMUNICATIONS) == "0000"


def test_a_restart_with_other_data_is_refused() -> None:
    for data in ("", "0001", "ff01", "ff000000"):
        assert code_of(Node(), SubFunction.RESTART_COMMUNICATIONS, data) == Code.ILLEGAL_DATA_VALUE


def test_a_report() -> None:
    assert report(3, b"m1", is_running=True) == bytes.fromhex("11 04 03 ff 6d31")
    assert report(0x42, is_running=False) == bytes.fromhex("11 02 42 00")
    assert parse_answer(ask_report(), report(0x42, b"x", is_running=True)).data == b"\x42\xffx"
    assert len(report(1, bytes(249), is_running=True)) == 253
    with pytest.raises(ValueError, match="a report of 252 bytes; 251 fit"):
        report(1, bytes(250), is_running=True)
