"""Bytes that go out on a line of packets, and whether another station may send the same soon."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from hil.vocab.framing import Framing
from hil.vocab.ports import Sole, SoleOf
from hil.vocab.time import SimTimeNs

IsHere = Callable[[int], bool]
"""Says whether a node with this address is on this side of the line, and none with it on the other."""
_ANY_BAUD = 9600


@runtime_checkable
class KnowsSenders(Protocol):
    """Framing that tells itself who may send the same, where its packets do not name their senders."""

    def sole(self, data: bytes, is_here: IsHere) -> Sole | None: ...


def sole_by(framing: Framing, is_here: IsHere) -> SoleOf:
    """Make what says it of bytes on a line with this framing."""
    if isinstance(framing, KnowsSenders):
        return lambda data: framing.sole(data, is_here)
    return lambda data: sole_of_packets(framing, data)


def sole_of_packets(framing: Framing, data: bytes) -> Sole | None:
    """Say it of packets: where each names its sender, nobody else sends the same."""
    if framing.has_ends and not framing.may_end(data[-1:]):
        return None
    splitter = framing.splitter()
    items = splitter.burst(data, SimTimeNs(0), _ANY_BAUD).items
    if not items or splitter.pending:
        return None
    return Sole.ALONE if all(each.origin is not None for each in items) else Sole.UNSURE
