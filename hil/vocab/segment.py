"""What an RS485 segment is to a bench: stations transmit on it, and hear each other with the line's times."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs


class HeardCharacter(Protocol):
    """One that a receiver reads: complete at ``at_ns``; a framing error if its stop bit was low."""

    @property
    def at_ns(self) -> int: ...
    @property
    def byte(self) -> int: ...
    @property
    def is_framing_error(self) -> bool: ...


class Receiver(Protocol):
    """A station's receiving half."""

    @property
    def baud_now(self) -> int:
        """The speed that it reads at."""

    def hear(self, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """Bytes that stand back to back on the line from ``start_ns`` on, at the sender's baud."""

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        """What a disturbed line reads as."""

    def retract(self, after_ns: SimTimeNs) -> None:
        """What was told of and would be complete after this time does not come."""


@dataclass(frozen=True)
class SegmentEvent:
    """What has been on a wire: a burst as it was sent, or what a disturbed line read as. ``about``: by whom,
    and what was wrong."""

    at_ns: SimTimeNs
    data: bytes
    about: str
    is_damaged: bool = False


class SegmentView(Protocol):
    """A wire with stations, for whoever looks: nothing here moves the line on or changes what is heard."""

    watchers: list[Callable[[SegmentEvent], None]]
    """Called with what has been on the wire to its end, in order, at that time of the segment's group; in
    pieces, as they come, of a disturbance that is long."""

    def has(self, station: str) -> bool:
        """Whether a station is on the wire."""

    def baud_of(self, station: str) -> int:
        """The speed of a station, in baud."""

    def clashes(self) -> Mapping[int, list[str]]:
        """Addresses that several stations have."""

    def clashes_with(self, address: int, but: str) -> list[str]:
        """Stations on the line, but one, that have an address."""

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""


class Segment(SegmentView, Protocol):
    """A wire with stations, each under its name. Only what happens in the time of its group calls these."""

    def join(self, station: str, receiver: Receiver) -> None:
        """Put a station on the wire."""

    def set_address(self, station: str, address: int | None) -> None:
        """From now on only packets to this address and to all concern the station; None: everything."""

    def set_polling(self, station: str, is_polling: bool) -> None:
        """Whether a station's firmware takes bytes as they come. While it does not, each counts for its
        buffer, and the station is told of those for others too."""

    def set_echo(self, station: str, has_echo: bool) -> None:
        """Whether a station hears what it sends."""

    def transmit(self, station: str, start_ns: SimTimeNs, data: bytes, baud: int) -> None:
        """A station sends a burst, whose first start bit is at ``start_ns``: until then nothing happens."""

    def set_cut(self, station: str, is_cut: bool) -> None:
        """Take a station off the line, or put it back."""

    def inject(
        self, number: int, fault: Fault, station: str, answer: Callable[[int, str, bytes], None]
    ) -> None:
        """A fault of the layers packet or wire, or ``node_clash``, begins. ``answer(at_ns, station, raw)``
        sends for a station at a later time."""

    def clear(self, number: int, fault: Fault, station: str) -> None:
        """A fault ends."""
