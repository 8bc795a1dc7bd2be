"""One channel: a node of a simulated bus, which sends what programs outside give, and tells them what the
others on the bus send."""

import asyncio
import logging
from collections.abc import Mapping, Sequence
from typing import Any

from bridges.can.bus.bus_events import BusEvent
from bridges.can.channels.channel_medium import AT_A_TIME, Medium
from bridges.can.channels.channel_options import Channel
from bridges.can.channels.python_can_medium import PythonCanMedium
from bridges.can.channels.udp_medium import UdpMedium
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.address import Address
from hil.vocab.bridge_protocol import BridgeError
from hil.vocab.desk_protocol import Desk, Source, Watch, Watched
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import Role, VerbRefused

log = logging.getLogger("hil")


def medium_of(channel: Channel, bus: str) -> Medium:
    """Make the medium of a channel, not yet open."""
    if channel.interface == "udp_multicast":
        return UdpMedium(channel.group, channel.port, is_open=channel.insecure)
    return PythonCanMedium(channel.interface, channel.channel or bus)


class BusChannel:
    """Channel of a bus, whose node is at an address there. ``medium``: the way to its programs."""

    def __init__(self, desk: Desk, node: Address, channel: Channel, medium: Medium | None = None) -> None:
        self._desk = desk
        bus, self._name = node
        self._bus = bus
        self._medium = medium or medium_of(channel, bus)
        self.about = channel.medium(bus)
        self._source = Source(f"CAN {self.about}", Role.OPERATOR, door="can")
        self._clock = desk.describe().clock
        self._watch: Watch | None = None
        self.node = ""
        self._free = 0
        """Number of frames that the node takes now."""
        self._is_held = False
        self.came = self.went = self.refused = self.dropped = 0
        """Frames from outside, frames to there, those from outside that found no room on the bus or were
        refused, and those to there that found none."""

    @property
    def is_open(self) -> bool:
        return bool(self.node) and not self._medium.failure

    async def open(self) -> None:
        """Open the channel, and go on the bus. Raises BridgeError."""
        self._medium.open(asyncio.get_running_loop(), self._take)
        try:
            answer = self._desk.ask(self._source, "attach", self._bus, {"node": self._name}).answer
            self.node, self._free = answer["node"], answer["free"]
            self._watch = self._desk.watch(self._source, Watched.FRAMES, self._bus, self._carried)
        except VerbRefused as refusal:
            await self.close()
            raise BridgeError(f"{self._bus}: {refusal}") from None

    async def close(self) -> None:
        if self._watch:
            self._watch.close()
        await self._medium.close()
        if self.node:
            try:
                self._desk.ask(self._source, "detach", self.node, {})
            except VerbRefused as refusal:
                log.warning("can: %s: %s", self.node, refusal)
        self._watch, self.node = None, ""

    def status(self) -> Mapping[str, Any]:
        """Counters, for JSON."""
        medium = self._medium
        return {
            "node": self.node,
            "medium": self.about,
            "failure": medium.failure or None,
            "in": self.came,
            "out": self.went,
            "refused": self.refused + medium.rejected,
            "strangers": medium.strangers,
            "dropped": self.dropped,
        }

    def _take(self, frames: Sequence[CanFrame]) -> None:
        """Give frames of programs to the node; where it has no room for more, they wait outside."""
        self.came += len(frames)
        try:
            given = {"frames": [str(frame) for frame in frames]}
            answer = self._desk.ask(self._source, "transmit", self.node, given).answer
        except VerbRefused:
            self.refused += len(frames)
            return
        self.refused += answer["refused"]
        self._free = answer["free"]
        if self._free < AT_A_TIME and not self._is_held:
            self._is_held = True
            self._medium.hold(True)

    def _carried(self, event: BusEvent) -> None:
        """Tell programs of a frame on the bus. It is called within the bus's own time: nothing may be asked
        here."""
        if event.frame is None:
            return
        if event.node == self.node:
            self._free += 1
            if self._is_held and self._free >= 2 * AT_A_TIME:
                self._is_held = False
                self._medium.hold(False)
            return
        if self._medium.send(event.frame, self._clock.wall_ns(event.at_ns) / NS_PER_S):
            self.went += 1
        else:
            self.dropped += 1
