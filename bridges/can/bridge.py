"""Channels of CAN buses: opens what its options say, and tells its status."""

import logging
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from bridges.can.channels.channel_options import UDP_GROUP, UDP_PORT, Options
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Desk

if TYPE_CHECKING:
    from bridges.can.channels.bus_channel import BusChannel

__all__ = ["Options", "make", "reference"]

log = logging.getLogger("hil")

RISK = "every program that can reach it can send on the bus and move all drives"


class CanBridge:
    """CAN bridge, a ``hil.vocab.bridge_protocol.Bridge``."""

    def __init__(self, options: Options, desk: Desk) -> None:
        self._options, self._desk = options, desk
        self._channels: list[BusChannel] = []

    async def open(self) -> None:
        from bridges.can.channels.bus_channel import BusChannel  # python-can, for who has a channel alone

        for key, node in self._options.nodes().items():
            options = self._options.channels[key]
            channel = BusChannel(self._desk, node, options)
            try:
                await channel.open()
            except BridgeError as error:
                await self.close()
                raise BridgeError(f"channels.{key}: {error}") from None
            self._channels.append(channel)
            if options.insecure:
                log.warning("bridges.can: insecure: %s (%s)", RISK, channel.about)

    async def close(self) -> None:
        for channel in self._channels:
            await channel.close()
        self._channels.clear()

    async def devices_changed(self, names: Collection[str]) -> None:
        """Ignored: a bus and its nodes are there as long as the bench."""

    def status(self) -> Mapping[str, Any]:
        rows = [channel.status() for channel in self._channels]
        media = {
            self._options.channels[key].medium(node.owner): self._options.channels[key].interface
            for key, node in self._options.nodes().items()
        }
        in_groups = [medium for medium, interface in media.items() if interface == "udp_multicast"]
        return {
            "root": "can",
            "listen": in_groups,
            "connect": [medium for medium in media if medium not in in_groups],
            "links": sum(channel.is_open for channel in self._channels),
            "commands": sum(row["in"] for row in rows),
            "rejected": sum(row["refused"] + row["strangers"] for row in rows),
            "dropped": sum(row["dropped"] for row in rows),
            "insecure": self._options.is_open,
            "risk": RISK,
            "channels": rows,
        }


make = CanBridge


def reference() -> str:
    """Part of the reference about channels."""
    return (
        "## The CAN bridge\n\n"
        "A channel is a node of its bus, `can0.udp_multicast`: it acknowledges, takes part in the arbitration"
        " and can have faults. What a program sends is an input, stands in the input log, and goes on the"
        " bus in its order, each frame when the bus lets it. What other nodes send goes to the programs,"
        " with the time of its last bit. Error frames and frames of CAN FD are not carried.\n\n"
        f"`udp_multicast` is python-can's, at {UDP_GROUP}:{UDP_PORT} if nothing else is said; without"
        " `insecure: true` only programs of this computer are heard, and frames do not leave it."
        " `socketcan` needs a kernel with CAN sockets. `virtual` reaches programs in the daemon's own"
        " process alone, as tests are.\n\n"
        "Of each channel `hil status --json` has `in`, `out`, `refused` (from outside: no frame of classic"
        " CAN, or no room), `strangers` (from other computers, not let in) and `dropped` (to outside: no"
        " room).\n"
    )
