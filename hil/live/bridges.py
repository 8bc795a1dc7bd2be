"""Bridges of a bench that are open."""

import logging
from collections.abc import Callable, Collection

from hil.compose.find import make_bridge, make_door_port
from hil.config import BenchConfig
from hil.config.bridge_findings import BRIDGES
from hil.config.document import KeyPath
from hil.net.endpoint import has_port
from hil.net.listeners import why_refused
from hil.vocab.bridge_protocol import Bridge, BridgeError, PortDoor
from hil.vocab.desk_protocol import Desk
from hil.vocab.ports import PortContext

log = logging.getLogger("hil")


async def closed_doors(config: BenchConfig) -> list[str]:
    """Find the bridges that could not listen now, for a start that fails anyway; a line for each."""
    problems = []
    for kind, options in config.bridges.items():
        listens = getattr(options, "listen", None)
        if isinstance(listens, str):
            listens = [listens] if has_port(listens) else []
        for at, listen in enumerate(listens or []):
            transport, slash, address = listen.rpartition("/")  # as zenoh writes it
            if (not slash or transport in ("tcp", "tls")) and (refused := await why_refused(address)):
                path: KeyPath = (BRIDGES, kind, "listen", at) if slash else (BRIDGES, kind, "listen")
                problems.append(config.written.placed(path, str(refused)))
    return problems


class Bridges(dict[str, Bridge]):
    """Bridges by kind, in the order of the configuration. ``context``: of a port of this name."""

    def __init__(self, context: Callable[[str], PortContext]) -> None:
        super().__init__()
        self._context = context

    async def open(self, config: BenchConfig, desk: Desk) -> None:
        """Open the bridges that the configuration wants. Raises BridgeError: says which cannot be opened, a
        line for each."""
        problems: list[str] = []
        for kind, options in config.bridges.items():
            bridge = make_bridge(kind, options, desk)
            if isinstance(bridge, PortDoor):
                ports = bridge.wanted_ports()
                bridge.take_ports([make_door_port(port, self._context(port.name)) for port in ports])
            try:
                await bridge.open()
                self[kind] = bridge
            except BridgeError as error:
                path = (BRIDGES, kind, *error.option)
                problems.append(config.written.placed(path, str(error)))
        if problems:
            raise BridgeError("\n".join(problems))

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
