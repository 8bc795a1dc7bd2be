"""Port of the kind ``usb``, at a kernel in Python."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from fake_vhci import FakeKernel

from hil.testing.ports import RecordingHost, accounted, until
from hil.vocab.ports import ADAPTER, PortContext, PortError, UsbIdentity
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
