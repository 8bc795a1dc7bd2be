"""Shipped check of bridges, passed by the Modbus bridge."""

from served_door import WAVE, desk, packet

from bridges.modbus.bridge import Options, make
from hil.testing import check_bridge


def test_it_keeps_to_what_bridges_keep_to() -> None:
    options = Options(listen="127.0.0.1:0")
    check_bridge(lambda desk: make(options, desk), request=packet(WAVE), desk=desk)
