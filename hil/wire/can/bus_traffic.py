"""What was on a bus, as those who look on are told of it."""

from typing import Protocol

from hil.vocab.time import SimTimeNs
from hil.wire.can.can_frame import CanFrame


class BusTraffic(Protocol):
    """Frame, whose last bit ended at ``at_ns``; or an error, or a node's new state, at that time."""

    @property
    def at_ns(self) -> SimTimeNs: ...
    @property
    def node(self) -> str:
        """Node that sent it, found it, or has become it."""

    @property
    def frame(self) -> CanFrame | None: ...
    @property
    def error(self) -> str:
        """Kind of error: bit, stuff, CRC, form, acknowledgement; empty: there is none."""

    @property
    def state(self) -> str:
        """State that a node has taken: error-active, error-passive, bus-off; empty: none is new."""
