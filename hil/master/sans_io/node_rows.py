"""Rows of the nodes on a master's line, and what the nodes say by themselves."""

from dataclasses import dataclass
from typing import NamedTuple


class NodeEvent(NamedTuple):
    """Something that a node said by itself. ``kind``: the signal's name, or ``stray``, an answer to nothing
    that is under way."""

    at_ns: int
    node: int
    kind: str
    text: str


@dataclass
class NodeRow:
    """Node of a line. Times are the master's; None: not known."""

    address: int
    first_seen_ns: int | None = None
    seen_ns: int | None = None
    round_trip_ns: int | None = None
    """Time from the last packet that it took to its answer's end."""
    sent: int = 0
    """Number of packets that went out to it."""
    lost: int = 0
    """Number of packets to it without an answer."""
    refusals: int = 0
    strays: int = 0
    """Number of its answers that belong to nothing."""
    tells: bool = False
    """True if it tells when commands begin and end."""
    is_moving: bool | None = None
    begun_ns: int | None = None
    command_ns: int | None = None
    """Time that its last command took, from begin to end."""
    begun: int = 0
    ended: int = 0
    """Number of commands that it told of."""
    text: str = ""
    """Last words for people."""

    @property
    def is_there(self) -> bool:
        return self.seen_ns is not None

    @property
    def state(self) -> str:
        """State by what it tells: ``moving``, ``standing``; ``not known``: it tells nothing."""
        if self.is_moving is None:
            return "not known"
        return "moving" if self.is_moving else "standing"

    def seen(self, at_ns: int) -> None:
        self.seen_ns = at_ns
        if self.first_seen_ns is None:
            self.first_seen_ns = at_ns

    def begins(self, at_ns: int) -> None:
        self.tells, self.is_moving, self.begun_ns = True, True, at_ns
        self.begun += 1

    def ends(self, at_ns: int) -> None:
        self.command_ns = None if self.begun_ns is None else at_ns - self.begun_ns
        self.tells, self.is_moving, self.begun_ns = True, False, None
        self.ended += 1
