"""Ports of the kind ``usb`` pass the shipped check of ports, at a kernel in Python."""

from pathlib import Path

import pytest
from fake_vhci import FakeKernel

from hil.testing import check_port
from hil.vocab.ports import Port, PortContext
from virtual_ports.usb.usb_options import Options
from virtual_ports.usb.usb_port import UsbPort


class Kernels:
    """Kernels that ports were plugged into."""

    def __init__(self) -> None:
        self._kernels: dict[Port, FakeKernel] = {}

    def port(self, folder: Path) -> Port:
        kernel = FakeKernel()
        port = UsbPort(Options(), PortContext("b", "m1", folder), kernel.attach)
        self._kernels[port] = kernel
        return port

    def program(self, port: Port) -> "Program":
        return Program(self._kernels[port])


class Program:
    """Program with the tty open."""

    def __init__(self, kernel: FakeKernel) -> None:
        self._host, self._step = kernel.host, kernel.plugged[-1].step
        self._host.open()
        self._step()

    def send(self, data: bytes) -> int:
        if self._host.unwritten:
            return 0
        self._host.write(data)
        self._step()
        return len(data)

    def read(self) -> bytes:
        if self._host.is_throttled:
            self._host.unthrottle()
            self._step()
        return self._host.read()

    def close(self) -> None:
        self._host.close()
        self._step()


@pytest.mark.long
def test_they_keep_to_what_ports_keep_to() -> None:
    kernels = Kernels()
    check_port(kernels.port, kernels.program)
