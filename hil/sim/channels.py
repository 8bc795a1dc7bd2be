"""Channels of a wire: nodes without devices, from which programs outside send frames."""

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from typing import Protocol, runtime_checkable

from hil.sim.client_tap import ClientTap


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
