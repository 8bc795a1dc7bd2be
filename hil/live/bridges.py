"""Bridges of a bench that are open."""

import logging
from collections.abc import Callable, Collection, Mapping
from typing import Any

from hil.compose.find import make_bridge, make_door_port
from hil.vocab.bridge_protocol import Bridge, BridgeError, PortDoor
from hil.vocab.desk_protocol import Desk
from hil.vocab.ports import PortContext

log = logging.getLogger("hil")


class Bridges(dict[str, Bridge]):
    """Bridges by kind, in the order of the configuration. ``context``: of a port of this name."""

    def __init__(self, context: Callable[[str], PortContext]) -> None:
        super().__init__()
        self._context = context

    async def open(self, wanted: Mapping[str, Any], desk: Desk) -> None:
        """Open the bridges that the configuration wants. Raises BridgeError: says which cannot be opened."""
        for kind, options in wanted.items():
            bridge = make_bridge(kind, options, desk)
            if isinstance(bridge, PortDoor):
                ports = bridge.wanted_ports()
                bridge.take_ports([make_door_port(port, self._context(port.name)) for port in ports])
            try:
                await bridge.open()
            except BridgeError as error:
                raise BridgeError(f"bridges.{kind}: {error}") from None
            self[kind] = bridge

    async def close(self) -> None:
        for bridge in self.values():
            await bridge.close()

    async def exchanged(self, names: Collection[str]) -> None:
        """Note that these devices were added, removed or exchanged, and that what has gone is closed."""
        for kind, bridge in self.items():
            try:
                await bridge.devices_changed(names)
            except BridgeError as error:
                log.error("%s: it does not know of all devices: %s", kind, error)
