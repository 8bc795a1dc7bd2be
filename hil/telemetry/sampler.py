"""Hands the samples of watched axes to any number of watchers, each with its own signals and interval."""

from collections import deque
from math import gcd
from typing import Protocol

from hil.core.fields import reader

MIN_INTERVAL_NS = 50_000
"""Three samples for each control step of a Mechaduino."""
RING_SAMPLES = 8192
"""In the core, for each watched axis: 1.2 s at the control rate. 3.3 MB."""
QUEUE_SAMPLES = 200_000
"""Of a watcher; it loses the oldest when it does not take them."""


_AT_NS = reader("at_ns")


class WatchedBench(Protocol):
    """What a sampler needs of a bench. Devices by name."""

    def watch(self, device: str, interval_ns: int, capacity: int) -> None: ...

    def take_samples(self, device: str) -> tuple[list[bytes], int]:
        """Samples since the last call, and how many were lost since ``watch``."""


class Subscription:
    """One watcher of one device."""

    def __init__(self, device: str, signals: tuple[str, ...], interval_ns: int) -> None:
        self.device = device
        self.signals = signals
        self.interval_ns = interval_ns
        self.lost = 0
        self._queue: deque[bytes] = deque()
        self._readers = tuple(reader(name) for name in signals)

    def put(self, samples: list[bytes], lost: int, interval_ns: int) -> None:
        """Samples came, ``interval_ns`` apart; ``lost`` were lost before them."""
        self.lost += lost
        if interval_ns == self.interval_ns:
            self._queue.extend(samples)
        else:
            self._queue.extend(each for each in samples if _AT_NS(each) % self.interval_ns == 0)
        while len(self._queue) > QUEUE_SAMPLES:
            self._queue.popleft()
            self.lost += 1

    def take(self, at_most: int | None = None) -> list[tuple[float, ...]]:
        """Rows of (at_ns, a value for each signal) since the last call."""
        rows = self.take_packed(at_most)
        return [(_AT_NS(row), *(read(row) for read in self._readers)) for row in rows]

    def take_packed(self, at_most: int | None = None) -> list[bytes]:
        """The same, whole snapshots in the binary layout."""
        n = len(self._queue) if at_most is None else min(at_most, len(self._queue))
        return [self._queue.popleft() for _ in range(n)]


class Sampler:
    """Watches each axis at the common divisor of its watchers' intervals."""

    def __init__(self, bench: WatchedBench) -> None:
        self._bench = bench
        self._subscriptions: dict[str, list[Subscription]] = {}
        self._lost: dict[str, int] = {}

    def subscribe(self, device: str, signals: tuple[str, ...], interval_ns: int) -> Subscription:
        """Watch a device from now on: a sample at every multiple of ``interval_ns``."""
        if interval_ns < MIN_INTERVAL_NS:
            raise ValueError(f"an interval of {interval_ns} ns; write {MIN_INTERVAL_NS} or more")
        subscription = Subscription(device, signals, interval_ns)
        self.poll()
        self._subscriptions.setdefault(device, []).append(subscription)
        self._rewatch(device)
        return subscription

    def unsubscribe(self, subscription: Subscription) -> None:
        """End it; what it has not taken stays there."""
        self.poll()
        watchers = self._subscriptions.get(subscription.device, [])
        if subscription not in watchers:
            return  # its device has gone
        watchers.remove(subscription)
        if not watchers:
            del self._subscriptions[subscription.device]
        self._rewatch(subscription.device)

    def exchanged(self, device: str) -> None:
        """Another axis has this device's name now."""
        if device in self._subscriptions:
            self._rewatch(device)

    def gone(self, device: str) -> None:
        """The device is no more; its watchers get nothing further."""
        self._subscriptions.pop(device, None)

    def poll(self) -> None:
        """Bring what the core has; at least every ``period_ns`` of simulated time."""
        for device in self._subscriptions:
            self.poll_device(device)

    def poll_device(self, device: str) -> None:
        """The same, of one device."""
        if device not in self._subscriptions:
            return
        samples, lost = self._bench.take_samples(device)
        new, self._lost[device] = lost - self._lost[device], lost
        interval_ns = self._interval_ns(device)
        for subscription in self._subscriptions[device]:
            subscription.put(samples, new, interval_ns)

    @property
    def period_ns(self) -> int | None:
        """How long until a core's ring is half full; None: nobody watches."""
        intervals = [self._interval_ns(device) for device in self._subscriptions]
        return min(intervals) * RING_SAMPLES // 2 if intervals else None

    def _interval_ns(self, device: str) -> int:
        return gcd(*(s.interval_ns for s in self._subscriptions.get(device, [])))

    def _rewatch(self, device: str) -> None:
        self._lost[device] = 0
        self._bench.watch(device, self._interval_ns(device), RING_SAMPLES)
