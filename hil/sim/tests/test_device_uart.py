"""The serial line's times on a device's side, and what a mismatch of baud rates does."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.sim.uart import UART_BUFFER_BYTES, USB_HELD_BYTES, DeviceUart
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import resample

BAUDS = st.sampled_from([300, 9600, 19200, 38400, 57600, 115200, 1_000_000, 2_000_003])
T0 = 123_456_789


def character_end_ns(n: int, baud: int, t0: int = T0) -> int:
    """Time at which character n (from 1) ends: ten bits each, the product divided once."""
    return t0 + n * 10 * 10**9 // baud


def uart(baud: int | None, sent: list[tuple[int, bytes]] | None = None) -> DeviceUart:
    found = sent if sent is not None else []
    made = DeviceUart(baud, lambda at_ns, data: found.append((at_ns, data)))
    made.now_ns = SimTimeNs(T0)
    return made


def arrivals(line: DeviceUart) -> list[tuple[int, int]]:
    """Characters on the line: when each is complete, and its byte."""
    found = []
    while line.incoming.next_ns < FOREVER:
        line.now_ns = line.incoming.next_ns
        before = line.available()
        line.take_arrivals()
        found += [(int(line.now_ns), line.read()) for _ in range(line.available() - before)]
    return found


@given(BAUDS, st.binary(min_size=1, max_size=60))
def test_characters_arrive_at_their_exact_times(baud: int, data: bytes) -> None:
    line = uart(baud)
    line.arrive(data, baud)
    assert line.available() == 0
    assert arrivals(line) == [(character_end_ns(n, baud), byte) for n, byte in enumerate(data, 1)]


@given(BAUDS, st.lists(st.tuples(st.integers(0, 10**7), st.binary(min_size=1, max_size=10)), max_size=6))
def test_a_client_sends_one_character_after_the_other(baud: int, writes: list[tuple[int, bytes]]) -> None:
    line = uart(baud)
    free_ns, expected, now_ns = 0, [], T0
    for gap_ns, data in writes:
        now_ns += gap_ns
        line.now_ns = SimTimeNs(now_ns)
        line.arrive(data, None)
        start_ns = max(now_ns, free_ns)
        expected += [(character_end_ns(n, baud, start_ns), byte) for n, byte in enumerate(data, 1)]
        free_ns = character_end_ns(len(data), baud, start_ns)
    assert [(at, byte) for at, byte in _in_flight(line)] == expected


def _in_flight(line: DeviceUart) -> list[tuple[int, int]]:
    # Arrivals may be in the past of the last write; only their own times count here.
    return line.incoming.characters()


@given(BAUDS, st.lists(st.tuples(st.integers(0, 10**7), st.binary(min_size=1, max_size=100)), max_size=6))
def test_what_the_sketch_sends_follows_itself_without_a_gap(
    baud: int, writes: list[tuple[int, bytes]]
) -> None:
    sent: list[tuple[int, bytes]] = []
    line = uart(baud, sent)
    free_ns, expected, now_ns = 0, [], T0
    for gap_ns, data in writes:
        now_ns += gap_ns
        line.now_ns = SimTimeNs(now_ns)
        line.write(data)
        expected.append((max(now_ns, free_ns), data))
        free_ns = character_end_ns(len(data), baud, expected[-1][0])
    line.write(b"")
    assert sent == expected


def test_print_returns_when_the_rest_fits_the_transmit_buffer() -> None:
    line = uart(9600)
    line.write(bytes(64))
    assert line.tx.print_returns(line.now_ns, line.baud) == T0
    line.write(bytes(36))
    end_ns = character_end_ns(36, 9600, character_end_ns(64, 9600))
    assert line.tx.print_returns(line.now_ns, line.baud) == end_ns - 64 * 10 * 10**9 // 9600


def test_without_a_baud_bytes_take_no_time() -> None:
    sent: list[tuple[int, bytes]] = []
    line = uart(None, sent)
    line.arrive(b"abc", 300)
    assert (line.available(), line.incoming.next_ns) == (3, FOREVER)
    line.write(bytes(100_000))
    assert sent == [(T0, bytes(100_000))]
    assert line.tx.print_returns(line.now_ns, line.baud) == T0


def test_a_usb_host_is_held_up_and_loses_nothing() -> None:
    line = uart(None)
    assert line.room(T0) == USB_HELD_BYTES
    line.arrive(bytes(USB_HELD_BYTES - 1), None)
    assert line.room(T0) == 1
    line.arrive(bytes(100), None)
    assert (line.room(T0), line.available(), line.overrun_bytes) == (0, USB_HELD_BYTES + 99, 0)
    for _ in range(101):
        line.read()
    assert line.room(T0) == 2


@pytest.mark.parametrize("more", [0, 1, 100])
def test_a_uart_loses_what_finds_no_room_and_counts_it(more: int) -> None:
    line = uart(115200)
    data = bytes(i % 256 for i in range(UART_BUFFER_BYTES + more))
    line.arrive(data, 115200)
    line.now_ns = SimTimeNs(character_end_ns(len(data), 115200))
    line.take_arrivals()
    assert (line.available(), line.overrun_bytes) == (UART_BUFFER_BYTES, more)
    assert bytes(line.read() for _ in range(UART_BUFFER_BYTES)) == data[:UART_BUFFER_BYTES]


def test_a_byte_that_is_read_in_time_makes_room_for_the_next() -> None:
    line = uart(9600)
    line.arrive(bytes(200), 9600)
    for n in range(1, 201):
        line.now_ns = SimTimeNs(character_end_ns(n, 9600))
        line.take_arrivals()
        assert line.read() == 0
    assert line.overrun_bytes == 0


@given(st.binary(min_size=1, max_size=30), BAUDS, BAUDS)
def test_a_mismatched_baud_garbles_as_the_line_model_says(data: bytes, client: int, device: int) -> None:
    line = uart(device)
    line.arrive(data, client)
    one_ns = 10 * 10**9 // device
    if client == device:
        expected = [(character_end_ns(n, device), byte) for n, byte in enumerate(data, 1)]
    else:
        expected = [(T0 + s.offset_ns + one_ns, s.byte) for s in resample(data, client, device)]
    assert _in_flight(line) == expected


def test_clear_forgets_what_was_received_and_keeps_the_line() -> None:
    line = uart(9600)
    line.arrive(b"ab", 9600)
    line.now_ns = SimTimeNs(character_end_ns(1, 9600))
    line.take_arrivals()
    line.clear()
    assert line.available() == 0
    assert arrivals(line) == [(character_end_ns(2, 9600), ord("b"))]


def test_another_baud_holds_from_now_on_and_until_the_power_goes() -> None:
    sent: list[tuple[int, bytes]] = []
    line = uart(9600, sent)
    line.write(b"ab")
    line.set_baud(300)
    line.write(b"c")
    line.write(b"d")
    assert [at_ns for at_ns, _ in sent] == [
        T0,
        character_end_ns(2, 9600),
        character_end_ns(1, 300, character_end_ns(2, 9600)),
    ]
    assert line.tx.free_ns == character_end_ns(1, 300, sent[-1][0])
    line.set_baud(None)
    assert line.baud == 9600
    line.set_baud(300)
    line.clear()
    assert line.baud == 9600


def test_a_usb_line_has_no_baud_to_set() -> None:
    line = uart(None)
    line.set_baud(9600)
    assert line.baud is None
