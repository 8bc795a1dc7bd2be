"""Zenoh bridge of a bench in memory: it answers and publishes to sessions without a network."""

from typing import Any

import zenoh

from bridges.zenoh.bench_session import Joined
from bridges.zenoh.command_handler import Work
from bridges.zenoh.keys import prefix
from bridges.zenoh.options import Options
from bridges.zenoh.sender import DirectSender, Senders
from bridges.zenoh.testing.memory_network import MemoryNetwork
from bridges.zenoh.testing.memory_session import MemorySession
from hil.testing.doors.door_time import DoorTime
from hil.vocab.desk_protocol import Desk

LOOK_NS = 1_000_000
"""Longest time for which packets of a segment wait until subscribers hear them."""


class MemoryZenohDoor:
    """Door of a bench for sessions in memory. Its users and certificates are not checked: everybody may do
    all."""

    def __init__(self, options: Options, desk: Desk, time: DoorTime) -> None:
        self._options, self._desk, self._time = options, desk, time
        self._prefix = prefix(desk.describe().bench)
        self._network = MemoryNetwork(time)
        self._sessions: list[MemorySession] = []
        self._work = Work()
        self._joined: Joined | None = None

    async def open(self) -> None:
        """Let the bridge answer."""
        senders = Senders(DirectSender)
        bridge: Any = MemorySession(self._network)
        self._joined = Joined(bridge, None, self._desk, self._options, senders, self._work, "0", lambda: 0.0)

    def session(self) -> MemorySession:
        """Open a session."""
        made = MemorySession(self._network, self._subscribing)
        self._sessions.append(made)
        return made

    def _subscribing(self, key: zenoh.KeyExpr) -> None:
        """Look often enough for who hears packets. Raises zenoh.ZError: there is nothing to hear."""
        if zenoh.KeyExpr(f"{self._prefix}/port/**").includes(key):
            raise zenoh.ZError(
                f"{key}: in memory ports publish no bytes; use port() or capture() of the bench"
            )
        if zenoh.KeyExpr(f"{self._prefix}/segment/*/packets").intersects(key):
            self._time.look_ns = LOOK_NS

    def close(self) -> None:
        """End the bridge's part, and all sessions."""
        joined, self._joined = self._joined, None
        if joined:
            self._time.loop.complete(self._leave(joined))
        for each in self._sessions:
            each.close()

    async def _leave(self, joined: Joined) -> None:
        joined.inbox.close()
        await joined.publications.stop()
        await self._work.close()
        joined.undeclare()
