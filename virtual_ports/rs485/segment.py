"""An RS485 wire: what one station sends, all others hear."""

from hil.vocab.segment import Receiver
from hil.vocab.time import SimTimeNs


class Segment:
    """Stations on one wire. Not modelled yet: collisions (two that send at once are both heard)."""

    def __init__(self) -> None:
        self._receivers: dict[str, Receiver] = {}

    def join(self, station: str, receiver: Receiver) -> None:
        """Put a station on the wire."""
        self._receivers[station] = receiver

    def transmit(self, station: str, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """A station sends a burst; its first start bit is at ``start_ns``."""
        for name, receiver in self._receivers.items():
            if name != station:
                receiver.hear(start_ns, data, baud)
