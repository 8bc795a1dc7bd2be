"""pyserial's ``Serial`` at ports of a bench in memory."""

import io

import pytest
import serial

from hil.testing import Bench
from hil.testing.serial_ports.passing import EndlessWait
from hil.vocab.time import NS_PER_MS

MECHADUINO = {"bench": "b", "devices": {"m1": {"profile": "mechaduino"}}}
SAC = {"bench": "b", "devices": {"s1": {"profile": "sac"}}}
LINE = {
    "bench": "b",
    "devices": {"s1": {"profile": "sac"}},
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "memory"}}}},
}


def test_a_command_is_answered_at_its_time() -> None:
    with Bench(MECHADUINO) as b:
        assert b.start() == []
        with b.serial("m1", timeout=1) as port:
            assert isinstance(port, serial.Serial)
            before_ns = b.now_ns
            port.write(b"p")
            line = port.readline()
            assert line.startswith(b"stepNumber: 0 , Angle: ")
            assert line.endswith(b"\r\n")
            assert b.now_ns - before_ns == 100 * NS_PER_MS  # ten readings of the encoder


def test_a_time_out_lets_its_time_pass() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=0.25)
        port.reset_input_buffer()
        before_ns = b.now_ns
        assert port.read(1) == b""
        assert b.now_ns - before_ns == 250 * NS_PER_MS


def test_a_read_stops_at_the_byte_on_a_paced_line() -> None:
    with Bench(SAC) as b:
        b.start()
        port = b.serial("s1", timeout=2)
        port.reset_input_buffer()
        port.write(b"$?\r")
        first_ns = b.now_ns if port.read(1) else 0
        port.read(1)
        assert b.now_ns - first_ns == 10 * 10**9 // 38400


def test_many_bytes_are_read_at_the_time_of_the_last() -> None:
    with Bench(SAC) as b:
        b.start()
        port = b.serial("s1", timeout=2)
        port.reset_input_buffer()
        port.write(b"$?\r")
        port.read(1)
        first_ns = b.now_ns
        assert len(port.read(4)) == 4
        fifth_ns = b.now_ns
        assert 0 <= first_ns + 4 * 10 * 10**9 // 38400 - fifth_ns <= 1
        port.timeout = 0.0006  # two characters and a bit
        assert len(port.read(9)) == 2
        assert 0 <= b.now_ns - fifth_ns - 600_000 <= 1


def test_a_line_is_read_to_its_end() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=0.5)
        port.reset_input_buffer()
        port.write(b"pp")
        b.run(500)
        first, second = port.readlines(), port.readlines()
        assert [line[:11] for line in first] == [b"stepNumber:"] * 2
        assert second == []


def test_a_long_wait_loses_no_samples() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        rows = b.axis("m1").record("position_deg", interval_ms=0.1)
        port = b.serial("m1", timeout=5)
        port.reset_input_buffer()
        port.read(1)
        assert rows.lost == 0
        assert len(rows.rows) == 50_000


def test_a_wrong_speed_garbles() -> None:
    with Bench(SAC) as b:
        b.start()
        right = b.serial("s1", timeout=0.5)
        right.write(b"$?\r")
        answer = right.read(20)
        right.baudrate = 9600
        right.write(b"$?\r")
        assert answer
        assert right.read(20) != answer


def test_polling_ends() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=0)
        port.write(b"p")
        got = b""
        while not got.endswith(b"\r\n"):
            got += port.read(port.in_waiting)
        assert b"Angle" in got


def test_a_tap_is_a_port() -> None:
    with Bench(LINE) as b:
        b.start()
        tap = b.serial("bus0.master", timeout=0.01)
        tap.write(b"\x01")
        assert tap.read(1) == b""


def test_errors_are_those_of_pyserial() -> None:
    with Bench(MECHADUINO) as b:
        port = b.serial("m1")
        port.close()
        with pytest.raises(serial.PortNotOpenError):
            port.read(1)
        port.port = "m2"
        with pytest.raises(serial.SerialException, match="no such port in this bench; there are m1"):
            port.open()
        with pytest.raises(KeyError, match="m1"):
            b.serial("m7")
        locked = b.serial("m1", exclusive=True)
        with pytest.raises(serial.SerialException, match="Could not exclusively lock port m1"):
            b.serial("m1", exclusive=True)
        locked.close()


def test_a_read_without_end_is_told() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=None)
        port.reset_input_buffer()
        with pytest.raises(EndlessWait, match="read at m1: nothing has come for an hour"):
            port.read(1)


def test_a_port_opened_twice_shares_what_comes() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        first, second = b.serial("m1", timeout=0.5), b.serial("m1", timeout=0.5)
        second.reset_input_buffer()
        first.write(b"p")
        head, rest = first.read(4), second.readline()
        assert head == b"step"
        assert rest.startswith(b"Number")
        first.close()
        second.write(b"p")
        assert second.readline().startswith(b"stepNumber")


def test_who_opens_again_begins_without_what_came_meanwhile() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=0.5)
        port.write(b"p")
        port.close()
        b.run(500)
        port.open()
        assert port.in_waiting == 0
        port.write(b"p")
        assert len(port.readlines()) == 1


def test_can_bus_and_segment_taps_are_ports() -> None:
    can = {
        "bench": "b",
        "devices": {"m1": {"profile": "mechaduino"}},
        "can": {"can0": {"taps": {"slcan0": {"port": "memory"}}}},
    }
    with Bench(can) as b, b.serial("can0.slcan0", timeout=0.1) as port:
        port.write(b"V\r")
        assert port.read_until(b"\r").startswith(b"V")
    with Bench(LINE) as b:
        b.start()
        tap, node = b.serial("bus0.master", timeout=0.1), b.serial("s1", timeout=0.1)
        assert tap.baudrate == node.baudrate == 38400


def test_an_unknown_port_says_what_there_is() -> None:
    why = r"there is no port 'bus0'; did you mean \"bus0\.master\"\? there are s1, s1"
    with Bench(LINE) as b, pytest.raises(KeyError, match=why):
        b.serial("bus0")


def test_a_wrapper_reads_text() -> None:
    with Bench(MECHADUINO) as b:
        b.start()
        port = b.serial("m1", timeout=0.5)
        text = io.TextIOWrapper(io.BufferedRWPair(port, port, 1), encoding="ascii", write_through=True)
        text.write("p")
        text.flush()
        assert text.readline().startswith("stepNumber")
        port.write(b"p")
        data = bytearray(4)
        assert port.readinto(data) == 4
        assert data == b"step"
        assert [line[:6] for line in port] == [b"Number"]


def test_a_read_ends_with_the_last_byte_that_it_waits_for_however_late_that_is_sent() -> None:
    with Bench({"bench": "b", "devices": {"u1": {"profile": "uno"}}}) as b:
        b.run(ms=100)
        b.port("u1").read()
        port = b.serial("u1", timeout=5)
        port.write(b"move 16\n")
        said = b"\r\nmoving 16 steps, 144 us each\r\nmoved 16 steps\r\n"
        begun_ns = b.now_ns
        assert port.read(len(said)) == said
        assert b.now_ns - begun_ns < 100_000_000
