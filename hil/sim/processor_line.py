"""Line of a processor's serial interface: characters go to its RX with their times, and frames come from it.

The processor's own UART samples the line: what a sender at another speed sends reads as there.
"""

from collections import deque
from collections.abc import Sequence
from typing import Protocol

from hil.vocab.line_format import LineFormat
from hil.vocab.segment import HeardCharacter
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

START_BITS = 1


class LineProcessor(Protocol):
    """Processor as its line asks it (``hil.core.core_processor``)."""

    is_running: bool

    @property
    def baud(self) -> int: ...
    @property
    def line_format(self) -> LineFormat: ...
    def hear(self, start_ns: int, bit_ns: float, bits: int, length: int, *, is_broken: bool) -> bool: ...
    def retract(self, after_ns: int) -> None: ...


class ProcessorLine:
    """Receive side of a processor's serial interface. ``lost``: characters for which there was no room on the
    way."""

    def __init__(self, processor: LineProcessor) -> None:
        self._processor = processor
        self._ends_ns = deque[int]()
        """Times at which characters that are under way have come, ascending."""
        self.lost = 0

    @property
    def is_on(self) -> bool:
        """True while the processor runs: the line is its own."""
        return self._processor.is_running

    def baud(self, usual: int) -> int:
        """Speed that the program has set; ``usual`` while it has set none."""
        return self._processor.baud or usual

    @property
    def line_format(self) -> LineFormat:
        """Format of characters that the program has set; of nine data bits, too."""
        return self._processor.line_format

    def hear(self, start_ns: int, data: bytes, baud: int, line_format: LineFormat) -> None:
        """Let bytes that stand back to back come from ``start_ns`` on."""
        bit_ns = NS_PER_S / baud
        for number, byte in enumerate(data):
            first_ns = start_ns + number * line_format.bits * NS_PER_S // baud
            levels = line_format.levels(byte)[START_BITS : -line_format.stop_bits]
            self._begin(first_ns, bit_ns, levels, line_format.bits, is_broken=False)

    def hear_characters(
        self, characters: Sequence[HeardCharacter], baud: int, line_format: LineFormat
    ) -> None:
        """Let characters come that a disturbed line reads as at this speed."""
        bit_ns = NS_PER_S / baud
        for each in characters:
            levels = list(line_format.levels(each.byte)[START_BITS : -line_format.stop_bits])
            if each.is_parity_error:
                levels[-1] ^= 1
            first_ns = each.at_ns - line_format.bits * NS_PER_S // baud
            self._begin(first_ns, bit_ns, levels, line_format.bits, is_broken=each.is_framing_error)

    def _begin(
        self, first_ns: int, bit_ns: float, levels: Sequence[int], bits: int, *, is_broken: bool
    ) -> None:
        packed = sum(level << place for place, level in enumerate(levels))
        if self._processor.hear(first_ns, bit_ns, packed, len(levels), is_broken=is_broken):
            self._ends_ns.append(first_ns + round(bits * bit_ns))
        else:
            self.lost += 1

    def retract(self, after_ns: int, character_ns: int) -> None:
        """Take back characters that would be complete after this time."""
        self._processor.retract(after_ns - character_ns)
        while self._ends_ns and self._ends_ns[-1] > after_ns:
            self._ends_ns.pop()

    def under_way(self, now_ns: int) -> Sequence[int]:
        """Times at which characters are complete that are not yet, ascending."""
        while self._ends_ns and self._ends_ns[0] <= now_ns:
            self._ends_ns.popleft()
        return self._ends_ns

    def room_ns(self, now_ns: int) -> SimTimeNs:
        """Time at which half of what is under way has come; ``FOREVER``: nothing is."""
        times_ns = self.under_way(now_ns)
        return SimTimeNs(times_ns[len(times_ns) // 2]) if times_ns else FOREVER
