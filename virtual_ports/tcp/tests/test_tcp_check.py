"""Ports of the kind ``tcp`` pass the shipped check of ports."""

import pytest

from hil.testing import check_port
from hil.vocab.ports import PortContext
from virtual_ports.tcp.port import Options, make


@pytest.mark.long
def test_they_keep_to_what_ports_keep_to() -> None:
    check_port(lambda folder: make(Options(), PortContext("b", "m1", folder)))
