"""RS485 segment as a bench sees it: stations transmit on it, and hear each other with the line's times."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

from hil.vocab.framing import Framing, Item
from hil.vocab.late_dataclass import dataclass
from hil.vocab.line_format import LineFormat
from hil.vocab.time import SimTimeNs
from hil.vocab.wire import Wire

_NAMED = 4
"""Maximum number of stations of one speed that a note names."""
_TOLERATED = 0.04
"""Difference of speeds at which a receiver still reads what is sent: half a bit at a frame's end is 5 %. A
Uno at 115200 baud is 2.1 % fast."""


class HeardCharacter(NamedTuple):
    """Character that a receiver reads, complete at ``at_ns``: its stop bit was sampled to the end. A framing
    error if that bit was low, a parity error if its parity bit was wrong."""

    at_ns: int
    byte: int
    is_framing_error: bool
    is_parity_error: bool = False


class Receiver(Protocol):
    """A station's receiving half. One whose program sets the format of its characters has ``FormatReceiver``,
    too."""

    @property
    def baud_now(self) -> int:
        """Speed at which it reads, in baud."""

    def hear(
        self, start_ns: SimTimeNs, data: bytes, baud: int, packets: Sequence[Item] | None = None
    ) -> None:
        """Hear bytes that stand back to back on the line from ``start_ns`` on, at the sender's baud.
        ``packets``: what they are by the line's framing, if they are whole packets for everybody."""

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        """Hear the characters that a disturbed line reads as."""

    def retract(self, after_ns: SimTimeNs) -> None:
        """Take back what was announced and would be complete after this time."""


@runtime_checkable
class FormatReceiver(Protocol):
    """Receiver whose characters may have another format than the line's. Beside ``Receiver``."""

    @property
    def format_now(self) -> LineFormat | None:
        """Format in which it reads; None: the line's."""


@dataclass(frozen=True)
class SegmentEvent:
    """Traffic that has been on a wire: a burst as it was sent, or what a disturbed line read as. ``about``:
    by whom, and what was wrong."""

    at_ns: SimTimeNs
    data: bytes
    about: str
    is_damaged: bool = False


class SegmentView(Protocol):
    """Read-only view of a wire with stations: nothing here moves the line on or changes what is heard."""

    watchers: list[Callable[[SegmentEvent], None]]
    """Called with what has been on the wire to its end, in order, at that time of the segment's group; in
    pieces, as they come, of a disturbance that is long."""

    @property
    def framing(self) -> Framing:
        """Framing of the bytes on the wire."""

    @property
    def line_format(self) -> LineFormat:
        """Format of the characters on the wire."""

    @property
    def baud(self) -> int:
        """Speed of the station that was there first, in baud; 0: there is none."""

    def has(self, station: str) -> bool:
        """True if a station is on the wire."""

    def baud_of(self, station: str) -> int:
        """Speed of a station, in baud."""

    def speeds(self) -> Mapping[str, int]:
        """Speeds of all stations now, in baud."""

    def addresses(self) -> Mapping[str, int]:
        """Addresses of the stations that have one now."""

    def clashes(self) -> Mapping[int, list[str]]:
        """Stations on the line by address, for each address that several have."""

    def clashes_with(self, address: int, but: str) -> list[str]:
        """Stations on the line that have an address, all but one."""

    def left_address(self, station: str) -> int | None:
        """Address that a station has left to another node; None: it has not, or is back."""

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""


class Reactions(Protocol):
    """Reaction times of a segment's nodes, beside their turnaround."""

    def spread(self, most_ns: int | None, seed: int) -> None:
        """Set how much later an answer begins at most; None: only those of nodes that share an address do."""

    def delay_ns(self, station: str) -> int:
        """Draw the time by which a station's answer begins later than its turnaround is over."""


class Segment(SegmentView, Wire, Protocol):
    """Wire with stations, each under its name. Only what happens in the time of its group calls these."""

    @property
    def reactions(self) -> Reactions:
        """Reaction times of its nodes."""

    def join(self, station: str, receiver: Receiver) -> None:
        """Put a station on the wire."""

    def set_address(self, station: str, address: int | None) -> None:
        """Limit the packets that concern the station to those for this address or for all; None: no limit."""

    def set_polling(self, station: str, is_polling: bool) -> None:
        """Set whether a station's firmware takes bytes as they come. While it does not, each counts for its
        buffer, and the station is told of those for others too."""

    def set_echo(self, station: str, has_echo: bool) -> None:
        """Set whether a station hears what it sends."""

    def transmit(
        self, station: str, start_ns: SimTimeNs, data: bytes, baud: int, sent_format: LineFormat | None = None
    ) -> None:
        """Send a burst from a station; its first start bit is at ``start_ns``: until then nothing happens.
        ``sent_format``: of its characters, where it is not the line's; receivers read what they make of it.
        """

    def release(self, station: str, at_ns: SimTimeNs) -> None:
        """Let go of the line in the middle of what a station sends: receivers read an idle line from then
        on."""

    def give_way(self, station: str) -> None:
        """Take a station off the line until it has another address: another node has the one that it has."""


def speed_notes(speeds: Mapping[str, int]) -> list[str]:
    """Say that stations of one segment have several speeds; nothing if they have one, except what clocks of
    processors make of it. ``speeds``: in baud."""
    by_speed: dict[int, list[str]] = {}
    for name, baud in speeds.items():
        by_speed.setdefault(baud, []).append(name)
    if not by_speed or max(by_speed) <= min(by_speed) * (1 + _TOLERATED):
        return []
    said = (
        f"{', '.join(names[:_NAMED])}{' ...' if len(names) > _NAMED else ''} {baud} baud"
        for baud, names in by_speed.items()
    )
    return [f"the speeds differ, and stations of two speeds read wrong bytes: {'; '.join(said)}"]
