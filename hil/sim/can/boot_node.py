"""Stand-in for a node: it boots, and tells so."""

from collections.abc import Callable, Sequence
from typing import Any

from hil.wire.can.can_frame import CanFrame

HEARTBEAT_NS = 10**9


class BootNode:
    def __init__(self, node_id: int, send: Callable[[CanFrame], None]) -> None:
        self.node_id, self._send = node_id, send
        self.due_ns: int = 2**63 - 1
        self.can_ids: Sequence[int] = (0, 0x600 + node_id)

    def hear(self, frame: CanFrame, now_ns: int) -> None: ...
    def bus_off(self, now_ns: int) -> None: ...
    def bus_on(self, now_ns: int) -> None: ...
    def power_up(self, now_ns: int) -> None:
        self._send(CanFrame(0x700 + self.node_id, b"\0"))
        self.due_ns = now_ns + HEARTBEAT_NS

    def step(self, now_ns: int) -> None:
        self._send(CanFrame(0x700 + self.node_id, b"\x7f"))
        self.due_ns = now_ns + HEARTBEAT_NS

    def counters(self) -> dict[str, Any]:
        return {"state": "pre-operational"}
