"""A group: devices that share one simulated time, advanced with their axes.

The core runs the axes up to the group's horizon, the earliest time at which a firmware has to run; the
firmware runs at exactly that time; and so on. This loop is the same in real and in virtual time.
"""

from collections import deque
from collections.abc import Callable, Iterator
from heapq import heappop, heappush

from hil.core import Core
from hil.sim.inputs import Input
from hil.sim.twin import Twin
from hil.sim.verb_calls import Answer
from hil.vocab.firmware import CoreEvent
from hil.vocab.time import FOREVER, SimTimeNs


class DueTimes:
    """Due times by the devices' indices, which decide between devices of one time. ``due_of(index)`` is the
    truth: an entry with another time is outdated and means nothing."""

    def __init__(self, due_of: Callable[[int], int]) -> None:
        self._due_of = due_of
        self._times_ns: list[int] = []
        """Heap of all times in ``waiting``."""
        self.waiting: dict[int, list[int]] = {}
        """Indices by their times; one may stand there twice."""

    def add(self, due_ns: int, index: int) -> None:
        # Mostly many wait for one time, as for the end of a packet to everybody.
        if due_ns in self.waiting:
            self.waiting[due_ns].append(index)
        elif due_ns != FOREVER:
            self.waiting[due_ns] = [index]
            heappush(self._times_ns, due_ns)

    @property
    def first_ns(self) -> SimTimeNs:
        """Earliest time that is not outdated; drops those that are."""
        while self._times_ns:
            due_ns = self._times_ns[0]
            waiting = self.waiting[due_ns]
            while waiting and self._due_of(waiting[-1]) != due_ns:
                waiting.pop()
            if waiting:
                return SimTimeNs(due_ns)
            del self.waiting[heappop(self._times_ns)]
        return FOREVER

    def take(self, now_ns: int) -> Iterator[int]:
        """Take the entries up to now, in the order of times and indices, also those that are added meanwhile;
        some are outdated."""
        times_ns = self._times_ns
        while times_ns and times_ns[0] <= now_ns:
            due_ns = heappop(times_ns)
            left = sorted(self.waiting.pop(due_ns), reverse=True)
            try:
                while left:
                    yield left.pop()
                    if times_ns and times_ns[0] <= due_ns:
                        break
            finally:  # entries were added before these, or the taker was broken off
                for index in left:
                    self.add(due_ns, index)


_ASK_EVERY = 16
"""Number of steps between two looks at whether the time is over."""


class Group:
    """Devices in the order of their index, which decides ties. The caller owns the group in the core."""

    def __init__(self, core: Core, group: int) -> None:
        self._core = core
        self._native = core.native
        self.id = group
        self.devices: list[Twin] = []
        self._timers: list[tuple[int, int, Callable[[SimTimeNs], None]]] = []
        self._timer_count = 0
        self._index: dict[Twin, int] = {}
        self._axes: dict[int, tuple[Twin, str]] = {}
        """Twin of each axis, and the axis's name there."""
        self._due = self._due_times()
        """Due times of the devices by their indices. Only used with several devices."""
        self.is_held = False
        """True while its time stands, whatever that of the bench does: a processor of it is debugged."""
        self._events = deque[tuple[SimTimeNs, int, str, float]]()
        """Events that no firmware has heard of yet, between ``turn_ns`` and ``take_turn``."""

    def add(self, device: Twin) -> None:
        self._index[device] = len(self.devices)
        self._axes |= {axis.id: (device, name) for name, axis in device.axes.items()}
        self.devices.append(device)
        self._due = self._due_times()

    def _due_times(self) -> DueTimes:
        times = DueTimes(lambda index: self.devices[index].due_ns)
        for index, each in enumerate(self.devices):
            times.add(each.due_ns, index)
        return times

    def __enter__(self) -> None:
        """Own the group, in real time: for the block the core's thread leaves it alone."""
        self._native.acquire(self.id)

    def __exit__(self, *_: object) -> None:
        self.give_back()

    def give_back(self) -> None:
        """Return the group to the core's thread, which goes on as far as what is waited for now: an interrupt
        may have come last, or what an input has caused."""
        native = self._native
        now_ns = native.now(self.id)
        native.advance(self.id, now_ns if self.is_held else self.due_ns, now_ns)
        native.release(self.id)

    @property
    def now_ns(self) -> SimTimeNs:
        return SimTimeNs(self._native.now(self.id))

    @property
    def is_quiet(self) -> bool:
        """True if no axis can wake a firmware before it is due."""
        return bool(self._native.is_quiet(self.id))

    @property
    def due_ns(self) -> SimTimeNs:
        """Earliest time at which a firmware has to run."""
        timer_ns = self._timers[0][0] if self._timers else FOREVER
        due_ns = self.devices[0].due_ns if len(self.devices) == 1 else self._due.first_ns
        return due_ns if due_ns < timer_ns else SimTimeNs(timer_ns)

    def at(self, at_ns: int, call: Callable[[SimTimeNs], None]) -> None:
        """Schedule a call for a time that has not been reached yet, before the firmwares that run then."""
        self._timer_count += 1
        heappush(self._timers, (at_ns, self._timer_count, call))

    def advance(self, until_ns: SimTimeNs, is_over: Callable[[], bool] | None = None) -> SimTimeNs:
        """Run axes and firmwares up to and at ``until_ns``; never back. It stops before where ``is_over``
        says so, which is asked now and then. Answers the time that it has reached. The core does some
        milliseconds' work in one call, so that Ctrl-C is heard however far it has to go."""
        steps = 0
        while not self.is_held:
            horizon_ns = self.due_ns
            now_ns, has_news = self._native.advance(self.id, horizon_ns, until_ns)
            if has_news or self._events:  # some are left where a turn was broken off
                self._interrupts()
                if self.is_held:
                    break
            if now_ns >= horizon_ns:
                self._step(SimTimeNs(now_ns))
                steps += 1
                asks = steps % _ASK_EVERY == 0
            elif now_ns >= until_ns:
                return SimTimeNs(now_ns)
            else:
                asks = True
            if is_over and asks and self.due_ns > now_ns and is_over():
                return SimTimeNs(now_ns)  # all of this has happened: an input that comes now comes after it
        return self.now_ns

    def turn_ns(self) -> SimTimeNs:
        """Time of what its firmwares have to do next, as far as the core has come; FOREVER: nothing yet."""
        if self._native.has_news(self.id):
            self._events += self._core.take_events(self.id)
            self._check_ring()
        now_ns = self.now_ns
        if self._events:
            return self._events[0][0]
        return now_ns if self.due_ns <= now_ns else FOREVER

    def take_turn(self) -> None:
        """Let firmwares do what ``turn_ns`` has told the time of, and no more."""
        if self._events:
            self._interrupt(*self._events.popleft())
            self._check_ring()
        else:
            self._step(self.now_ns)

    def wait_until(self, until_ns: SimTimeNs) -> SimTimeNs:
        """Run axes, no firmware, up to ``until_ns`` or until a firmware has to run; answers the time."""
        self._native.advance(self.id, self.due_ns, until_ns)
        return self.now_ns

    def _step(self, now_ns: SimTimeNs) -> None:
        """Run the firmwares that are due, in the order of their devices."""
        while self._timers and self._timers[0][0] <= now_ns:
            heappop(self._timers)[2](now_ns)
        if len(self.devices) == 1:
            if self.devices[0].due_ns <= now_ns:
                self.devices[0].step(now_ns)
            return
        for index in self._due.take(now_ns):
            if (due_ns := self.devices[index].step(now_ns, is_due=False)) < FOREVER:  # most wait for a byte
                self._due.add(due_ns, index)

    def apply(self, device: Twin, given: Input, part: str = "") -> Answer:
        """Let an input take effect now, and the firmware run on it, also if it is refused. Returns a verb's
        answer. ``part``: as ``Twin.apply``.

        Raises:
            VerbRefused: as ``Twin.apply``.
        """
        now_ns = SimTimeNs(self._native.now(self.id))
        try:
            return device.apply(given, now_ns, part)
        finally:
            device.step(now_ns)
            if len(self.devices) > 1:  # asked here too: it is a call less
                self.note_due(device)

    def note_due(self, device: Twin, at_ns: SimTimeNs | None = None) -> None:
        """Note that a device may be due at another time, for another reason than that it was due. ``at_ns``:
        at this one beside those that are known."""
        if len(self.devices) > 1:
            index = self._index[device]
            if at_ns in (waiting := self._due.waiting):
                waiting[at_ns].append(index)  # as ``add``; each node of a line comes here at each packet
            else:
                self._due.add(device.due_ns if at_ns is None else at_ns, index)

    def _interrupts(self) -> None:
        self._events += self._core.take_events(self.id)
        while self._events:
            self._interrupt(*self._events.popleft())
        self._check_ring()

    def _interrupt(self, at_ns: SimTimeNs, axis: int, kind: str, value: float) -> None:
        device, name = self._axes[axis]
        device.interrupt(CoreEvent(at_ns, name, kind, value))
        self.note_due(device)

    def _check_ring(self) -> None:
        """Let the devices fail when events were lost, after they have heard those that were not."""
        if not self._events and self._native.failed(self.id):
            for device in self.devices:
                if not device.failed:
                    device.power.fail("the ring of its interrupts' events overflowed")
