"""A listener to a line of Modbus RTU: characters with their times in, frames out."""

from collections.abc import Sequence

from bridges.modbus.protocol.exchange import is_answer
from bridges.modbus.protocol.frame import FRAME_BYTES_MAX, FRAME_BYTES_MIN, TO_ALL, Frame, Malformed
from hil.vocab.framing import BurstItems
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns, gap_ns, silence_ns

_NOTHING = bytes((TO_ALL, 0))
_READS, _READ_BYTES = (3, 4), 8
"""Reads of registers, and the length of their questions, which no answer of theirs has."""


class RtuSplitter:
    """Splits a line's characters by the silences between them. Time never goes back.

    A frame is over when the line has been silent behind it: the next character shows it, or ``silence``. All
    bytes come out again, each once. ``bits``: of a character.
    """

    def __init__(self, bits: int = 10) -> None:
        self._bits = bits
        self._raw = b""
        self._at_ns = 0
        self._last_ns = 0
        """Time at which the last character was complete."""
        self._over_ns: int = FOREVER
        """Time at which what is held is over, if nothing follows."""
        self._is_broken = False
        """True if a silence within what is held was too long."""
        self._is_long = False
        """True if a first piece of what is held was given as too long."""
        self._address = TO_ALL
        self._asked = _NOTHING
        """Frame before, if it can be a question whose answer has not come."""
        self._baud = self._gap_ns = self._silence_ns = 0
        """Speed of what came last, and its silences, kept because each burst needs them."""

    def burst(self, data: bytes, start_ns: SimTimeNs, baud: int) -> BurstItems:
        items: list[Frame | Malformed] = []
        if data:
            self._take(data, start_ns, baud, items)
            self._last_ns = start_ns + character_ns(len(data), baud, self._bits)
            self._over_ns = self._last_ns + self._silence_ns
        addresses = None if self._address == TO_ALL else (self._address,)
        return BurstItems(items, addresses, False, SimTimeNs(self._over_ns))

    def characters(self, data: bytes, times_ns: Sequence[int], baud: int) -> BurstItems:
        items: list[Frame | Malformed] = []
        one_ns = character_ns(1, baud, self._bits)
        for at_ns, byte in zip(times_ns, data, strict=True):
            self._take(bytes((byte,)), at_ns - one_ns, baud, items)
            self._last_ns, self._over_ns = at_ns, at_ns + self._silence_ns
        return BurstItems(items, None, over_ns=SimTimeNs(self._over_ns))

    def silence(self, now_ns: SimTimeNs) -> Sequence[Frame | Malformed]:
        items: list[Frame | Malformed] = []
        if self._raw and self._over_ns <= now_ns:
            self._end(items)
        return items

    @property
    def pending(self) -> bytes:
        return self._raw

    def copy(self) -> "RtuSplitter":
        other = RtuSplitter()
        vars(other).update(vars(self))
        return other

    def _take(self, data: bytes, start_ns: int, baud: int, items: list[Frame | Malformed]) -> None:
        """Take characters without a silence between them, the first of which begins at ``start_ns``."""
        if baud != self._baud:
            self._baud, self._gap_ns = baud, gap_ns(baud, self._bits)
            self._silence_ns = silence_ns(baud, self._bits)
        if start_ns >= self._over_ns:
            self._end(items)
        if self._over_ns == FOREVER:
            self._at_ns, self._address = start_ns, data[0]
        elif start_ns - self._last_ns > self._gap_ns:
            self._is_broken = True
        raw = self._raw + data
        if len(raw) > FRAME_BYTES_MAX:
            self._is_long = True
            whole = (len(raw) - 1) // FRAME_BYTES_MAX * FRAME_BYTES_MAX
            pieces = (raw[at : at + FRAME_BYTES_MAX] for at in range(0, whole, FRAME_BYTES_MAX))
            items += (Malformed(self._at_ns, piece, "too long") for piece in pieces)
            raw = raw[whole:]
        self._raw = raw

    def _end(self, items: list[Frame | Malformed]) -> None:
        raw = self._raw
        if self._is_long:
            items.append(Malformed(self._at_ns, raw, "too long"))
        elif self._is_broken:
            items.append(Malformed(self._at_ns, raw, "gap"))
        elif len(raw) < FRAME_BYTES_MIN:
            items.append(Malformed(self._at_ns, raw, "too short"))
        else:
            frame, asked = Frame(self._at_ns, raw), self._asked
            self._asked = raw
            is_read = len(raw) == _READ_BYTES and raw[1] in _READS  # always a question: most frames are
            if not is_read and raw[0] == asked[0] and is_answer(asked, raw):
                self._asked = _NOTHING
                frame.as_answer(asked)
            items.append(frame)
        self._raw = b""
        self._over_ns = FOREVER
        self._is_broken = self._is_long = False
