"""Modem lines, breaks and the touch, as the kind of a port has them."""

from typing import Any

import pytest
import serial

from hil.sim.inputs import Bytes, LineOpened
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS


def bench_of(profile: str, port: Any) -> Bench:
    made = Bench({"bench": "b", "devices": {"d1": {"profile": profile, "port": port}}})
    made.start()
    return made


RFC2217 = {"kind": "rfc2217", "listen": 0}


def test_a_pty_has_no_lines_and_no_break() -> None:
    with bench_of("sac", "pty") as b:
        port = b.serial("d1", timeout=0.1)
        with pytest.raises(OSError, match="Inappropriate ioctl"):
            _ = port.cts
        with pytest.raises(OSError, match="Inappropriate ioctl"):
            port.dtr = False
        before_ns = b.now_ns
        port.send_break()
        assert b.now_ns == before_ns
        assert port.read(10) == b""


@pytest.mark.parametrize("port", ["usb", RFC2217])
def test_an_adapter_shows_its_lines_and_makes_a_0_of_a_break(port: Any) -> None:
    with bench_of("uno", port) as b:
        at = b.serial("d1", timeout=0.1)
        assert (at.cts, at.dsr, at.cd, at.ri) == (True, True, True, False)
        at.dtr = at.rts = False
        before_ns = b.now_ns
        at.send_break()
        assert b.now_ns - before_ns == 250 * NS_PER_MS
        at.break_condition = True
        at.break_condition = False
        given = [logged.input for logged in b.inputs.inputs]
        assert [each.data for each in given if isinstance(each, Bytes)] == [b"\0", b"\0"]


def test_a_native_board_sends_only_while_a_line_is_on() -> None:
    with bench_of("mechaduino", "usb") as b:
        port = b.serial("d1", timeout=0.3)
        port.reset_input_buffer()
        port.dtr = port.rts = False
        port.write(b"p")
        assert port.read(1) == b""
        port.rts = True
        port.write(b"p")
        assert port.readline().startswith(b"stepNumber")


def test_a_native_board_resets_after_the_touch() -> None:
    with bench_of("mechaduino", "usb") as b:
        ups = b.runtime.devices["d1"].power.ups
        port = b.serial("d1", 1200)
        b.run(300)
        assert b.runtime.devices["d1"].power.ups == ups  # DTR is on
        port.close()
        b.run(249)
        assert b.runtime.devices["d1"].power.ups == ups
        b.run(2)
        assert b.runtime.devices["d1"].power.ups == ups + 1
        b.run(2000)
        assert b.runtime.devices["d1"].power.ups == ups + 1


def test_a_touch_that_is_taken_back_is_none() -> None:
    with bench_of("mechaduino", "usb") as b:
        ups = b.runtime.devices["d1"].power.ups
        b.serial("d1", 1200).close()
        b.run(100)
        b.serial("d1", 115200)
        b.run(1000)
        assert b.runtime.devices["d1"].power.ups == ups


def test_at_a_pty_the_touch_is_the_closing() -> None:
    with bench_of("mechaduino", "pty") as b:
        ups = b.runtime.devices["d1"].power.ups
        b.serial("d1", 1200).close()
        assert b.runtime.devices["d1"].power.ups == ups + 1


def test_xoff_stops_what_is_sent() -> None:
    with bench_of("mechaduino", "pty") as b:
        port = b.serial("d1", timeout=1, write_timeout=0.5)
        port.set_output_flow_control(False)
        before_ns = b.now_ns
        with pytest.raises(serial.SerialTimeoutException):
            port.write(b"p")
        assert 500 * NS_PER_MS <= b.now_ns - before_ns < 502 * NS_PER_MS
        port.set_output_flow_control(True)
        port.write(b"p")
        assert port.readline().startswith(b"stepNumber")
        port.set_input_flow_control(False)
        assert [each.input.data for each in b.inputs.inputs if isinstance(each.input, Bytes)] == [
            b"p",
            b"\x13",
        ]


@pytest.mark.parametrize(
    ("port", "openings"), [("pty", 2), ({"kind": "tcp", "listen": 0}, 2), ("usb", 3), (RFC2217, 3)]
)
def test_a_line_is_opened_by_its_first_client_and_by_dtr(port: Any, openings: int) -> None:
    with bench_of("uno", port) as b:
        at, beside = b.serial("d1", timeout=0.1), b.serial("d1", timeout=0.1)
        beside.close()
        if openings == 3:
            at.dtr = False
            at.rts = False
            at.dtr = True
        at.close()
        at.open()
        given = [logged.input for logged in b.inputs.inputs]
        assert [each for each in given if isinstance(each, LineOpened)] == [LineOpened()] * openings


def test_a_line_of_a_board_that_is_not_reset_is_no_input() -> None:
    with Bench({"bench": "b", "devices": {"d1": {"profile": "uno", "auto_reset": False}}}) as b:
        b.serial("d1").close()
        assert [*b.inputs.inputs] == []
    with bench_of("sac", "pty") as b:
        b.serial("d1").close()
        assert [*b.inputs.inputs] == []
