"""Turns on a half-duplex line: one transaction at a time, in order, and none that is carried out twice.

The rules, with their reasons, are in ``docs/decisions/0040-never-twice.md``:

- A packet goes out when the line is quiet and nobody's answer is waited for.
- A refusal means that nothing was done: the same packet goes out again, as often as it may.
- Silence means that the command was lost, or its answer. The line is free for others at the time-out. The
  node gets nothing until a late answer would have come, too (``rest_ns``). Only then is a command repeated,
  if twice is as good as once. If not, the outcome is not known.
- An answer that comes earlier than the line can carry it belongs to something before, and is not believed.
- What goes to all waits for the transactions before it, and those behind wait for it.
- What is urgent goes first. It does not wait for late answers: it is repeated until one is surely its own.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from hil.master.sans_io.transaction import Outcome, Transaction
from hil.vocab.time import FOREVER
from hil.wire.serial_line import character_ns

NOISE_WAIT = 4
"""Number of the longest packets that a turn waits for a line that is never quiet."""


@dataclass(frozen=True)
class LineTiming:
    """Times of a line. ``latency_ns``: maximum delay of what lies between this program and the line, there
    and back; ``turnaround_ns``: from a packet's last bit to the first of its answer; ``gap_ns``: that the
    master leaves between packets."""

    baud: int
    bits: int
    latency_ns: int
    turnaround_ns: int
    gap_ns: int
    longest_bytes: int = 0
    """Length of the longest packet that a node sends by itself."""
    shortest_bytes: int = 0
    """Length of the shortest answer."""
    to_all_ns: int = 0
    """Time that nodes need behind a packet to all, at least ``gap_ns``."""
    has_bit_times: bool = True
    """False for a line without bits, as a pty with a program at its other end, that may answer at once."""

    def characters_ns(self, count: int) -> int:
        return character_ns(count, self.baud, self.bits)

    def first_ns(self, frame_bytes: int) -> int:
        """Time from the start of a packet by which the first character of its answer has come."""
        return self._spared_ns(frame_bytes + 1)

    def whole_ns(self, frame_bytes: int, answer_bytes: int) -> int:
        """Time from the start of a packet by which its answer has come."""
        return self._spared_ns(frame_bytes + answer_bytes)

    def _spared_ns(self, characters: int) -> int:
        """Time for so many characters and the turnaround, with half a character to spare: clocks differ, and
        times are whole nanoseconds."""
        spare_ns = self.characters_ns(1) // 2
        return self.characters_ns(characters) + self.turnaround_ns + self.latency_ns + spare_ns

    def earliest_ns(self, frame_bytes: int) -> int:
        """Time from the start of a packet before which no answer can have come; a tenth less, as clocks
        differ."""
        if not self.has_bit_times:
            return 0
        return (self.characters_ns(frame_bytes + self.shortest_bytes) + self.turnaround_ns) * 9 // 10


class LineTurns:
    """Turns of one line. Its owner calls ``heard`` for all that comes, ``answered`` for answers, ``advance``
    when ``due_ns`` is reached, and sends what ``to_send`` gives. ``tells``: answers whether a unit sends by
    itself when a motion begins.

    Long because a turn can end by an answer, a time-out, a silence or a loss, and each of them decides
    what may go out next.
    """

    def __init__(self, timing: LineTiming, tells: Callable[[int], bool] = lambda unit: False) -> None:
        self.timing = timing
        self._tells = tells
        self.current: Transaction | None = None
        """The one that is on the line."""
        self.late: dict[int, tuple[Transaction, int]] = {}
        """Those whose time-out is over, by unit, with the time until which a late answer counts."""
        self.is_lost = False
        """True once the port has gone."""
        self.why_lost = ""
        self._waiting: deque[Transaction] = deque()
        self._out = bytearray()
        self._free_ns = 0
        self._quiet_ns = 0
        self._heard_ns = -1
        self._first_ns = self._whole_ns = 0
        self._ready_ns: int | None = None
        """Time since which a turn waits for quiet."""

    # ---- what is asked for ----

    def add(self, transaction: Transaction, now_ns: int) -> Transaction:
        """Queue a transaction: behind all others, an urgent one in front of those that are not."""
        transaction.queued_ns = now_ns
        if self.is_lost:
            transaction.end(Outcome.NOT_SENT, self.why_lost, now_ns)
        elif transaction.is_urgent:
            place = sum(each.is_urgent for each in self._waiting)
            self._waiting.insert(place, transaction)
        else:
            self._waiting.append(transaction)
        return transaction

    def cancel(self, now_ns: int, why: str) -> None:
        """Drop what waits, and repeat nothing that is under way, but what is urgent."""
        dropped = [each for each in self._waiting if not each.is_urgent]
        self._waiting = deque(each for each in self._waiting if each.is_urgent)
        for each in dropped:
            self._drop(each, now_ns, why)
        for each in self.under_way():
            if not each.is_urgent:
                each.tries = each.sent

    def lose(self, now_ns: int, why: str) -> None:
        """Note that the port has gone: nothing more goes out, and no answer comes."""
        self.is_lost, self.why_lost = True, why
        under_way, waiting = list(self.under_way()), list(self._waiting)
        self.current = None
        self.late.clear()
        self._waiting.clear()
        self._out.clear()
        for each in under_way:
            each.end(Outcome.NOT_KNOWN, f"{why}, before its answer came", now_ns)
        for each in waiting:
            self._drop(each, now_ns, why)

    def _drop(self, transaction: Transaction, now_ns: int, why: str) -> None:
        if not transaction.sent:
            transaction.end(Outcome.NOT_SENT, why, now_ns)
        elif transaction.refusals == transaction.sent:
            transaction.end(Outcome.REFUSED, f"refused {transaction.refusals} times; {why}", now_ns)
        else:
            transaction.end(Outcome.NOT_KNOWN, f"no answer; {why}", now_ns)

    def under_way(self) -> Iterator[Transaction]:
        """Those that have gone out and are not over."""
        if self.current:
            yield self.current
        yield from [each for each, _ in self.late.values()]

    @property
    def waiting(self) -> tuple[Transaction, ...]:
        """Those that are still to go out, or again, in order."""
        return tuple(self._waiting)

    @property
    def is_idle(self) -> bool:
        return not (self._waiting or self.current or self.late)

    # ---- what comes ----

    def heard(self, at_ns: int, is_whole: bool) -> None:
        """Note that something came; ``is_whole``: its last byte ended a packet."""
        self._heard_ns = at_ns
        gap_ns = self.timing.gap_ns
        self._quiet_ns = at_ns + (gap_ns if is_whole else max(gap_ns, self.timing.characters_ns(2)))

    def answered(self, unit: int, is_done: bool, at_ns: int, answer: object = None) -> Transaction | None:
        """Take an answer; returns the transaction that it belongs to, None: to none that is under way."""
        current = self.current
        if current and current.unit == unit and current.answer_bytes:
            if at_ns - current.sent_ns < self.timing.earliest_ns(len(current.frame)):
                current.early += 1
                return None
            self.current = None
            self._free_at(at_ns, current)
            if current.believed_after:
                current.believed_after -= 1
                current.silences += 1
                self._again(current, at_ns)
                return current
            self._settle(current, is_done, at_ns, answer)
            return current
        if unit in self.late:
            transaction, _ = self.late[unit]
            if transaction.believed_after:
                transaction.believed_after -= 1
                return transaction
            del self.late[unit]
            if not transaction.is_over:
                transaction.silences -= 1
                self._settle(transaction, is_done, at_ns, answer)
            return transaction
        return None

    def _settle(self, transaction: Transaction, is_done: bool, at_ns: int, answer: object) -> None:
        transaction.answer = answer
        if is_done:
            transaction.end(Outcome.DONE, "", at_ns)
            if transaction.is_urgent and transaction.silences:
                self.late[transaction.unit] = transaction, at_ns + transaction.rest_ns
            return
        transaction.refusals += 1
        self._again(transaction, at_ns)

    def _again(self, transaction: Transaction, now_ns: int) -> None:
        """Let it go out once more, before all that is no more urgent, or end it."""
        if transaction.sent < transaction.tries and not self.is_lost:
            self._waiting.insert(
                0 if transaction.is_urgent else sum(each.is_urgent for each in self._waiting), transaction
            )
        elif transaction.refusals == transaction.sent:
            why = transaction.refusal or f"it refused it {_times(transaction.sent)}"
            transaction.end(Outcome.REFUSED, why, now_ns)
        else:
            transaction.end(Outcome.NOT_KNOWN, self._why(transaction), now_ns)

    def _why(self, transaction: Transaction) -> str:
        """Reason why an outcome is not known."""
        why = f"no answer to {_tries(transaction.sent)}"
        if not transaction.may_repeat:
            why += ", and it must not be carried out twice"
        if transaction.early:
            why += f"; an answer came earlier than {self.timing.baud} baud can carry it: is the line faster?"
        return why

    def _free_at(self, at_ns: int, transaction: Transaction) -> None:
        timing = self.timing
        is_followed = transaction.moves and self._tells(transaction.unit)
        follows_ns = timing.characters_ns(timing.longest_bytes + 2) if is_followed else 0
        self._free_ns = max(self._free_ns, at_ns + timing.gap_ns + follows_ns)

    # ---- time ----

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do; ``FOREVER``: nothing."""
        dues = [until_ns for _, until_ns in self.late.values()]
        if self.current:
            dues.append(self._first_ns if self._heard_ns < self.current.sent_ns else self._whole_ns)
        elif self._next() is not None:
            dues.append(max(self._free_ns, self._line_quiet_ns()))
        return min(dues, default=FOREVER)

    def advance(self, now_ns: int) -> None:
        """Do what is due."""
        if self.is_lost:
            return
        if (current := self.current) and self._is_silent(current, now_ns):
            self._time_out(current, now_ns)
        for unit, (transaction, until_ns) in list(self.late.items()):
            if until_ns <= now_ns and self.late.get(unit) == (transaction, until_ns):
                del self.late[unit]
                self._rested(transaction, now_ns)  # its end may call back, and change what is late
        self._begin(now_ns)

    def _rested(self, transaction: Transaction, now_ns: int) -> None:
        """Go on with one for which no late answer has come."""
        if transaction.is_over:
            return
        if transaction.may_repeat:
            self._again(transaction, now_ns)
            return
        transaction.end(Outcome.NOT_KNOWN, self._why(transaction), now_ns)

    def _is_silent(self, current: Transaction, now_ns: int) -> bool:
        if now_ns >= self._whole_ns:
            return True
        return now_ns >= self._first_ns and self._heard_ns < current.sent_ns

    def _time_out(self, current: Transaction, now_ns: int) -> None:
        self.current = None
        self._free_ns = max(self._free_ns, now_ns)
        if not current.answer_bytes:
            current.end(Outcome.SENT, "", now_ns)
            return
        current.silences += 1
        if current.is_urgent and current.sent < current.tries:
            self._again(current, now_ns)  # an answer to any of its tries is an answer to it
            return
        self.late[current.unit] = current, now_ns + current.rest_ns

    def _next(self) -> Transaction | None:
        """The next whose turn it is, whether or not the line is free."""
        for place, each in enumerate(self._waiting):
            if each.is_urgent:
                return each
            if not each.answer_bytes:
                # What goes to all goes when everything before it is known.
                return each if place == 0 and not self.late else None
            if each.unit not in self.late:
                return each
        return None

    def _line_quiet_ns(self) -> int:
        if self._ready_ns is None:
            return self._quiet_ns
        timing = self.timing
        patience_ns = NOISE_WAIT * timing.characters_ns(max(timing.longest_bytes, 1))
        return min(self._quiet_ns, self._ready_ns + patience_ns)

    def _begin(self, now_ns: int) -> None:
        if self.current or (transaction := self._next()) is None:
            return
        if self._ready_ns is None:
            self._ready_ns = max(now_ns, self._free_ns)
        if now_ns < max(self._free_ns, self._line_quiet_ns()):
            return
        self._ready_ns = None
        self._waiting.remove(transaction)
        if transaction.is_urgent and transaction.unit in self.late:
            before, _ = self.late.pop(transaction.unit)
            transaction.believed_after += 1
            transaction.tries += 1
            before.end(Outcome.NOT_KNOWN, "no answer yet, and something urgent had to go first", now_ns)
        transaction.sent += 1
        transaction.sent_ns = now_ns
        transaction.first_ns = transaction.first_ns or now_ns
        self.current = transaction
        self._out += transaction.frame
        size, answer = len(transaction.frame), transaction.answer_bytes
        if answer:
            self._first_ns = now_ns + self.timing.first_ns(size)
            self._whole_ns = now_ns + self.timing.whole_ns(size, answer)
        else:
            behind_ns = max(self.timing.gap_ns, self.timing.to_all_ns)
            self._first_ns = self._whole_ns = now_ns + self.timing.characters_ns(size) + behind_ns

    def to_send(self) -> bytes:
        """Bytes that go out now."""
        out = bytes(self._out)
        self._out.clear()
        return out


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _tries(count: int) -> str:
    return "it" if count == 1 else f"{count} tries"
