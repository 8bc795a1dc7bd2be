"""Shipped check of bridges, passed by the Modbus bridge."""

import asyncio

import pytest
from served_door import WAVE, desk, packet

from bridges.modbus.bridge import Options, make
from hil.testing import check_bridge
from hil.vocab.bridge_protocol import BridgeError


@pytest.mark.parametrize("units", [{"m1": 1, "m2": 1}, {"m9": 1}])
def test_units_that_cannot_be_are_refused_without_a_check_of_the_configuration(units: dict[str, int]) -> None:
    bridge = make(Options(listen="127.0.0.1:0", units=units), desk())
    with pytest.raises(BridgeError, match="units: "):
        asyncio.run(bridge.open())


@pytest.mark.thorough
@pytest.mark.long
def test_it_keeps_to_what_bridges_keep_to() -> None:
    options = Options(listen="127.0.0.1:0")
    check_bridge(lambda desk: make(options, desk), request=packet(WAVE), desk=desk)
