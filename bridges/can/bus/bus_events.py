"""News of a CAN bus for nodes and watchers: frames, errors and states, with the bus's times."""

from enum import StrEnum
from typing import NamedTuple, Protocol

from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import SimTimeNs

MAILBOXES = 64
"""Frames of a node that may wait. Decision: as many as message buffers of a large controller."""


class NodeState(StrEnum):
    """State of fault confinement; of a node without power ``OFF``."""

    ACTIVE = "error-active"
    PASSIVE = "error-passive"
    BUS_OFF = "bus-off"
    OFF = "off"


class MailboxesFull(Exception):
    """No mailbox is free: the frame is not taken."""


class CanFilter(NamedTuple):
    """Frames that a node wants: those whose identifier has the bits of ``id`` where ``mask`` has ones."""

    id: int
    mask: int
    is_extended: bool = False

    def wants(self, frame: CanFrame) -> bool:
        return frame.is_extended == self.is_extended and (frame.id ^ self.id) & self.mask == 0


class CanListener(Protocol):
    """Listener to a node's life. It may send, and inject faults, at once."""

    def hear(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Take a frame of another node: the times of its start of frame, and of the end of its last bit."""

    def sent(self, frame: CanFrame, start_ns: SimTimeNs, end_ns: SimTimeNs) -> None:
        """Learn that a frame was sent, and that somebody has acknowledged it."""

    def changed(self, state: NodeState, at_ns: SimTimeNs) -> None:
        """Learn that the node has become error-active, error-passive or bus-off."""


class BusEvent(NamedTuple):
    """Event on the bus: a frame, whose last bit ended at ``at_ns``; or an error, found at that time; or
    the state that a node has taken. ``node``: who sent it, found it, or has become it. ``error``: bit, stuff,
    CRC, form, acknowledgement."""

    start_ns: SimTimeNs
    at_ns: SimTimeNs
    node: str
    frame: CanFrame | None = None
    error: str = ""
    state: str = ""
