"""Watch on samples of a twin's axis."""

from collections.abc import Callable
from fractions import Fraction

from hil.telemetry import Sampler


class Samples:
    """Watch on samples of an axis, which wait in the core until they are taken."""

    def __init__(
        self, sampler: Sampler, axis: str, interval_ns: int | Fraction, call: Callable[[bytes], object]
    ) -> None:
        self._sampler = sampler
        self._subscription = sampler.subscribe(axis, (), interval_ns)
        self._call = call

    @property
    def lost(self) -> int:
        return self._subscription.lost

    def flush(self) -> None:
        self._sampler.poll_axis(self._subscription.axis)
        for packed in self._subscription.take_packed():
            self._call(packed)

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)
