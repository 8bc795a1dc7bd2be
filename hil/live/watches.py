"""Watches of the control socket's clients: samples that wait for them, and an end when they forget."""

import asyncio
from collections.abc import Collection
from dataclasses import dataclass

from hil.sim.bench import BenchRuntime
from hil.telemetry import Sampler, Subscription
from hil.telemetry.sampler import MAX_SAMPLES_PER_S, QUEUE_SAMPLES
from hil.vocab.address import owner_of

MAX_WATCHES = 256
"""Maximum number of watches of the control socket's clients."""
MOST_WAITING = QUEUE_SAMPLES // 2
"""Maximum number of samples that wait for all of them together: 50 MB, or 5 s of one at the shortest
interval."""
_LONGEST_POLL_S = 0.1
_SHORTEST_POLL_S = 0.001


@dataclass
class _Watch:
    subscription: Subscription
    asked_s: float


class Watches:
    """Polls the bench's sampler while anybody watches. Runs in the event loop."""

    def __init__(self, bench: BenchRuntime, speed: float, idle_s: float) -> None:
        self.sampler = Sampler(bench, MAX_SAMPLES_PER_S)
        self._bench = bench
        self._speed = speed
        self._idle_s = idle_s
        self._open: dict[int, _Watch] = {}
        self._next_id = 1
        self._timer: asyncio.TimerHandle | None = None

    def exchanged(self, names: Collection[str]) -> None:
        """Note that these devices were added, removed or exchanged in this step."""
        for axis in self.sampler.watched():
            if owner_of(axis) not in names:
                continue
            if axis in self._bench.parts.axes:
                self.sampler.exchanged(axis)
            else:
                self.sampler.gone(axis)

    def open(self, axis: str, signals: tuple[str, ...], interval_ns: int, points: int = 1) -> int:
        """Start a watch; answers its number. Raises ValueError as ``Sampler.subscribe``."""
        if len(self._open) >= MAX_WATCHES:
            raise ValueError(f"{MAX_WATCHES} watches are open already; end one, or use one of them")
        loop = asyncio.get_running_loop()
        watch, self._next_id = self._next_id, self._next_id + 1
        subscription = self.sampler.subscribe(axis, signals, interval_ns, points)
        self._open[watch] = _Watch(subscription, loop.time())
        self._poll()
        return watch

    def drain(self, watch: int, at_most: int) -> tuple[list[tuple[float, ...]], int]:
        """Take the rows since the last call, and the losses since the start. Raises KeyError: it is over."""
        held = self._open[watch]
        held.asked_s = asyncio.get_running_loop().time()
        self.sampler.poll()
        self._keep_limit()
        return held.subscription.drain(at_most), held.subscription.lost

    def close(self, watch: int) -> None:
        """End a watch, if it has not ended."""
        if held := self._open.pop(watch, None):
            self.sampler.unsubscribe(held.subscription)

    def stop(self) -> None:
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def _keep_limit(self) -> None:
        """Let the watches with most samples lose the oldest ones: fewer than their share stay."""
        queues = sorted((held.subscription for held in self._open.values()), key=lambda each: each.waiting)
        left = MOST_WAITING
        for number, queue in enumerate(queues):
            queue.keep(left // (len(queues) - number))
            left -= queue.waiting

    def _poll(self) -> None:
        self.stop()
        loop = asyncio.get_running_loop()
        for watch in [w for w, held in self._open.items() if loop.time() - held.asked_s > self._idle_s]:
            self.close(watch)
        self.sampler.poll()
        self._keep_limit()
        if period_ns := self.sampler.period_ns:
            wait_s = period_ns * 1e-9 / self._speed / 2
            self._timer = loop.call_later(min(max(wait_s, _SHORTEST_POLL_S), _LONGEST_POLL_S), self._poll)
