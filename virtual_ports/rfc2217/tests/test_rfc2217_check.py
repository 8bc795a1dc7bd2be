"""Ports of the kind ``rfc2217`` pass the shipped check of ports."""

import pytest

from hil.testing import check_port
from hil.testing.checks.port_ends import FileClient
from hil.vocab.ports import Port, PortContext
from virtual_ports.rfc2217.port import Options, make
from virtual_ports.rfc2217.telnet import Telnet

HELLO = Telnet("").hello


class Plain:
    """Client that overhears what it is offered, and doubles each 255."""

    def __init__(self, port: Port) -> None:
        self._line = FileClient.of(port)
        self._offered = HELLO

    def send(self, data: bytes) -> int:
        """Send whole bytes: the socket takes these few at once."""
        escaped = data.replace(b"\xff", b"\xff\xff")
        sent = self._line.send(escaped)
        assert sent in (0, len(escaped))
        return len(data) if sent else 0

    def read(self) -> bytes:
        data = self._line.read()
        offered, data = data[: len(self._offered)], data[len(self._offered) :]
        assert self._offered.startswith(offered)
        self._offered = self._offered[len(offered) :]
        return data.replace(b"\xff\xff", b"\xff")

    def close(self) -> None:
        self._line.close()


@pytest.mark.long
def test_they_keep_to_what_ports_keep_to() -> None:
    check_port(lambda folder: make(Options(), PortContext("b", "m1", folder)), Plain)
