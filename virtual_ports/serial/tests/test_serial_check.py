"""Ports of the kind ``serial`` pass the shipped check of ports, as clients of a line."""

import os
import tty
from pathlib import Path

import pytest

from hil.testing import check_port
from hil.testing.checks.port_ends import FileClient
from hil.vocab.ports import Port, PortContext
from virtual_ports.serial.port import Options, make


class Lines:
    """Boards' ends of the lines that ports were made for."""

    def __init__(self) -> None:
        self._masters: dict[Port, int] = {}

    def port(self, folder: Path) -> Port:
        master, slave = os.openpty()
        tty.setraw(slave)
        port = make(Options(url=os.ttyname(slave), baud=38400), PortContext("b", "m2", folder))
        os.close(slave)
        self._masters[port] = master
        return port

    def board(self, port: Port) -> FileClient:
        return FileClient(self._masters.pop(port))


@pytest.mark.long
def test_they_keep_to_what_ports_keep_to() -> None:
    lines = Lines()
    check_port(lines.port, lines.board, calls_out=True)
