"""Echo of an adapter whose receiver stays on while it sends: what was sent comes back, and is no answer.

The bytes that come back are told from those of others by content, order and time. An echo is all that was
sent in one go, as it was sent, before a time after it. Until it is known whether the line has an echo, only
those bytes are taken for one that no other station would send now (``hil.vocab.ports.Sole``).
"""

from dataclasses import dataclass

from hil.vocab.ports import EchoState, EchoStats, Sole, SoleOf
from hil.vocab.time import FOREVER, NS_PER_MS
from hil.wire.serial_line import character_ns

LATE_NS = 250 * NS_PER_MS
"""Time behind the last character, after which no echo comes: a USB adapter holds bytes for 16 ms (the latency
timer of FTDI's and of Linux's ``ftdi_sio``), a busy computer or a network for longer."""
ALIKE_LATE_NS = 100 * NS_PER_MS
"""The same, on a line that is not known, for what others may send soon, as a master that repeats a write."""
OVER_NS = 20 * NS_PER_MS
"""Silence behind bytes that are sent in pieces, after which nothing belongs to them any more: longer than a
busy computer is late with the next piece."""
PROOFS = 2
"""Number of echoes in a row of what no other sends, after which the line has an echo."""
MISSES = 3
"""Number of sends in a row that did not come back, after which it has none."""
_PENDING_MAX = 64
_BURST_MAX = 512
_ALIKE_SHARE = 0.75
"""Share of right characters in what comes in an echo's place, from which on it is that echo, damaged."""


@dataclass(eq=False, slots=True)
class _Sent:
    """Bytes that were sent in one go. ``passed``: number of others' bytes that had come before."""

    data: bytearray
    off_ns: int
    passed: int
    is_over: bool = False
    """True if nothing more belongs to it."""
    sole: Sole = Sole.UNSURE
    is_missed: bool = False
    """True if it was noted already that it did not come back."""


class Echo:
    """Record of what was just sent on a line, and of what came back of it. Times never go back.

    ``wanted``: whether the line has an echo, if somebody has said so. ``sole``: says whether another station
    may send the same; None: nobody knows, and the line is not looked at. ``in_pieces``: what belongs together
    is sent in pieces.

    Long because what was sent, what came back and what was damaged are decided over the same two queues.
    """

    def __init__(
        self,
        baud: int,
        bits: int = 10,
        *,
        wanted: bool | None = None,
        sole: SoleOf | None = None,
        in_pieces: bool = False,
    ) -> None:
        self._baud, self._bits = baud, bits
        self._wanted, self._sole, self._in_pieces = wanted, sole, in_pieces
        self._dropped_bytes = self._collisions = 0
        self._pending: list[_Sent] = []
        self._held = bytearray()
        """Bytes that came and are the beginning of something that was sent."""
        self._passed = bytearray()
        """Others' bytes that came while something was pending."""
        self.reopened()

    @property
    def told(self) -> EchoStats:
        return EchoStats(self._state, self._dropped_bytes, self._collisions)

    def seek(self, sole: SoleOf, *, in_pieces: bool) -> None:
        """Look for an echo from now on, by what is said of sent bytes."""
        self._sole, self._in_pieces = sole, in_pieces
        self.reopened()

    def reopened(self) -> None:
        """Forget what is known: another adapter may be there."""
        self._pending.clear()
        self._held.clear()
        self._passed.clear()
        self._free_ns = self._proofs = self._misses = 0
        self._state = EchoState.UNKNOWN
        if self._wanted is not None:
            self._state = EchoState.YES if self._wanted else EchoState.NO
        elif self._sole is None:
            self._state = EchoState.UNSOUGHT

    def sent(self, data: bytes, at_ns: int) -> None:
        """Note bytes that go out now, or as soon as what was sent before is out."""
        if self._wanted is False or (self._sole is None and not self._wanted) or not data:
            return
        if self._state is EchoState.UNKNOWN:
            self._note_misses()
        start_ns = max(at_ns, self._free_ns)
        self._free_ns = start_ns + character_ns(len(data), self._baud, self._bits)
        for piece in (data[at : at + 1] for at in range(len(data))) if self._in_pieces else (data,):
            self._note_sent(piece)
        if len(self._pending) > _PENDING_MAX:
            del self._pending[0]

    def _note_misses(self) -> None:
        """Note what others have sent after: an echo would have come before that. It may come all the same,
        where others' bytes were on their way already."""
        for sent in self._pending:
            if sent.is_over and len(self._passed) > sent.passed:
                self._miss(sent)
                sent.is_missed = True

    def _note_sent(self, data: bytes) -> None:
        last = self._pending[-1] if self._pending else None
        if last is None or last.is_over:
            last = _Sent(bytearray(), 0, len(self._passed))
            self._pending.append(last)
        last.data += data
        last.off_ns = self._free_ns
        sole = self._sole(bytes(last.data)) if self._sole else None
        last.sole = sole or Sole.UNSURE
        last.is_over = sole is not None or not self._in_pieces or len(last.data) >= _BURST_MAX

    def received(self, data: bytes) -> bytes:
        """Take bytes that came; answers those of others, with what was held of them."""
        if not self._pending:
            return data
        out = bytearray()
        for byte in data:
            self._take(byte, out)
        self._look_for_damage()
        self._settle(out)
        return bytes(out)

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""
        return min(map(self._end_ns, self._pending), default=FOREVER)

    def advance(self, now_ns: int) -> bytes:
        """Do what is due, after all that came by now was taken; answers others' bytes that were held."""
        out = bytearray()
        for sent in [each for each in self._pending if self._end_ns(each) <= now_ns]:
            if sent.is_over:
                self._pending.remove(sent)
                self._miss(sent)
                continue
            sent.is_over = True
            if not sent.data:
                self._pending.remove(sent)
            elif sent.data == self._held:
                self._decide(sent, out)
        self._settle(out)
        return bytes(out)

    # ---- what comes ----

    def _take(self, byte: int, out: bytearray) -> None:
        whole = next((each for each in self._pending if each.data and each.data == self._held), None)
        self._held.append(byte)
        if whole and not self._begun():
            whole.is_over = True  # something else follows it
            del self._held[-1]
            self._decide(whole, out)
            self._held.append(byte)
        self._settle(out)

    def _begun(self) -> _Sent | None:
        """First thing that was sent and begins with what is held."""
        return next((each for each in self._pending if each.data.startswith(self._held)), None)

    def _settle(self, out: bytearray) -> None:
        """Let go of what begins nothing; decide about the rest if it is all that was sent, and needs no
        waiting."""
        while self._held:
            if sent := self._begun():
                is_known = sent.is_over or self._state is not EchoState.UNKNOWN
                if is_known and len(sent.data) == len(self._held):
                    self._decide(sent, out)
                return
            self._let_go(1, out)

    def _let_go(self, count: int, out: bytearray) -> None:
        """Hand on the first bytes of what is held: they are others'."""
        data = self._held[:count]
        del self._held[:count]
        out += data
        self._passed += data

    def _decide(self, sent: _Sent, out: bytearray) -> None:
        """Drop what is held and equals what was sent, or let go of it as an answer."""
        is_echo = sent.sole is Sole.ALONE or self._state is EchoState.YES
        if is_echo or (sent.sole is Sole.HERE and self._state is EchoState.UNKNOWN):
            for lost in self._pending[: self._pending.index(sent)]:
                self._pending.remove(lost)
                self._miss(lost)
            self._dropped_bytes += len(self._held)
            self._misses = 0
            if sent.sole is Sole.ALONE:
                self._prove()
        else:
            self._let_go(len(self._held), out)
        self._held.clear()
        if sent.is_over:
            self._pending.remove(sent)
        else:
            sent.data.clear()  # more of it may follow

    def _look_for_damage(self) -> None:
        """Take bytes in the place of an echo for that echo, damaged, if most are right."""
        if not self._pending:
            self._passed.clear()
            return
        first = self._pending[0]
        del self._passed[: (gone := first.passed)]
        for each in self._pending:
            each.passed -= gone
        came = self._passed[: len(first.data)]
        if self._state is EchoState.YES and came and len(came) == len(first.data):
            right = sum(one == other for one, other in zip(came, first.data, strict=True))
            if right >= _ALIKE_SHARE * len(came):
                self._pending.pop(0)
                self._miss(first)

    # ---- what is known ----

    def _end_ns(self, sent: _Sent) -> int:
        """Time at which something is over, or at which its echo would have come."""
        if not sent.is_over:
            return sent.off_ns + OVER_NS
        is_sure = sent.sole is Sole.ALONE or self._state is EchoState.YES
        return sent.off_ns + (LATE_NS if is_sure else ALIKE_LATE_NS)

    def _prove(self) -> None:
        if self._wanted is not None or self._state is EchoState.YES:
            return
        self._proofs += 1
        self._state = EchoState.YES if self._proofs >= PROOFS else EchoState.UNKNOWN

    def _miss(self, sent: _Sent) -> None:
        """Note that something did not come back as it was sent."""
        if self._state is EchoState.NO or sent.is_missed or not sent.data:
            return
        if self._state is EchoState.YES and len(self._passed) > sent.passed:
            self._collisions += 1
        if self._wanted is None:
            self._misses += 1
            self._proofs = 0
        if self._misses >= MISSES:
            self._misses = 0
            was_known = self._state is EchoState.YES
            self._state = EchoState.UNKNOWN if was_known else EchoState.NO
