"""A run over a line: phrases of commands for nodes, one after the other, with what is between them.

Each phrase is uploaded, released by a broadcast, and fed by time (``phrase_feed.py``). If a node does not
take a command, or the port goes, all nodes are stopped, and the report says where each axis is: known while
it has not been released, and at the planned end of a phrase; not known where a motion was cut short. No node
tells where it is.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Literal

from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.phrase_feed import PhraseFeed, transaction_words
from hil.master.sans_io.run_items import (
    AxisEnd,
    RunDwell,
    RunItem,
    RunPause,
    RunPhrase,
    RunProgress,
    RunReport,
    RunState,
    RunSwitch,
)
from hil.master.sans_io.transaction import Outcome, Transaction
from hil.vocab.time import FOREVER, NS_PER_S

How = Literal["grace", "prejudice"]
_STOPS: Mapping[How, str] = {"grace": "a controlled stop", "prejudice": "an immediate stop"}
GRACE_S = 2.0
"""Longest rest of a phrase that a controlled stop lets come to its end."""
AS_TOLD = "by what it was told: it has done all of it"
AT_REST = "it was not released, and has not moved since"


class LineRun:
    """Run over the line of a master. ``units``: addresses of the axes' nodes.

    ``items``: what is to be done, taken one by one; ``begin``: where the axes stand, in pulses from the
    machine's zero; ``brakes``: by axis, the command that sets the deceleration for a controlled stop;
    ``changed``: asked before each item, answers other items for the rest, or None; ``switched``: told of each
    switch whose commands are done, for what is no node's.

    Long because start, pause, stop and failure are ways between the same few states.
    """

    def __init__(
        self,
        master: NodeMaster,
        units: Mapping[str, int],
        items: Iterator[RunItem],
        *,
        begin: Mapping[str, int] | None = None,
        brakes: Mapping[str, bytes] | None = None,
        changed: Callable[[], Iterator[RunItem] | None] = lambda: None,
        switched: Callable[[RunSwitch], None] = lambda switch: None,
    ) -> None:
        self.master = master
        self.state = RunState.READY
        self.why = ""
        self.wants_pause = False
        """True if it pauses before the next item."""
        self._units, self._items = units, items
        self._brakes = dict(brakes or {})
        self._changed, self._switched = changed, switched
        self._where: dict[str, AxisEnd] = {
            axis: AxisEnd(axis, unit, (begin or {}).get(axis, 0), AT_REST) for axis, unit in units.items()
        }
        self._feed: PhraseFeed | None = None
        self._phrase: RunPhrase | None = None
        self._until_ns: int | None = None
        self._done_s = 0.0
        self._line = 0
        self._packets = 0
        self._begun_ns = self._now_ns = 0
        self._strays = 0
        self._is_at_once = False
        self._stops: list[Transaction] = []
        self._end_state = RunState.STOPPED

    # ---- what is asked for ----

    def start(self, at_ns: int) -> None:
        """Begin."""
        self._begun_ns = self._now_ns = at_ns
        self.state = RunState.RUNNING
        self._strays = self._count_strays()
        self.advance(at_ns)

    def pause(self) -> None:
        """Pause where all axes rest: behind a braking along the path, else before the next item."""
        self.wants_pause = True
        self._brake()

    def resume(self, at_ns: int) -> None:
        """Go on behind a pause."""
        self.wants_pause = False
        if self.state is RunState.PAUSED:
            self.state = RunState.RUNNING
            self.advance(at_ns)

    def stop(self, at_ns: int, how: How = "grace", why: str = "") -> None:
        """Stop all axes. ``grace``: by a braking along the path, or at the end of a phrase that ends within
        ``GRACE_S``, which keeps their places known; else by their own decelerations."""
        if self.state.is_over or self._is_at_once or (self.state is RunState.STOPPING and how == "grace"):
            return
        why = why or f"{_STOPS[how]} was asked for"
        if how == "grace" and (self._brake() or self._ends_soon(at_ns)):
            self.why, self.state = why, RunState.STOPPING
            return
        self._stop(at_ns, how, why, RunState.STOPPED)

    def _ends_soon(self, now_ns: int) -> bool:
        feed = self._feed
        return feed is not None and feed.is_released and feed.planned_s - feed.done_s(now_ns) <= GRACE_S

    def _brake(self) -> bool:
        return self._feed is not None and self._feed.is_released and self._feed.brake()

    @property
    def is_over(self) -> bool:
        return self.state.is_over

    def progress(self, now_ns: int) -> RunProgress:
        """Progress by now."""
        feed = self._feed
        done_s = self._done_s + (feed.done_s(now_ns) if feed else 0.0)
        return RunProgress(self.state, done_s, feed.line_at(now_ns) if feed else self._line)

    @property
    def report(self) -> RunReport:
        """State and places of the axes; final when it is over."""
        took_s = (self._now_ns - self._begun_ns) / NS_PER_S
        feed_packets = self._feed.packets if self._feed else 0
        return RunReport(
            self.state,
            self.why,
            self.progress(self._now_ns).line,
            took_s,
            self._packets + feed_packets,
            tuple(self._where.values()),
        )

    # ---- bytes and time ----

    def receive(self, data: bytes, at_ns: int) -> None:
        """Take bytes of the line."""
        self.master.receive(data, at_ns)
        self.advance(at_ns)

    def due_ns(self) -> int:
        """Time at which ``advance`` has something to do."""
        dues = [self.master.due_ns()]
        if self._feed and not self.state.is_over:
            dues.append(self._feed.due_ns())
        if self.state is RunState.RUNNING and self._until_ns is not None:
            dues.append(self._until_ns)
        return min(dues)

    def advance(self, now_ns: int) -> None:
        """Do what is due."""
        self._now_ns = max(now_ns, self._now_ns)
        if not self.state.is_over:
            self._work(now_ns)
        self.master.advance(now_ns)
        if not self.state.is_over:
            self._work(now_ns)

    def to_send(self) -> bytes:
        """Bytes that go out now."""
        return self.master.to_send()

    def lose(self, at_ns: int, why: str) -> None:
        """Note that the port has gone: nobody can be stopped any more."""
        self._now_ns = max(at_ns, self._now_ns)
        if self.state.is_over:
            return
        is_moving = self._note_where(f"{why}: it could not be stopped, and does what it was sent")
        self.state, self.why = RunState.FAILED, why + ("; axes may still move" if is_moving else "")
        if self._feed:
            self._feed.end()
        self.master.lose(at_ns, why)

    # ---- one item after the other ----

    def _work(self, now_ns: int) -> None:
        if self.state is RunState.STOPPING and self._feed:
            self._feed.advance(now_ns)
            if self._feed and self._feed.is_over(now_ns):
                self._phrase_over()
                self.state = RunState.STOPPED
            return
        if self.state is RunState.STOPPING:
            if all(each.is_over for each in self._stops):
                self._stopped()
            return
        if self._count_strays() != self._strays:
            self._strays = self._count_strays()
            self._failed("a node answered something that was not sent to it, or long ago: it may have obeyed")
        while self.state is RunState.RUNNING:
            if self._feed:
                self._feed.advance(now_ns)
                if self.state is not RunState.RUNNING or not self._feed.is_over(now_ns):
                    return
                self._phrase_over()
            elif self._until_ns is not None:
                if now_ns < self._until_ns:
                    return
                self._until_ns = None
            elif not self._begin_next(now_ns):
                return

    def _begin_next(self, now_ns: int) -> bool:
        """Begin the next item; answers whether there is something to do at once."""
        if self.wants_pause:
            self.wants_pause, self.state = False, RunState.PAUSED
            return False
        if (items := self._changed()) is not None:
            self._items = items
        item = next(self._items, None)
        if item is None:
            self.state = RunState.ENDED
            return False
        if isinstance(item, RunPause):
            self._line, self.state = item.line, RunState.PAUSED
        elif isinstance(item, RunDwell):
            self._line, self._until_ns = item.line, now_ns + round(item.seconds * NS_PER_S)
            self._done_s += item.seconds
        elif isinstance(item, RunSwitch):
            self._line = item.line
            self._switch(item, 0, now_ns)
        else:
            self._phrase = item
            self._feed = PhraseFeed(self.master, self._units, item, self._failed)
        return True

    def _count_strays(self) -> int:
        table = self.master.table
        return sum(table[unit].strays for unit in self._units.values() if unit in table)

    def _switch(self, item: RunSwitch, place: int, now_ns: int) -> None:
        """Send the commands of a switch, each when the one before is done."""
        if place == len(item.commands):
            self._until_ns = now_ns
            self._switched(item)
            return
        self._until_ns = FOREVER
        unit, data = item.commands[place]

        def ended(sent: Transaction) -> None:
            self._packets += sent.sent
            if self.state is not RunState.RUNNING:
                return
            if sent.outcome in (Outcome.DONE, Outcome.SENT):
                self._switch(item, place + 1, sent.ended_ns)
            else:
                self._failed(f"{item.name}: node {sent.unit}, {transaction_words(sent)}")

        self.master.send(unit, data, now_ns, ended=ended)

    def _phrase_over(self) -> None:
        assert self._feed
        assert self._phrase
        for axis, pulses in self._phrase.end.items():
            self._where[axis] = AxisEnd(axis, self._units[axis], pulses, AS_TOLD)
        self._done_s += self._feed.planned_s
        self._line, self._packets = self._feed.line_at(FOREVER), self._packets + self._feed.packets
        self._feed.end()
        self._feed = self._phrase = None

    # ---- ends ----

    def _failed(self, why: str) -> None:
        if self.master.is_lost:
            self.lose(self._now_ns, why)
        else:
            self._stop(self._now_ns, "grace", why, RunState.FAILED)

    def _stop(self, at_ns: int, how: How, why: str, state: RunState) -> None:
        self._now_ns = max(at_ns, self._now_ns)
        if self._feed:
            self._note_where(f"{_STOPS[how]} cut its motion short")
            self._feed.end()
            self._packets += self._feed.packets
            self._line = self._feed.line_at(at_ns)
            self._feed = None
        if not self._stops:
            self.why, self._end_state = why, state
        self.state, self._is_at_once = RunState.STOPPING, how == "prejudice"
        self.master.cancel(at_ns, "the run was stopped")
        if how == "grace":
            for axis, brake in self._brakes.items():
                self.master.send(self._units[axis], brake, at_ns, tries=1, is_urgent=True)
        units = dict.fromkeys(self._units.values())
        self._stops = self.master.stop(units, at_ns, is_at_once=how == "prejudice")

    def _stopped(self) -> None:
        for stop in self._stops:
            if stop.answer_bytes and stop.outcome is not Outcome.DONE:
                for axis, unit in self._units.items():
                    if unit == stop.unit:
                        where, said = self._where[axis], transaction_words(stop)
                        why = f"{where.why}; whether it stopped is not known: {said}"
                        self._where[axis] = where._replace(pulses=None, why=why)
        self.state = self._end_state

    def _note_where(self, why: str) -> bool:
        """Note that axes that may be moving are cut short; answers whether some are."""
        feed = self._feed
        if not (feed and feed.is_released):
            return False
        moving = [axis for axis in self._units if feed.moves(axis)]
        for axis in moving:
            about = feed.pulses_at(axis, self._now_ns)
            self._where[axis] = AxisEnd(axis, self._units[axis], None, why, about)
        return bool(moving)
