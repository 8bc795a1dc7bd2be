"""Face of a tap towards the port in front of it, whatever wire is behind it."""

from collections.abc import Callable, Mapping
from typing import Protocol

from hil.sim.inputs import Input
from hil.vocab.time import SimTimeNs


class ClientTap(Protocol):
    """Tap of a segment, or of a CAN bus. What it says to a client waits, with its times, until ``drain``."""

    name: str
    listeners: list[Callable[[], None]]
    """Called when there is something to take, or room again."""

    @property
    def speed(self) -> str:
        """Speed of the wire, for people."""

    @property
    def notes(self) -> Mapping[int, str]:
        """Notes for the operator, by what they are about."""

    def apply(self, given: Input, now_ns: SimTimeNs) -> None:
        """Let an input take effect."""

    def room(self, now_ns: SimTimeNs) -> int:
        """Number of bytes that may be taken from a client."""

    @property
    def room_ns(self) -> SimTimeNs:
        """Time at which there is room, as far as time alone brings it."""

    def drain(self, until_ns: int) -> bytes:
        """Take what is for the client up to a time."""

    @property
    def next_ns(self) -> SimTimeNs:
        """Time of what can be taken next."""
