"""Faces of a tap and of a channel's node towards what is in front of them, whatever wire is behind."""

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Protocol, runtime_checkable

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


class ClientChannel(ClientTap):
    """Node of a channel, a tap that takes frames, which are texts here."""

    refused: int
    """Number of frames that came when too many waited, or the node was off the wire."""

    @property
    @abstractmethod
    def free(self) -> int:
        """Number of frames that may come now."""

    @abstractmethod
    def frames_problem(self, frames: Sequence[str]) -> str | None:
        """Reason why texts from outside cannot be frames, or None."""


@runtime_checkable
class HasChannels(Protocol):
    """Wire that may have channels."""

    def channel(self, label: str) -> ClientTap:
        """Put a channel's node on the wire."""

    def channel_problem(self, label: str, taps: Iterable[ClientTap]) -> str | None:
        """Reason why there cannot be a channel's node of this address beside the bench's taps, or None."""
