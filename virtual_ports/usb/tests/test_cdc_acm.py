"""Device of the kind ``usb`` before a host in Python, and its descriptors byte by byte. Without a clock."""

import struct

import pytest
from linux_host import BULK_IN, BULK_OUT, NOTIFY, LinuxHost, get, request

from hil.vocab.ports import ADAPTER, UsbIdentity
from virtual_ports.usb.cdc_acm import CdcAcm, LineCoding
from virtual_ports.usb.descriptors import CONFIGURATION_TABLE, Descriptors

ZERO = UsbIdentity(0x2341, 0x804D, "Arduino LLC", "Arduino Zero (virtual)", is_native=True)
STALL, UNLINKED, SHORT, SHUT_DOWN = -32, -104, -121, -108
ZERO_TABLE = bytes.fromhex("12 01 0002 02 00 00 40 4123 4d80 0001 01 02 03 01")
DEVICE_TABLE = bytes.fromhex("12 01 0002 02 00 00 40 2505 a7a4 0001 01 02 03 01")
TABLE = bytes.fromhex(
    "09 02 4300 02 01 00 80 fa"
    "09 04 00 00 01 02 02 00 00  05 24 00 1001  05 24 01 00 01  04 24 02 06  05 24 06 00 01"
    "07 05 81 03 1000 10"
    "09 04 01 00 02 0a 00 00 00  07 05 02 02 4000 00  07 05 83 02 4000 00"
)


class Wire:
    """Host and device, with nothing between them."""

    def __init__(self, identity: UsbIdentity = ADAPTER, *, enumerates: bool = True) -> None:
        self.left = 0
        self.host = LinuxHost()
        self.device = CdcAcm(Descriptors(identity, "demo.m1"), self._leave)
        if enumerates:
            self.host.enumerate()
            self.pass_on()
            assert self.host.is_bound

    def _leave(self) -> None:
        self.left += 1

    def pass_on(self) -> None:
        """Let all pass that is under way."""
        while data := self.host.take():
            self.device.receive(data)
            self.host.receive(self.device.take_answers())
        self.host.receive(self.device.take_answers())

    def control(self, setup: bytes, data: bytes | int = b"") -> tuple[int, bytes]:
        answers: list[tuple[int, bytes]] = []
        length = int.from_bytes(setup[6:8], "little")
        is_in = bool(setup[0] & 0x80)
        data = length if is_in and data == b"" else data
        self.host.submit(0, is_in, data, lambda *answer: answers.append(answer), setup)
        self.pass_on()
        (answer,) = answers
        return answer

    def submit(self, endpoint: int, data: bytes | int, flags: int = 0) -> list[tuple[int, bytes]]:
        answers: list[tuple[int, bytes]] = []
        self.host.submit(
            endpoint, isinstance(data, int), data, lambda *each: answers.append(each), flags=flags
        )
        self.pass_on()
        return answers


@pytest.fixture
def wire() -> Wire:
    return Wire(ADAPTER)


def test_the_descriptors_byte_by_byte() -> None:
    wire = Wire(ZERO)
    assert wire.host.descriptors[1, 0] == ZERO_TABLE
    assert wire.host.descriptors[2, 0] == CONFIGURATION_TABLE == TABLE
    assert wire.host.descriptors[3, 0] == bytes.fromhex("04 03 0904")
    assert wire.host.descriptors[3, 3] == bytes.fromhex("10 03") + "demo.m1".encode("utf-16-le")


@pytest.mark.parametrize(
    ("setup", "data"),
    [
        (get(1, 0, 8), DEVICE_TABLE[:8]),  # cut to what is asked for
        (get(1, 0, 64), DEVICE_TABLE),
        (get(2, 0, 9), TABLE[:9]),
        (request(0x80, 8, 0, 0, 1), b"\x01"),
        (request(0x80, 0, 0, 0, 2), b"\0\0"),
        (request(0x81, 0, 0, 1, 2), b"\0\0"),
        (request(0x82, 0, 0, 0x83, 2), b"\0\0"),
        (request(0x82, 0, 0, 0, 2), b"\0\0"),
        (request(0x81, 10, 0, 1, 1), b"\0"),
        (request(0x01, 11, 0, 1), b""),
        (request(0x02, 1, 0, 0x83), b""),
        (request(0x00, 9, 1, 0), b""),
        (request(0xA1, 0x21, 0, 0, 7), bytes.fromhex("80250000 00 00 08")),
        (request(0x21, 0x22, 3, 0), b""),
        (request(0x21, 0x23, 0xFFFF, 0), b""),
    ],
)
def test_a_known_request(wire: Wire, setup: bytes, data: bytes) -> None:
    assert wire.control(setup) == (0, data)


@pytest.mark.parametrize(
    "setup",
    [
        get(6, 0, 10),  # it has one speed
        get(15, 0, 5),
        get(1, 1, 18),
        get(2, 1, 9),
        get(3, 9, 255, 0x0409),
        get(3, 1, 255, 0x0407),  # no German
        request(0x00, 9, 2, 0),
        request(0x01, 11, 1, 1),
        request(0x81, 10, 0, 2, 1),
        request(0x82, 0, 0, 0x84, 2),
        request(0x81, 0, 0, 7, 2),
        request(0x02, 3, 0, 0x04),
        request(0x02, 3, 1, 0x83),
        request(0x00, 3, 1, 0),  # no remote wake-up
        request(0x80, 0x44, 0, 0, 4),
        request(0xC0, 1, 0, 0, 4),  # a vendor's
        request(0x21, 0x24, 0, 0),
        request(0x21, 0x22, 3, 1),  # to the other interface
        request(0xA1, 0x20, 0, 0, 7),
        request(0x21, 0x21, 0, 0),
    ],
)
def test_an_unknown_request_is_stalled(wire: Wire, setup: bytes) -> None:
    assert wire.control(setup) == (STALL, b"")


@pytest.mark.parametrize(
    ("coding", "name"),
    [
        ((38400, 0, 0, 8), "8N1"),
        ((1, 2, 1, 7), "7O2"),
        ((2**32 - 1, 1, 2, 5), "5E2"),
        ((300, 0, 3, 6), "6M1"),
        ((300, 0, 4, 8), "8S1"),
    ],
)
def test_a_line_coding_is_taken_and_said(wire: Wire, coding: tuple[int, int, int, int], name: str) -> None:
    data = struct.pack("<IBBB", *coding)
    assert wire.control(request(0x21, 0x20, 0, 0, 7), data) == (0, bytes(7))
    assert wire.control(request(0xA1, 0x21, 0, 0, 7)) == (0, data)
    assert wire.device.coding == LineCoding(*coding)
    assert (line_format := wire.device.coding.line_format)
    assert line_format.name == name


@pytest.mark.parametrize(
    "data",
    [
        struct.pack("<IBBB", 0, 0, 0, 8),
        struct.pack("<IBBB", 9600, 3, 0, 8),
        struct.pack("<IBBB", 9600, 0, 5, 8),
        struct.pack("<IBBB", 9600, 0, 0, 9),
        struct.pack("<IBBB", 9600, 0, 0, 16),
        b"",
        bytes(6),
        bytes(8),
    ],
)
def test_no_such_line_coding_is_stalled(wire: Wire, data: bytes) -> None:
    before = wire.device.coding
    assert wire.control(request(0x21, 0x20, 0, 0, len(data)), data) == (STALL, b"")
    assert wire.device.coding == before


def test_a_control_transfer_has_the_length_that_its_setup_says(wire: Wire) -> None:
    assert wire.control(request(0x21, 0x20, 0, 0, 7), b"") == (STALL, b"")
    assert wire.control(request(0x21, 0x22, 3, 0, 0), b"more") == (STALL, b"")
    assert wire.control(get(1, 0, 18), 4) == (0, DEVICE_TABLE[:4])


def test_endpoints_are_not_there_before_the_configuration() -> None:
    wire = Wire(enumerates=False)
    assert wire.submit(BULK_OUT, b"x") == wire.submit(BULK_IN, 64) == [(STALL, b"")]
    assert wire.control(request(0x21, 0x22, 3, 0)) == (STALL, b"")
    assert wire.control(request(0x82, 0, 0, 0x83, 2)) == (STALL, b"")
    assert wire.control(request(0x80, 8, 0, 0, 1)) == (0, b"\0")


@pytest.mark.parametrize(("endpoint", "data"), [(4, b"x"), (BULK_OUT, 64), (BULK_IN, b"x"), (15, 1)])
def test_there_is_no_such_endpoint(wire: Wire, endpoint: int, data: bytes | int) -> None:
    assert wire.submit(endpoint, data) == [(STALL, b"")]


def test_a_halted_endpoint_refuses_until_it_is_cleared(wire: Wire) -> None:
    waiting = wire.submit(BULK_IN, 64)
    assert waiting == []
    assert wire.control(request(0x02, 3, 0, 0x83)) == (0, b"")
    assert waiting == wire.submit(BULK_IN, 64) == [(STALL, b"")]
    assert wire.control(request(0x82, 0, 0, 0x83, 2)) == (0, b"\1\0")
    assert wire.control(request(0x02, 1, 0, 0x83)) == (0, b"")
    wire.device.to_host.send(b"abc")
    assert wire.submit(BULK_IN, 64) == [(0, b"abc")]


def test_out_transfers_are_answered_when_their_last_byte_is_taken(wire: Wire) -> None:
    first, empty, second = (
        wire.submit(BULK_OUT, b"abc"),
        wire.submit(BULK_OUT, b""),
        wire.submit(BULK_OUT, b"de"),
    )
    assert (first, empty, second) == ([], [], [])
    assert [wire.device.from_host.drain(2), first] == [b"ab", []]
    assert wire.device.from_host.drain(1) == b"c"
    wire.pass_on()
    assert (first, empty, second) == ([(0, bytes(3))], [(0, b"")], [])
    assert wire.device.from_host.drain(100) == b"de"
    wire.pass_on()
    assert second == [(0, bytes(2))]
    assert wire.submit(BULK_OUT, b"") == [(0, b"")]


def test_in_transfers_get_what_there_is(wire: Wire) -> None:
    wire.device.to_host.send(bytes(range(200)))
    assert wire.submit(BULK_IN, 128) == [(0, bytes(range(128)))]
    assert wire.submit(BULK_IN, 128, flags=1) == [(SHORT, bytes(range(128, 200)))]
    waiting = [wire.submit(BULK_IN, 2), wire.submit(BULK_IN, 2)]
    wire.device.to_host.send(b"xyz")
    wire.pass_on()
    assert waiting == [[(0, b"xy")], [(0, b"z")]]


def test_an_unlinked_transfer_is_given_up_and_an_answered_one_is_not(wire: Wire) -> None:
    host = wire.host
    answers: list[tuple[int, bytes]] = []
    waits = host.submit(BULK_IN, True, 64, lambda *each: answers.append(each))
    wire.pass_on()
    host.unlink(waits)
    wire.pass_on()
    assert answers == [(UNLINKED, b"")]
    wire.device.to_host.send(b"x")
    raced = host.submit(BULK_IN, True, 64, lambda *each: answers.append(each))
    host.unlink(raced)  # under way while the answer is
    wire.pass_on()
    assert answers == [(UNLINKED, b""), (0, b"x")]
    host.unlink(4711)
    wire.pass_on()


def test_an_unlinked_transfer_that_was_half_taken_does_not_spoil_the_next(wire: Wire) -> None:
    host, done = wire.host, lambda status, data: None
    first = host.submit(BULK_OUT, False, b"abcdef", done)
    host.submit(BULK_OUT, False, b"XYZ", done)
    wire.pass_on()
    assert wire.device.from_host.drain(2) == b"ab"
    host.unlink(first)
    wire.pass_on()
    assert wire.device.from_host.drain(100) == b"XYZ"


def test_who_opens_the_tty_is_seen_and_who_closes_it(wire: Wire) -> None:
    device, host = wire.device, wire.host
    assert not device.is_heard
    for opens in (1, 2):
        host.open()
        wire.pass_on()
        assert (device.is_open, device.is_heard, device.dtr, device.rts, device.opens) == (*[True] * 4, opens)
        assert host.states[-1] == 3  # carrier and DSR
        host.close()
        wire.pass_on()
        assert (device.is_open, device.is_heard, device.dtr, wire.left) == (False, False, False, opens)
    assert len(host.states) == 2


def test_a_native_board_speaks_while_dtr_or_rts_is_on_and_an_adapter_while_it_is_read() -> None:
    for identity, speaks in ((ZERO, False), (ADAPTER, True)):
        wire = Wire(identity)
        wire.host.open()
        wire.pass_on()
        wire.host.set_lines(dtr=False, rts=False)
        wire.pass_on()
        assert wire.device.is_heard is speaks
        wire.host.set_lines(dtr=False, rts=True)
        wire.pass_on()
        assert wire.device.is_heard
        wire.host.close(hangs_up=False)
        wire.pass_on()
        assert wire.device.rts
        assert not wire.device.is_heard


def test_what_nobody_has_read_is_lost_with_who_leaves(wire: Wire) -> None:
    wire.host.most_unread = 0
    wire.host.open()
    wire.pass_on()
    wire.device.to_host.send(bytes(128 * 16 + 100))
    wire.pass_on()
    assert len(wire.host.received) == 128 * 16
    wire.host.close()
    wire.pass_on()
    assert (wire.device.dropped_bytes, len(wire.device.to_host.queue)) == (100, 0)
    wire.host.is_throttled = False
    wire.host.open()
    wire.pass_on()
    assert wire.host.received == b""


def test_a_break_is_a_0_behind_what_was_sent_before_it_at_an_adapter() -> None:
    for identity, heard in ((ADAPTER, b"ab\0c"), (ZERO, b"abc")):
        wire = Wire(identity)
        wire.host.open()
        wire.host.write(b"ab")
        wire.pass_on()
        wire.host.send_break(250)
        wire.host.send_break(0xFFFF)  # the same break goes on
        wire.host.send_break(0)
        wire.pass_on()
        wire.host.write(b"c")
        wire.pass_on()
        assert wire.device.from_host.drain(100) == heard
        wire.pass_on()
        assert not wire.host.unwritten


def test_errors_of_the_line_are_told_and_pass(wire: Wire) -> None:
    wire.host.open()
    wire.pass_on()
    for events in (16, 32, 64):
        wire.device.tell(events)
        wire.pass_on()
    assert wire.host.states == [3, 3 | 16, 3 | 32, 3 | 64]


def test_the_touch_is_1200_baud_and_no_dtr_at_a_native_board() -> None:
    wire = Wire(ZERO)
    wire.host.open()
    wire.host.set_coding(1200)
    wire.pass_on()
    assert not wire.device.is_touched
    wire.host.close()
    wire.pass_on()
    assert wire.device.is_touched
    wire.host.open()
    wire.pass_on()
    assert not wire.device.is_touched
    other = Wire(ADAPTER)
    other.host.open()
    other.host.set_coding(1200)
    other.host.close()
    other.pass_on()
    assert not other.device.is_touched


def test_a_driver_that_leaves_takes_all_with_it(wire: Wire) -> None:
    wire.host.open()
    wire.pass_on()
    waiting = wire.submit(NOTIFY, 16)
    assert wire.control(request(0x00, 9, 0, 0)) == (0, b"")
    assert waiting == [(SHUT_DOWN, b"")]
    assert (wire.device.is_configured, wire.device.is_open, wire.device.dtr, wire.left) == (
        False,
        False,
        False,
        1,
    )


def test_dtr_that_comes_on_is_counted() -> None:
    wire = Wire()
    seen = []
    for lines in (3, 1, 0, 2, 3, 3):
        wire.control(request(0x21, 0x22, lines, 0))
        seen.append(wire.device.rises)
    assert seen == [1, 1, 1, 1, 2, 2]
