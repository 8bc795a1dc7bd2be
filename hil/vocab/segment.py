"""What an RS485 segment is to a bench: stations transmit on it, and hear each other with the line's times."""

from typing import Protocol

from hil.vocab.time import SimTimeNs


class Receiver(Protocol):
    """A station's receiving half."""

    def hear(self, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """Bytes that stand back to back on the line from ``start_ns`` on, at the sender's baud."""


class Segment(Protocol):
    """A wire with stations, each under its name."""

    def join(self, station: str, receiver: Receiver) -> None:
        """Put a station on the wire."""

    def transmit(self, station: str, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """A station sends a burst; its first start bit is at ``start_ns``, now or a little later."""
