"""Interface card of an axis: a node of a bus, in its board's time and with its board's power."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

from hil.sim.twin import Twin
from hil.vocab.faults import Fault
from hil.vocab.time import SimTimeNs
from hil.vocab.wire import Wire


class CardFaults(Protocol):
    """Faults of a card itself, by their numbers."""

    target: str
    """Target of faults, a key of ``TARGETS``, that the card is."""

    def begin(self, number: int, fault: Fault) -> None:
        """Begin a fault."""

    def end(self, number: int) -> None:
        """End a fault."""


class Card(Protocol):
    """Card, a station of its wire. Its bus makes it."""

    name: str
    device: Twin
    listeners: list[Callable[[SimTimeNs, bytes], None]]
    """Called with each answer, at the time at which it goes out."""

    @property
    def wire(self) -> Wire:
        """Wire that it is on."""

    @property
    def faults(self) -> CardFaults | None:
        """Faults that it can have itself; None: all are the wire's or the board's."""

    def counters(self) -> dict[str, Any]:
        """State and statistics, for JSON."""


@runtime_checkable
class NumberedCard(Card, Protocol):
    """Card that is listed by its number on the bus, and has a data sheet."""

    @property
    def node_id(self) -> int:
        """Number of the node."""

    def eds(self) -> str:
        """Write the node's electronic data sheet."""
