"""The bridges of a bench that are open."""

import logging
from collections.abc import Collection, Mapping
from typing import Any

from hil.compose.find import make_bridge
from hil.vocab.bridge_protocol import Bridge, BridgeError
from hil.vocab.desk_protocol import Desk

log = logging.getLogger("hil")


class Bridges(dict[str, Bridge]):
    """By kind, in the order of the configuration."""

    async def open(self, wanted: Mapping[str, Any], desk: Desk) -> None:
        """Open those that the configuration wants. Raises BridgeError: one cannot be opened; says which."""
        for kind, options in wanted.items():
            bridge = make_bridge(kind, options, desk)
            try:
                await bridge.open()
            except BridgeError as error:
                raise BridgeError(f"bridges.{kind}: {error}") from None
            self[kind] = bridge

    async def close(self) -> None:
        for bridge in self.values():
            await bridge.close()

    async def exchanged(self, names: Collection[str]) -> None:
        """These devices were added, taken away or exchanged, and what has gone is closed."""
        for kind, bridge in self.items():
            try:
                await bridge.devices_changed(names)
            except BridgeError as error:
                log.error("%s: it does not know of all devices: %s", kind, error)
