"""Splitter of a line's bytes into frames of TMCL."""

from collections.abc import Sequence
from dataclasses import dataclass

from hil.vocab.framing import BurstItems
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns
from tmcl_bus.frames import BROKEN_OFF_NS, FRAME_BYTES, asks_for_text, has_right_sum, is_reply


@dataclass(frozen=True)
class Frame:
    """Nine bytes. ``asked``: the request that they reply to; empty: they are a request."""

    at_ns: int
    raw: bytes
    asked: bytes = b""
    is_packet = True
    origin = None

    @property
    def is_text(self) -> bool:
        """True for a reply without a status and without a sum."""
        return bool(self.asked) and asks_for_text(self.asked)

    @property
    def fault(self) -> str:
        return "" if self.is_text or has_right_sum(self.raw) else "checksum"


@dataclass(frozen=True)
class Rest:
    """Bytes of a frame that was broken off."""

    at_ns: int
    raw: bytes
    is_packet = False
    origin = None
    fault = "too short"


class TmclSplitter:
    """Splitter, a ``hil.vocab.framing.Splitter``: every nine bytes are a frame, and a silence within one
    breaks it off. All bytes come out again, each once."""

    def __init__(self) -> None:
        self._raw, self._asked = b"", b""
        self._at_ns, self._over_ns = 0, FOREVER

    def burst(self, data: bytes, start_ns: SimTimeNs, baud: int) -> BurstItems:
        items: list[Frame | Rest] = list(self.silence(start_ns))
        is_whole = not self._raw
        one_ns = character_ns(1, baud)
        for place, byte in enumerate(data):
            items += self._take(byte, start_ns + place * one_ns)
        if data and self._raw:
            self._over_ns = SimTimeNs(start_ns + character_ns(len(data), baud) + BROKEN_OFF_NS)
        addresses = {item.raw[0] for item in items} if is_whole and not self._raw else None
        return BurstItems(items, addresses, False, self._over_ns)

    def characters(self, data: bytes, times_ns: Sequence[int], baud: int) -> BurstItems:
        items: list[Frame | Rest] = []
        one_ns = character_ns(1, baud)
        for at_ns, byte in zip(times_ns, data, strict=True):
            items += (*self.silence(SimTimeNs(at_ns - one_ns)), *self._take(byte, at_ns - one_ns))
            self._over_ns = SimTimeNs(at_ns + BROKEN_OFF_NS) if self._raw else FOREVER
        return BurstItems(items, None, False, self._over_ns)

    def silence(self, now_ns: SimTimeNs) -> Sequence[Rest]:
        if not self._raw or now_ns < self._over_ns:
            return ()
        rest = Rest(self._at_ns, self._raw)
        self._raw, self._over_ns = b"", FOREVER
        return (rest,)

    @property
    def pending(self) -> bytes:
        return self._raw

    def copy(self) -> "TmclSplitter":
        other = TmclSplitter()
        vars(other).update(vars(self))
        return other

    def _take(self, byte: int, at_ns: int) -> Sequence[Frame]:
        if not self._raw:
            self._at_ns = at_ns
        self._raw += bytes((byte,))
        if len(self._raw) < FRAME_BYTES:
            return ()
        raw, asked = self._raw, self._asked
        self._raw, self._over_ns = b"", FOREVER
        if asked and is_reply(asked, raw):
            self._asked = b""
            return (Frame(self._at_ns, raw, asked),)
        self._asked = raw
        return (Frame(self._at_ns, raw),)
