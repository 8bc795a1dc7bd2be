"""CAN bus as a bench sees it: nodes send on it, and hear each other with the bus's times."""

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import Any, NamedTuple, Protocol

from bridges.can.frames.can_frame import CanFrame
from hil.vocab.faults import Fault
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


class CanBus(Protocol):
    """Bus with nodes, each under its name. Only what happens in the time of its group calls these."""

    bit_rate: int
    """Bits per second."""
    watchers: list[Callable[[BusEvent], None]]
    """Called with all that is on the bus, in order, at the time of its end."""

    @property
    def nodes(self) -> Mapping[str, object]:
        """Nodes by name."""

    def join(
        self,
        name: str,
        listener: CanListener,
        *,
        filters: Sequence[CanFilter] | None = None,
        mailboxes: int = MAILBOXES,
        is_on: bool = True,
    ) -> None:
        """Put a node on the bus. ``filters``: frames that it is told of; None: of all. ``mailboxes``: frames
        that may wait. ``is_on``: it has power."""

    def set_filters(self, name: str, filters: Sequence[CanFilter] | None) -> None: ...
    def set_listening(self, name: str, is_listening: bool) -> None:
        """Set whether a node never drives the wire, not even to acknowledge."""

    def switch_on(self, name: str, bit_rate: int = 0) -> None:
        """Start a node's controller again, with its error counters at 0. ``bit_rate``: its own; 0: the
        bus's."""

    def switch_off(self, name: str) -> None:
        """Take the power from a node's controller: what it has to send is lost."""

    def send(self, name: str, frame: CanFrame) -> None:
        """Send a frame from a node when the bus lets it, again and again until somebody acknowledges it.

        Raises:
            MailboxesFull: too many wait already.
            ValueError: the frame cannot be sent.
        """

    def free_mailboxes(self, name: str) -> int:
        """Number of frames that a node may give to its controller now."""

    def waiting(self, name: str) -> int:
        """Number of frames of a node that are not sent yet."""

    def tally(self, name: str) -> tuple[int, int]:
        """Number of errors that a node has found, and how often it has given way to a more urgent frame."""

    def state(self, name: str) -> NodeState:
        """State of a node now."""

    def error_counters(self, name: str) -> tuple[int, int]:
        """Transmit and receive error counter of a node."""

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""


class CanFaults(Protocol):
    """Faults of a bus, by the numbers that they were injected under."""

    def inject(self, number: int, fault: Fault, name: str = "") -> None:
        """Begin a fault of the bus, or of a node on it.

        Raises:
            ValueError: a kind that a bus does not have, or a bit rate out of range.
        """

    def clear(self, number: int, fault: Fault, name: str = "") -> None:
        """End a fault."""
