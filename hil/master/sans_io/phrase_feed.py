"""One phrase of a run over a line: upload, release, the rest by time, the end.

A board tells nobody how many commands wait in it, and drops what is too much. So the plan's times say when a
command has room. The release is the start of all times: it is read when its packet has come, at the earliest
when it can have come, at the latest by the line's latency later.

Nobody answers a release to all. So each node gets it once more by itself, and answers: it does nothing at one
that has heard the first, and lets another begin some milliseconds late, which is counted from then on.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from itertools import chain

from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import CommandOfFile, RunPhrase
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.vocab.path_planning import NodeCommand
from hil.vocab.time import FOREVER, NS_PER_MS

IN_HAND = 2
"""Commands that are handed to the line at once, so that it is never idle."""
AHEAD_US = 600_000.0
"""Lead of a command over the time at which it is needed. A board that is busy with something else reads it
less than this late."""
RESTARTS = 2
"""Number of times that an upload may begin again."""
END_NS = 5 * NS_PER_MS
"""Time behind the planned end until a phrase is over: clocks of boards differ by 50 millionths."""
_US = 1000


class PhraseFeed:
    """Feed of one phrase. ``failed`` is called once with a reason if it cannot be kept.

    Long because what was sent, what the node has and what is confirmed are three counts of one queue.
    """

    def __init__(
        self,
        master: NodeMaster,
        units: Mapping[str, int],
        phrase: RunPhrase,
        failed: Callable[[str], None],
    ) -> None:
        self._master, self._units, self._phrase, self._failed = master, units, phrase, failed
        self._source: Iterator[CommandOfFile] = iter(phrase.commands)
        self._next: CommandOfFile | None = next(self._source, None)
        self._starts_us: dict[str, list[float]] = {axis: [] for axis in units}
        self._pulses: dict[str, list[tuple[float, float, int]]] = {axis: [] for axis in units}
        self._lines: list[tuple[float, int]] = []
        self._uploaded: list[CommandOfFile] = []
        self._restarts = 0
        self._is_unsure = False
        """True if a node may have a command of the upload, or not."""
        self._in_hand = 0
        self._awaited: set[str] = set()
        """Axes whose last command has no answer yet."""
        self._last_us = 0.0
        self._release: Transaction | None = None
        self._late_us: dict[str, float] = {}
        """Time by which an axis may have begun late, of those that have confirmed their release."""
        self._is_ended = False
        self.packets = 0

    # ---- times ----

    @property
    def is_released(self) -> bool:
        """True once the release has gone out: from then on axes may move."""
        return self._release is not None and self._release.sent > 0

    @property
    def _sent_ns(self) -> int:
        assert self._release
        return self._release.sent_ns + self._master.timing.characters_ns(len(self._release.frame))

    def at_us(self, now_ns: int) -> float:
        """Time of the phrase, at least; negative before its release."""
        if not self.is_released:
            return -1.0
        return (now_ns - self._sent_ns - self._master.timing.latency_ns) / _US

    def done_s(self, now_ns: int) -> float:
        """Part of its planned time that is over, in seconds."""
        return min(max(self.at_us(now_ns), 0.0) / 1e6, self._phrase.duration_s)

    def line_at(self, now_ns: int) -> int:
        """Line of the program that moves now."""
        place = bisect_right(self._lines, (self.at_us(now_ns), FOREVER))
        return self._lines[place - 1][1] if place else self._phrase.place.line

    def is_over(self, now_ns: int) -> bool:
        """True if all axes stand at their ends."""
        return self._is_fed and self.at_us(now_ns) * _US >= self._end_us * _US + END_NS

    @property
    def _is_fed(self) -> bool:
        return self._next is None and not self._in_hand and self._is_confirmed

    @property
    def _is_confirmed(self) -> bool:
        """True if each axis that moves is known to have begun."""
        return self.is_released and all(axis in self._late_us for axis in self._starts_us if self.moves(axis))

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do."""
        if self._is_ended:
            return FOREVER
        if self._is_fed:
            return self._at_ns(self._end_us) + END_NS + 1
        if self._next and self._next.command.axis in self._late_us and self._has_hand(self._next.command):
            return self._at_ns(self._goes_us(self._next.command)) + 1
        return FOREVER

    def _at_ns(self, at_us: float) -> int:
        return round(self._sent_ns + self._master.timing.latency_ns + at_us * _US)

    def _room_us(self, axis: str) -> float:
        """Time from which a board has room for one more command."""
        starts_us, room = self._starts_us[axis], self._master.nodes.queue_length - 1
        return starts_us[-room] + self._late_us[axis] if len(starts_us) >= room else 0.0

    @property
    def _end_us(self) -> float:
        """Time of the phrase at which its axes stand; a braking changes it."""
        late_us = max(self._late_us.values(), default=0.0)
        return max(self._phrase.duration_s * 1e6, self._last_us) + late_us

    # ---- work ----

    def advance(self, now_ns: int) -> None:
        """Send what is due."""
        if self._is_ended:
            return
        at_us = self.at_us(now_ns)
        if self._is_unsure and not self._in_hand:
            self._drop_all(now_ns)
        while self._next and self._has_hand(self._next.command) and self._may_go(self._next.command, at_us):
            this, self._next = self._next, next(self._source, None)
            self._send(this, now_ns)
            if self._is_ended:
                return
        if self._release is None and not (self._in_hand or self._is_unsure or self._is_ended):
            self._release = self._master.release(now_ns)
            for axis in self._starts_us:
                if self.moves(axis):
                    self._confirm(axis, now_ns)

    def _has_hand(self, command: NodeCommand) -> bool:
        """True if a command may be handed to the line: what waits for one node behind a command that is lost
        would be carried out without it."""
        return self._in_hand < IN_HAND and command.axis not in self._awaited

    def _may_go(self, command: NodeCommand, at_us: float) -> bool:
        if self._is_unsure:
            return False
        if self._release is None:
            room = min(self._phrase.ahead, self._master.nodes.queue_length - 1)
            return len(self._starts_us[command.axis]) < room
        return command.axis in self._late_us and self._goes_us(command) <= at_us

    def _goes_us(self, command: NodeCommand) -> float:
        """Time at which a command goes out: when its board has room, and not long before it is needed, so
        that a braking acts soon; as many as before the release wait there at least."""
        starts_us, ahead = self._starts_us[command.axis], self._phrase.ahead
        waits_us = starts_us[-ahead] + self._late_us[command.axis] if len(starts_us) >= ahead else 0.0
        return max(self._room_us(command.axis), min(command.needed_us - AHEAD_US, waits_us))

    def _drop_all(self, now_ns: int) -> None:
        """Let the nodes drop all that is held: nothing has moved, and the upload begins again."""
        moving = [axis for axis in self._units if self.moves(axis)]
        self._in_hand = len(moving)

        def dropped(sent: Transaction) -> None:
            self._in_hand -= 1
            self.packets += sent.sent
            if self._is_ended:
                return
            if sent.outcome is not Outcome.DONE:
                self.fail(f"node {sent.unit}, {transaction_words(sent)}")
            elif not self._in_hand:
                self._begin_again()

        for axis in moving:
            self._master.send(self._units[axis], self._master.nodes.stop_at_once, now_ns, ended=dropped)

    def _begin_again(self) -> None:
        left = [] if self._next is None else [self._next]
        self._source = chain(self._uploaded, left, self._source)
        self._uploaded, self._is_unsure = [], False
        self._next = next(self._source, None)
        for axis in self._units:
            self._starts_us[axis].clear()
            self._pulses[axis].clear()
        self._lines.clear()

    def _send(self, placed: CommandOfFile, now_ns: int) -> None:
        command = placed.command
        self._starts_us[command.axis].append(command.start_us)
        self._pulses[command.axis].append((command.start_us, command.end_us, command.pulses))
        self._lines.append((command.start_us, placed.place.line))
        self._last_us = max(self._last_us, command.end_us)
        self._in_hand += 1
        self._awaited.add(command.axis)
        if self._release is None:
            self._uploaded.append(placed)

        def ended(sent: Transaction) -> None:
            self._in_hand -= 1
            self._awaited.discard(command.axis)
            self.packets += sent.sent
            if self._is_ended:
                return
            if sent.outcome is Outcome.NOT_KNOWN and self._release is None and self._restarts < RESTARTS:
                self._restarts += not self._is_unsure
                self._is_unsure = True
            elif sent.outcome is not Outcome.DONE:
                self.fail(f"node {sent.unit} ({command.axis}), {transaction_words(sent)}")
            elif self._release is not None and self._came_us(sent) > command.needed_us:
                late_ms = (self._came_us(sent) - command.needed_us) / 1000
                said = sent.command.decode("latin-1")
                self.fail(
                    f"node {sent.unit} ({command.axis}), {said}: it came up to {late_ms:.1f} ms after it was"
                    " needed; the line is too slow"
                )

        self._master.send(self._units[command.axis], command.data, now_ns, ended=ended)

    def _confirm(self, axis: str, now_ns: int) -> None:
        """Let one node begin that has not heard the release, and know that it has begun."""

        def ended(sent: Transaction) -> None:
            self.packets += sent.sent
            if self._is_ended:
                return
            if sent.outcome is not Outcome.DONE:
                self.fail(f"node {sent.unit} ({axis}), whether it has begun: {transaction_words(sent)}")
                return
            begun_ns = sent.sent_ns + self._master.timing.characters_ns(len(sent.frame))
            self._late_us[axis] = (begun_ns - self._sent_ns) / _US

        master = self._master
        master.send(self._units[axis], master.nodes.release, now_ns, may_repeat=True, ended=ended)

    def _came_us(self, sent: Transaction) -> float:
        """Time of the phrase by which a command was at its node, at the latest."""
        timing = self._master.timing
        answer_ns = timing.turnaround_ns + timing.characters_ns(self._master.nodes.answer_bytes)
        return (sent.ended_ns - answer_ns - self._sent_ns) / _US

    def fail(self, why: str) -> None:
        """Give the phrase up."""
        if not self._is_ended:
            self._is_ended = True
            self._failed(why)

    def end(self) -> None:
        """Send nothing more, and say nothing."""
        self._is_ended = True

    def pulses_at(self, axis: str, now_ns: int) -> int:
        """Position of an axis by the plan if its release came at once, in pulses from the machine's zero."""
        at_us, done = self.at_us(now_ns + self._master.timing.latency_ns), 0.0
        for start_us, end_us, pulses in self._pulses[axis]:
            if at_us > start_us:
                done += pulses * min((at_us - start_us) / max(end_us - start_us, 1e-6), 1)
        return self._phrase.begin[axis] + round(done)

    def brake(self) -> bool:
        """Brake along the path, if it can."""
        return self._phrase.brake()

    def moves(self, axis: str) -> bool:
        """True if an axis has commands of this phrase."""
        return bool(self._starts_us[axis])

    @property
    def planned_s(self) -> float:
        """Length of the phrase."""
        return self._phrase.duration_s


def transaction_words(sent: Transaction) -> str:
    """A transaction and its outcome, for people."""
    why = f" ({sent.why})" if sent.why else ""
    return f"{sent.command.decode('latin-1')}: {sent.outcome}{why}"
