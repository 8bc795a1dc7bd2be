"""The bridges of a bench that are open."""

import logging
from collections.abc import Iterator, Mapping
from typing import Any

from hil.compose.find import make_bridge
from hil.live.changes import Changed, Changes
from hil.vocab.bridges import Bridge, BridgeError, Desk

log = logging.getLogger("hil")


class Bridges(Mapping[str, Bridge]):
    """By kind, in the order of the configuration."""

    def __init__(self, changes: Changes) -> None:
        self._open: dict[str, Bridge] = {}
        changes.afterwards(self._exchange)

    def __getitem__(self, kind: str) -> Bridge:
        return self._open[kind]

    def __iter__(self) -> Iterator[str]:
        return iter(self._open)

    def __len__(self) -> int:
        return len(self._open)

    async def open(self, wanted: Mapping[str, Any], desk: Desk) -> None:
        """Open those that the configuration wants.

        Raises:
            BridgeError: one cannot be opened; says which.
        """
        for kind, options in wanted.items():
            bridge = make_bridge(kind, options, desk)
            try:
                await bridge.open()
            except BridgeError as error:
                raise BridgeError(f"bridges.{kind}: {error}") from None
            self._open[kind] = bridge

    async def close(self) -> None:
        for bridge in self._open.values():
            await bridge.close()

    async def _exchange(self, changed: Changed) -> None:
        names = [*changed.removed, *changed.begun]
        for kind, bridge in self._open.items():
            try:
                await bridge.devices_changed(names)
            except BridgeError as error:
                log.error("%s: it does not know of all devices: %s", kind, error)
