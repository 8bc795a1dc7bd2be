"""Port of the kind ``usb``, at a kernel in Python."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from fake_vhci import FakeKernel

from hil.testing.ports import RecordingHost, accounted, until
from hil.vocab.line_format import EIGHT_N_1
from hil.vocab.ports import ADAPTER, PortContext, PortError, UsbIdentity
from virtual_ports.usb import usb_port, usb_session
from virtual_ports.usb.usb_options import Options
from virtual_ports.usb.usb_port import UsbPort

ZERO = UsbIdentity(0x2341, 0x804D, "Arduino LLC", "Arduino Zero (virtual)", is_native=True)
Scenario = Callable[[UsbPort, RecordingHost, FakeKernel], Awaitable[None]]


def run(folder: Path, scenario: Scenario, usb: UsbIdentity = ADAPTER, options: Options | None = None) -> None:
    async def main() -> None:
        kernel = FakeKernel()
        port = UsbPort(options or Options(), PortContext("b", "m1", folder, usb=usb), kernel.attach)
        host = RecordingHost(port)
        await port.open(host)
        try:
            await scenario(port, host, kernel)
        finally:
            await port.close()
        assert all(each.is_detached for each in kernel.plugged)
        assert list(folder.iterdir()) == []

    asyncio.run(main())


def test_it_has_a_tty_a_name_and_a_serial_number(tmp_path: Path) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        assert port.address == "/dev/ttyACM91"
        assert (tmp_path / "m1").readlink() == Path("/dev/ttyACM91")
        texts = [kernel.host.descriptors[3, index][2:].decode("utf-16-le") for index in (1, 2, 3)]
        assert texts == ["Arduino LLC", "Arduino Zero (virtual)", "b.m1"]
        assert kernel.host.descriptors[1, 0][8:12] == bytes.fromhex("41234d80")

    run(tmp_path, scenario, ZERO)


@pytest.mark.parametrize("usb", [ADAPTER, ZERO])
def test_bytes_pass_both_ways_and_none_is_lost(tmp_path: Path, usb: UsbIdentity) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        port.write(b"nobody hears this")
        host, step = kernel.host, kernel.plugged[-1].step
        board.room_bytes = 3
        host.open()
        host.write(b"abcdef")
        step()
        await until(lambda: board.got == b"abc")
        assert host.unwritten
        board.room_bytes = 1 << 30
        port.resume_reading()
        await until(lambda: board.got == b"abcdef" and not host.unwritten)
        sent = bytes(range(256)) * 4096
        port.write(sent)
        assert port.backlog() > 0
        await until(lambda: len(host.received) >= len(sent))
        assert host.received == sent
        await until(lambda: board.drains == 1)
        host.write(sent)
        step()
        await until(lambda: len(board.got) == 6 + len(sent))
        assert board.got[6:] == sent
        host.close()
        step()
        await until(lambda: not port.stats().clients)
        assert (port.stats().unheard_bytes, port.stats().connects) == (17, 1)
        assert accounted(port) == 17 + len(sent)

    run(tmp_path, scenario, usb)


def test_a_refusal_is_the_ports(tmp_path: Path) -> None:
    async def main() -> None:
        kernel = FakeKernel()
        kernel.refuses = "the module is not there; load it"
        port = UsbPort(Options(), PortContext("b", "m1", tmp_path), kernel.attach)
        with pytest.raises(PortError, match="usb port of m1: the module is not there; load it"):
            await port.open(RecordingHost(port))
        await port.close()

    asyncio.run(main())


def test_a_device_that_somebody_pulls_out_plugs_itself_in_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_port, "AGAIN_S", 0.01)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        kernel.host.most_unread = 0
        kernel.host.open()
        kernel.plugged[0].step()
        await until(lambda: port.stats().clients == 1)
        port.write(bytes(10_000))
        await until(lambda: len(kernel.host.received) == 2048)
        kernel.plugged[0].pull_out()
        await until(lambda: not (tmp_path / "m1").is_symlink())
        assert port.stats().away == "it was pulled out"
        assert accounted(port) == 10_000
        await until(lambda: port.stats().away is None and port.address == "/dev/ttyACM92")
        assert board.left == [None]
        assert board.drains == 1
        assert (tmp_path / "m1").readlink() == Path("/dev/ttyACM92")
        kernel.host.open()
        kernel.host.write(b"again")
        kernel.plugged[1].step()
        await until(lambda: board.got == b"again")
        assert [record.message for record in caplog.records if record.name == "hil"] == [
            "usb port of m1: /dev/ttyACM91: it was pulled out; it plugs itself in again",
            "usb port of m1: plugged in at /dev/ttyACM92",
        ]

    caplog.set_level("INFO")
    run(tmp_path, scenario)


def test_what_cannot_be_plugged_in_again_is_a_failed_port(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_port, "AGAIN_S", 0.01)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        kernel.refuses = "the module was removed; load it"
        kernel.plugged[0].pull_out()
        await until(lambda: board.failures == ["usb port of m1: the module was removed; load it"])
        assert port.stats().away == board.failures[0]
        port.write(b"for nobody")
        assert port.stats().unheard_bytes == 10

    run(tmp_path, scenario)


def test_a_host_controller_that_sends_garbage_loses_the_device(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_port, "AGAIN_S", 0.01)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        kernel.plugged[0].send(b"GET / HTTP/1.1\r\n" + bytes(40))
        await until(lambda: len(kernel.plugged) == 2 and port.stats().away is None)
        assert "its host controller sends what it must not: command 0x47455420" in caplog.text

    run(tmp_path, scenario)


def test_no_tty_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usb_port, "TTY_S", 0.05)

    async def main() -> None:
        kernel = FakeKernel(makes_tty=False)
        port = UsbPort(Options(), PortContext("b", "m1", tmp_path), kernel.attach)
        with pytest.raises(PortError, match="the kernel has made no tty of it; is its module cdc-acm there"):
            await port.open(RecordingHost(port))
        assert kernel.plugged[0].is_detached
        await port.close()

    asyncio.run(main())


def test_the_touch_tells_1200_baud_after_a_quarter_of_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_session, "TOUCH_S", 0.01)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        host, step = kernel.host, kernel.plugged[0].step
        host.open()
        host.set_coding(1200)
        step()
        await until(lambda: port.client_baud() == 1200)
        host.close()
        step()
        await until(lambda: board.left == [None, 1200])
        host.open()
        step()
        await until(lambda: port.stats().clients == 1)
        host.set_coding(9600)
        host.close()
        step()
        await until(lambda: board.left == [None, 1200, None])

    run(tmp_path, scenario, ZERO)


def test_the_touch_is_off_if_the_port_is_opened_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_session, "TOUCH_S", 3600.0)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        host, step = kernel.host, kernel.plugged[0].step
        host.open()
        host.set_coding(1200)
        host.close()
        step()
        await until(lambda: port.stats().connects == 1 and not port.stats().clients)
        monkeypatch.setattr(usb_session, "TOUCH_S", 0.0)
        host.open()
        step()
        await until(lambda: port.stats().connects == 2)
        host.set_coding(115200)
        host.close()
        step()
        await until(lambda: board.left == [None, None])

    run(tmp_path, scenario, ZERO)


def test_a_native_board_comes_and_goes_with_its_power(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_port, "RESET_S", 0.01)

    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        port.power(True)
        assert len(kernel.plugged) == 1
        kernel.host.open()
        kernel.plugged[0].step()
        await until(lambda: port.stats().clients == 1)
        port.power(False)
        await until(lambda: kernel.plugged[0].is_detached)
        assert (port.stats().away, port.stats().clients) == ("the board has no power", 0)
        await until(lambda: board.left == [None])
        port.power(True)
        port.power(False)
        port.power(True)
        await until(lambda: len(kernel.plugged) == 2 and port.stats().away is None)

    run(tmp_path, scenario, ZERO)


def test_an_adapter_stays_without_the_boards_power(tmp_path: Path) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        port.power(False)
        assert not kernel.plugged[0].is_detached

    run(tmp_path, scenario)


def test_it_can_be_closed_while_it_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        kernel.makes_tty = False
        monkeypatch.setattr(usb_port, "AGAIN_S", 0.0)
        kernel.plugged[0].pull_out()
        await until(lambda: len(kernel.plugged) == 2)

    run(tmp_path, scenario)


def test_the_format_is_the_hosts_and_errors_are_told_to_it(tmp_path: Path) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        assert port.client_format() is EIGHT_N_1
        kernel.host.open()
        kernel.host.set_coding(38400, 2, 2, 7)
        kernel.plugged[0].step()
        await until(lambda: port.client_format().name == "7E2" and port.client_baud() == 38400)
        port.tell_errors(framing=True, parity=False)
        port.tell_errors(framing=False, parity=True)
        await until(lambda: kernel.host.states == [3, 3 | 16, 3 | 32])

    run(tmp_path, scenario)


def test_a_serial_number_of_its_own_and_a_path(tmp_path: Path) -> None:
    async def scenario(port: UsbPort, board: RecordingHost, kernel: FakeKernel) -> None:
        assert kernel.host.descriptors[3, 3][2:].decode("utf-16-le") == "A-1"
        assert (tmp_path / "board").is_symlink()

    run(tmp_path, scenario, options=Options(serial_number="A-1", path="board"))
