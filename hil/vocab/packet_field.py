"""Fields of a packet, with the bytes that they are: for those who look into one packet."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

from hil.vocab.framing import Item


class PacketField(NamedTuple):
    """Field of a packet, or a part of the field before it with a lower level."""

    name: str
    text: str
    """Value in words."""
    begin: int = 0
    end: int = 0
    """Bytes that it is, from ``begin`` to before ``end``; equal: none of the packet's own."""
    level: int = 0

    def row(self) -> dict[str, Any]:
        """Row for JSON."""
        return self._asdict()


Fields = Sequence[PacketField]


@runtime_checkable
class FieldFraming(Protocol):
    """Framing that knows the fields of its packets."""

    def fields(self, item: Item) -> Fields:
        """Fields of an item of its own splitters, in the order of their bytes."""
