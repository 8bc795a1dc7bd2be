"""Framing of a line whose protocol nobody knows: its bytes, parted by silences.

``hil.vocab.framing.Framing``.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from hil.vocab.framing import BurstItems, Item, Party, Transform
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns, silence_ns

_LONGEST = 1024
"""Bytes after which an item is given, whatever follows: as many as a line at a terminal."""


class LineBytes(NamedTuple):
    """Bytes between two silences."""

    at_ns: int
    raw: bytes
    is_packet: bool = True
    fault: str = ""
    origin: int | None = None


class BytesSplitter:
    """Splitter at silences of 3.5 characters, as long as those that part frames of Modbus RTU: most protocols
    of such lines pause longer between a question and its answer."""

    def __init__(self) -> None:
        self._raw, self._at_ns, self._over_ns = b"", 0, FOREVER

    def burst(self, data: bytes, start_ns: SimTimeNs, baud: int) -> BurstItems:
        items = list(self.silence(start_ns))
        if data:
            if not self._raw:
                self._at_ns = start_ns
            raw = self._raw + data
            *whole, self._raw = (raw[at : at + _LONGEST] for at in range(0, len(raw), _LONGEST))
            items += (LineBytes(self._at_ns, each) for each in whole)
            self._at_ns = start_ns if whole else self._at_ns
            self._over_ns = SimTimeNs(start_ns + character_ns(len(data), baud) + silence_ns(baud))
        return BurstItems(items, None, False, self._over_ns)

    def characters(self, data: bytes, times_ns: Sequence[int], baud: int) -> BurstItems:
        items: list[Item] = []
        one_ns = character_ns(1, baud)
        for at_ns, byte in zip(times_ns, data, strict=True):
            items += self.burst(bytes((byte,)), SimTimeNs(at_ns - one_ns), baud).items
        return BurstItems(items, None, False, self._over_ns)

    def silence(self, now_ns: SimTimeNs) -> Sequence[LineBytes]:
        if not self._raw or now_ns < self._over_ns:
            return ()
        item = LineBytes(self._at_ns, self._raw)
        self._raw, self._over_ns = b"", FOREVER
        return (item,)

    @property
    def pending(self) -> bytes:
        return self._raw

    def copy(self) -> "BytesSplitter":
        other = BytesSplitter()
        vars(other).update(vars(self))
        return other


class BytesFraming:
    """Bytes without packets, addresses, checksums or faults of their own."""

    name = "bytes"
    faults: tuple[str, ...] = ()
    has_ends = False

    def splitter(self) -> BytesSplitter:
        return BytesSplitter()

    def ends(self, data: bytes, before: bytes | None) -> tuple[int, ...]:
        """Answer none: no byte ends anything."""
        return ()

    def may_end(self, data: bytes) -> bool:
        return False

    def text(self, item: Item) -> str:
        return shown_bytes(item.raw)

    def parties(self, item: Item) -> tuple[Party, Party]:
        return None, None

    def fault(self, kind: str, rate: float, seed: int) -> Transform:
        raise ValueError(f"bytes have no fault {kind}")

    def answers(self, burst: bytes, address: int) -> Iterable[tuple[int, bytes]]:
        return ()


BYTES = BytesFraming()


def shown_bytes(raw: bytes) -> str:
    """Format bytes as in ``23 30 31 0d  #01.``: digits, and the characters of ASCII that they are."""
    return f"{raw.hex(' ')}  {''.join(chr(each) if 32 <= each < 127 else '.' for each in raw)}"
