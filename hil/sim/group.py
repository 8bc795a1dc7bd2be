"""A group: devices that share one simulated time, advanced with their axes.

The core runs the axes up to the group's horizon, the earliest time at which a firmware has to run; the
firmware runs at exactly that time; and so on. This loop is the same in real and in virtual time.
"""

from collections.abc import Callable
from heapq import heapify, heappop, heappush

from hil.core import Core
from hil.sim.device import Answer, Device
from hil.sim.inputs import Input
from hil.vocab.time import FOREVER, SimTimeNs

_ASK_EVERY = 16
"""Number of steps between two looks at whether the time is over."""


class Group:
    """Devices in the order of their index, which decides ties. The caller owns the group in the core."""

    def __init__(self, core: Core, group: int) -> None:
        self._core = core
        self._native = core.native
        self.id = group
        self.devices: list[Device] = []
        self._timers: list[tuple[int, int, Callable[[SimTimeNs], None]]] = []
        self._timer_count = 0
        self._index: dict[int, int] = {}
        """Indices of devices, by their axes."""
        self._due: list[tuple[int, int]] = []
        """Heap of due times with devices' indices; some are outdated. Only used with several devices."""

    def add(self, device: Device) -> None:
        self._index[device.axis.id] = len(self.devices)
        self.devices.append(device)
        self._due = [(each.due_ns, place) for place, each in enumerate(self.devices)]
        heapify(self._due)

    def __enter__(self) -> None:
        """Own it, in real time: for the block the core's thread leaves it alone."""
        self._native.acquire(self.id)

    def __exit__(self, *_: object) -> None:
        self.give_back()

    def give_back(self) -> None:
        """Return it to the core's thread, which goes on as far as what is waited for now: an interrupt may
        have come last, or what an input has caused."""
        self._native.advance(self.id, self.due_ns, self.now_ns)
        self._native.release(self.id)

    @property
    def now_ns(self) -> SimTimeNs:
        return SimTimeNs(self._native.now(self.id))

    @property
    def due_ns(self) -> SimTimeNs:
        """Earliest time at which a firmware has to run."""
        timer_ns = self._timers[0][0] if self._timers else FOREVER
        if len(self.devices) == 1:
            due_ns = self.devices[0].due_ns
        else:
            due = self._due
            while due and due[0][0] != self.devices[due[0][1]].due_ns:
                heappop(due)
            due_ns = SimTimeNs(due[0][0]) if due else FOREVER
        return due_ns if due_ns < timer_ns else SimTimeNs(timer_ns)

    def at(self, at_ns: int, call: Callable[[SimTimeNs], None]) -> None:
        """Schedule a call for a time that has not been reached yet, before the firmwares that run then."""
        self._timer_count += 1
        heappush(self._timers, (at_ns, self._timer_count, call))

    def advance(self, until_ns: SimTimeNs, is_over: Callable[[], bool] | None = None) -> None:
        """Run axes and firmwares up to and at ``until_ns``; never back. It stops before where ``is_over``
        says so, which is asked now and then. The core does some milliseconds' work in one call, so that
        Ctrl-C is heard however far it has to go."""
        steps = 0
        while True:
            horizon_ns = self.due_ns
            now_ns, has_news = self._native.advance(self.id, horizon_ns, until_ns)
            if has_news:
                self._interrupts()
            if now_ns >= horizon_ns:
                self._step(SimTimeNs(now_ns))
                steps += 1
                asks = steps % _ASK_EVERY == 0
            elif now_ns >= until_ns:
                return
            else:
                asks = True
            if is_over and asks and self.due_ns > now_ns and is_over():
                return  # all of this time has happened: an input that comes now comes after it

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
        due = self._due
        while due and due[0][0] <= now_ns:
            _, index = heappop(due)
            device = self.devices[index]
            if device.due_ns <= now_ns:
                device.step(now_ns)
            if (due_ns := device.due_ns) < FOREVER:
                heappush(due, (due_ns, index))

    def apply(self, device: Device, given: Input) -> Answer:
        """Let an input take effect now, and the firmware run on it, also if it is refused. Returns a verb's
        answer.

        Raises:
            VerbRefused: as ``Device.apply``.
        """
        now_ns = self.now_ns
        try:
            return device.apply(given, now_ns)
        finally:
            device.step(now_ns)
            self.note_due(device)

    def note_due(self, device: Device) -> None:
        """Note that a device may be due at another time, for another reason than that it was due."""
        if len(self.devices) > 1 and (due_ns := device.due_ns) < FOREVER:
            heappush(self._due, (due_ns, self._index[device.axis.id]))

    def _interrupts(self) -> None:
        for event in self._core.take_events(self.id):
            device = self.devices[self._index[event.axis]]
            device.interrupt(event)
            self.note_due(device)
        if self._native.failed(self.id):
            for device in self.devices:
                if not device.failed:
                    device.fail("the ring of its interrupts' events overflowed")
