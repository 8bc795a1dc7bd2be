"""Replay of what a bench in memory has been given, with listeners at its wires and samples of its axes."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from hil.compose.replay import replay_log
from hil.core import CoreAxis
from hil.core.fields import reader
from hil.sim.bench import BenchRuntime
from hil.telemetry.recording import Recording, units_in
from hil.testing.kept_inputs import KeptInputs
from hil.vocab.time import NS_PER_S, SimTimeNs
from hil.vocab.wire import Wire
from hil.wire.pcapng import Record, RecordKind

LAST_NS = 2 * NS_PER_S
INTERVAL_NS = 1_000_000
"""Time before the end in which axes are sampled, and how often."""
CURRENTS = ("current_a_A", "current_b_A")
_SLOT = 0


@dataclass(frozen=True)
class BenchReplay:
    """Replay of a bench up to its present. ``difference``: the first from what its devices sent then, or
    None; ``recordings``: the last two seconds of axes, by address."""

    difference: str | None
    wire_records: Sequence[Record]
    recordings: dict[str, Recording]


def replay_bench(
    kept: KeptInputs, until_ns: SimTimeNs, axes: Iterable[str] = (), most: int | None = None
) -> BenchReplay:
    """Run a bench again. ``axes``: those to sample; ``most``: number of records of each wire to keep.

    Raises:
        ConfigError, InputLogError: as ``hil.compose.replay.replay``.
    """
    heard: dict[str, deque[HeardRecord]] = {}

    def built(runtime: BenchRuntime) -> None:
        for name, wire in runtime.wires.items():
            listen(wire, heard.setdefault(name, deque(maxlen=most)))
        for address in axes:
            begin = partial(_watch, runtime.parts.axis(address))
            if until_ns > LAST_NS:
                runtime.parts.group_of(address).at(until_ns - LAST_NS, begin)
            else:
                begin(SimTimeNs(0))

    replayed = replay_log(kept.log(), built)
    runtime, difference = replayed.runtime, replayed.difference()
    runtime.advance(until_ns)
    records = wire_records(runtime.wires, heard)
    return BenchReplay(difference, records, {name: _recording(runtime.parts.axis(name)) for name in axes})


HeardRecord = tuple[SimTimeNs, int, bytes, str]
"""Time, event, bytes and comment of a record."""


def listen(wire: Wire, heard: deque[HeardRecord]) -> Callable[[Any], None]:
    """Note what a wire carries from now on; answers the watcher that does."""
    if frames := wire.frames:
        packed = frames.packed

        def watcher(event: Any) -> None:
            heard.append((event.at_ns, 0, packed(event), event.node))
    else:

        def watcher(event: Any) -> None:
            heard.append(_burst(event))

    wire.watchers.append(watcher)
    return watcher


def wire_records(wires: Mapping[str, Wire], heard: Mapping[str, deque[HeardRecord]]) -> list[Record]:
    """Records of what was noted, by wires."""
    return [Record(wires[name].interface(name), *each, offset=0) for name, of in heard.items() for each in of]


def _burst(event: Any) -> HeardRecord:
    kind = RecordKind.FRAMING_ERROR if event.is_damaged else RecordKind.RX
    return event.at_ns, kind, event.data, event.about


def _watch(axis: CoreAxis, now_ns: SimTimeNs) -> None:
    axis.watch(_SLOT, INTERVAL_NS, LAST_NS // INTERVAL_NS + 1)


def _recording(axis: CoreAxis) -> Recording:
    """Samples of where it was, where it should have been, and its currents."""
    signals = (*axis.kind.course, *CURRENTS)
    reads: list[Callable[[bytes], float]] = [reader(name) for name in ("at_ns", *signals)]
    rows = [tuple(read(packed) for read in reads) for packed in axis.take_samples(_SLOT)]
    return Recording(signals, rows, units=units_in(axis.snapshot().as_dict()))
