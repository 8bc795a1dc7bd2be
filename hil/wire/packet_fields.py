"""Fields of packets by their framing, and as lines for people."""

from collections.abc import Iterable

from hil.vocab.framing import Framing, Item
from hil.vocab.packet_field import FieldFraming, Fields, PacketField


def fields_of(framing: Framing, item: Item) -> Fields:
    """Fields of an item by its framing; its bytes as one where that knows none."""
    found = framing.fields(item) if isinstance(framing, FieldFraming) else ()
    return found or bytes_field(item.raw)


def bytes_field(data: bytes) -> Fields:
    """Bytes as one field."""
    return (PacketField("bytes", data.hex(" "), 0, len(data)),) if data else ()


def field_lines(fields: Iterable[PacketField]) -> Iterable[str]:
    """Format fields for people, a line each: bytes, name, value."""
    for name, text, begin, end, level in fields:
        places = "" if begin == end else str(begin) if end == begin + 1 else f"{begin}-{end - 1}"
        yield f"{places:>7}  {'  ' * level}{name}: {text}".rstrip()
