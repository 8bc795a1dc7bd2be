"""Framing of a line: how its bytes are packets, whom each concerns, how it is printed, what spoils it.

A framing belongs to a kind of board, or to a protocol that many boards speak. Code that carries bytes (the
wire, UARTs, taps, captures) asks this Protocol, and knows no packet.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple, Protocol

from hil.vocab.time import FOREVER, SimTimeNs

Party = int | str | None
"""Address of a sender or a receiver, or a word for it, as ``EVERYBODY``; None: nobody says."""
EVERYBODY = "all"
Transform = Callable[[bytes], bytes]
"""Change of a burst: its bytes in, those that go on the wire out; nothing: the station is silent."""


class Item(Protocol):
    """A packet, or bytes that are none."""

    def __hash__(self) -> int: ...

    @property
    def at_ns(self) -> int:
        """Time at which the burst began that completed it; 0 where nobody said."""

    @property
    def is_packet(self) -> bool:
        """True if the item has a packet's form; its checksum may be wrong."""

    @property
    def raw(self) -> bytes:
        """Bytes of the item as they were on the line."""

    @property
    def fault(self) -> str:
        """Error of the item, in a few words; "" for none."""

    @property
    def origin(self) -> int | None:
        """Address of the item's sender; None: the item does not say."""


class BurstItems(NamedTuple):
    """Result of a splitter for one burst."""

    items: Sequence[Item]
    """Packets, and bytes that are none, that it has completed."""
    addresses: Collection[int] | None
    """Addresses of the stations that it concerns; None: all of them."""
    is_for_all: bool = False
    """True if the burst is whole packets, at least one of them for everybody."""
    over_ns: SimTimeNs = FOREVER
    """Time at which silence completes what is held, if nothing follows; ``FOREVER``: it completes nothing."""


class Splitter(Protocol):
    """A listener to the line: takes all that is on it, in order, and splits it into packets."""

    def burst(self, data: bytes, start_ns: SimTimeNs, baud: int) -> BurstItems:
        """Take bytes that stand back to back on the line from ``start_ns`` on."""

    def characters(self, data: bytes, times_ns: Sequence[int], baud: int) -> BurstItems:
        """Take what a disturbed line reads as at a speed. ``times_ns``: when each character is complete."""

    def silence(self, now_ns: SimTimeNs) -> Sequence[Item]:
        """Note that the line is silent until now; answers what that completes."""

    @property
    def pending(self) -> bytes:
        """Bytes that it has heard and given in no item yet: a packet may begin with them."""

    def copy(self) -> "Splitter":
        """Copy the splitter with its state: what it has heard and not given yet."""


class Framing(Protocol):
    """Framing of a line: how its bytes are packets. Two are the same if they are one object."""

    def __hash__(self) -> int: ...

    @property
    def name(self) -> str:
        """Name by which it is found again: in a configuration, for a capture."""

    @property
    def faults(self) -> Collection[str]:
        """Kinds of fault that it can make, of ``hil.vocab.faults.OF_FRAMINGS``."""

    def splitter(self) -> Splitter:
        """Make a listener that has heard nothing yet."""

    @property
    def has_ends(self) -> bool:
        """True if characters can tell where a packet ends (``ends``, ``may_end``). If not, silence does, and
        a sketch is woken for each character, with which it may time the next."""

    def ends(self, data: bytes, before: bytes | None) -> Sequence[int]:
        """Answer the places in ``data`` of characters with which a packet may end. ``before``: the two bytes
        that stood before, or fewer, where no more is known; None: anything may have stood there, also between
        these."""

    def may_end(self, data: bytes) -> bool:
        """Answer whether a packet may end within ``data``, whatever stood before."""

    def text(self, item: Item) -> str:
        """Format an item of its own splitters as one line, for people."""

    def parties(self, item: Item) -> tuple[Party, Party]:
        """Answer from whom to whom an item of its own splitters is, as far as the item says."""

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        """Make a fault of the layer ``packet``: what becomes of a station's bursts."""

    def answers(self, burst: bytes, address: int) -> Iterable[tuple[int, bytes]]:
        """Answers of a node with this address to what a burst has for it: how many characters after the
        burst's start each begins, and its bytes."""
