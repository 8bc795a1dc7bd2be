"""What is watched: samples of axes, packets on segments, bytes at ports, runs."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from hil.live.captures import Capture, Captures, watch_segment
from hil.live.runs.queue import RunQueue
from hil.live.watches import Watches
from hil.operations.desk import Asked
from hil.operations.table import WATCH_IDLE_S
from hil.runs import Progress
from hil.sim.bench import BenchRuntime
from hil.telemetry import DEFAULT_SIGNALS, Sampler, check_signals
from hil.vocab.bridges import Watch, Watched
from hil.vocab.verbs import VerbRefused

SAMPLES_AT_A_TIME = 5000


class LookingOn:
    """Of one bench."""

    def __init__(self, sim: BenchRuntime, watches: Watches, captures: Captures, runs: RunQueue) -> None:
        self._sim, self._watches, self._captures, self._runs = sim, watches, captures, runs

    def ports(self) -> Sequence[str]:
        """Names of what bytes pass at."""
        return [name for name in self._captures.names if name not in self._sim.segments]

    def open(
        self, what: Watched, target: str, call: Callable[..., Any], interval_ns: int | Fraction
    ) -> Watch:
        """As ``Desk.watch``; a target of samples is a twin."""
        try:
            match what:
                case Watched.SAMPLES:
                    return Samples(self._watches.sampler, target, interval_ns, call)
                case Watched.PACKETS:
                    return _Calls(watch_segment(self._sim.segments[target], call))
                case Watched.BYTES:
                    return _Calls(self._captures.watch(target, call))
                case Watched.RUNS:
                    return self._watch_runs(call)
        except KeyError:
            raise _no_place(target, self._captures.names) from None
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def _watch_runs(self, call: Callable[..., Any]) -> Watch:
        def tell(progress: Progress) -> None:
            call(progress.as_dict())

        listeners = self._runs.listeners
        listeners.append(tell)
        return _Calls(lambda: listeners.remove(tell))

    def watch(self, asked: Asked, signals: list[str], interval_ns: int) -> dict[str, Any]:
        """The watch's number, for those who come back for its samples."""
        kind = self._sim.devices[asked.target].axis.kind
        try:
            names = check_signals(signals or DEFAULT_SIGNALS[kind], kind)
            return {
                "watch": self._watches.open(asked.target, names, interval_ns),
                "signals": names,
            }
        except ValueError as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def samples(self, asked: Asked, watch: int) -> dict[str, Any]:
        """Those since the last time."""
        try:
            rows, lost = self._watches.take(watch, SAMPLES_AT_A_TIME)
        except KeyError:
            raise VerbRefused(
                "not_now", f"watch {watch} has ended; ask for samples every {WATCH_IDLE_S} s"
            ) from None
        return {"rows": rows, "lost": lost, "sim_ns": self._sim.now_ns}

    def unwatch(self, asked: Asked, watch: int) -> dict[str, Any]:
        """Also one that has ended."""
        self._watches.close(watch)
        return {}

    def capture(self, asked: Asked, ports: list[str]) -> tuple[Capture, Callable[[], None]]:
        """A capture, which waits for a writer, and what ends it."""
        try:
            return self._captures.open(ports)
        except KeyError as error:
            raise _no_place(error.args[0], self._captures.names) from None


def _no_place(name: str, known: Sequence[str]) -> VerbRefused:
    return VerbRefused("no_place", f"there is no port {name!r}; there are {', '.join(known)}")


class _Calls:
    """Something that calls by itself until ``end``."""

    lost = 0

    def __init__(self, end: Callable[[], None]) -> None:
        self.close = end

    def take(self) -> None:
        """What there is has been told."""


class Samples:
    """Samples of an axis, which wait in the core until they are taken."""

    def __init__(
        self, sampler: Sampler, device: str, interval_ns: int | Fraction, call: Callable[[bytes], object]
    ) -> None:
        self._sampler = sampler
        self._subscription = sampler.subscribe(device, (), interval_ns)
        self._call = call

    @property
    def lost(self) -> int:
        return self._subscription.lost

    def take(self) -> None:
        self._sampler.poll_device(self._subscription.device)
        for packed in self._subscription.take_packed():
            self._call(packed)

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)
