"""Blocks of a capture that ends after so many items: exactly those, each whole."""

from collections import defaultdict, deque
from collections.abc import Hashable, Iterable, Sequence

from hil.compose.decoded_item import DecodedItem
from hil.wire.pcapng import Interface, Record, RecordKind, record


class _Held:
    """Block whose bytes do not all belong to items that count, yet. ``left``: how many of them."""

    def __init__(self, block: bytes, of: Record, *, is_item: bool) -> None:
        self.block, self.of = block, of
        self.left = len(of.data) or int(is_item)


class CountedBlocks:
    """Blocks on their way to a target: each is held until all of it belongs to items that count, for a block
    may have the end of one line of bytes and the beginning of the next."""

    def __init__(self) -> None:
        self._held: deque[_Held] = deque()
        self._streams: defaultdict[Hashable, deque[_Held]] = defaultdict(deque)

    def put(self, block: bytes, of: Record, stream: Hashable) -> None:
        """Hold a block with a record. ``stream``: as its items have it."""
        held = _Held(block, of, is_item=stream is of)
        self._held.append(held)
        self._streams[stream].append(held)

    def count(self, items: Iterable[DecodedItem]) -> bytes:
        """Count items; answers the blocks that are whole by that, in their order."""
        for item in items:
            left, stream = len(item.data), self._streams[item.stream]
            if isinstance(item.stream, Record):  # an item by itself, whatever it shows of its bytes
                left = stream[0].left
            while stream:
                taken = min(left, stream[0].left)
                stream[0].left -= taken
                left -= taken
                if stream[0].left:
                    break
                stream.popleft()
            if not stream:
                del self._streams[item.stream]
        whole = []
        while self._held and not self._held[0].left:
            whole.append(self._held.popleft().block)
        return b"".join(whole)

    def rest(self, interfaces: Sequence[Interface]) -> bytes:
        """Parts of the blocks that are held which belong to items that count, as blocks of their own."""
        parts = []
        for held in self._held:
            of = held.of
            taken = len(of.data) - held.left
            if not held.left:
                parts.append(held.block)
            elif taken > 0:
                line = interfaces.index(of.line)
                data = of.data[:taken]
                parts.append(record(line, of.at_ns, RecordKind(of.event), data, of.comment, of.lost))
        self._held.clear()
        return b"".join(parts)
