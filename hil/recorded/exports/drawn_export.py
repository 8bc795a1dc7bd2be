"""Recordings of a recorded run's axes, for pictures and drawings."""

from collections.abc import Callable, Sequence

from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.sampled import sampled
from hil.telemetry.recording import Recording, own_units, units_in
from hil.telemetry.sampler import Interval
from hil.vocab.time import NS_PER_MS, SimTimeNs

_POINTS = 5000
"""Samples of a line by default: more than a picture has columns."""
_ROUND = (1, 2, 5)


def drawn_interval_ns(length_ns: int) -> int:
    """Interval of samples for a picture of such a length: a round one, a millisecond at least."""
    interval_ns, at = int(NS_PER_MS), 0
    while length_ns > _POINTS * interval_ns:
        at += 1
        interval_ns = _ROUND[at % 3] * 10 ** (at // 3) * NS_PER_MS
    return interval_ns


def recordings(
    run: RecordedRun,
    fields: Sequence[RunField],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
    told: Callable[[int], object] = lambda now_ns: None,
) -> dict[str, Recording]:
    """Recordings of a window by axis; their drawings have the run's times."""
    found: dict[str, Recording] = {}
    for chunk in sampled(run, fields, from_ns, to_ns, interval_ns):
        if chunk.axis not in found:
            found[chunk.axis] = Recording(chunk.fields, origin_ns=0, interval_ns=float(interval_ns))
        found[chunk.axis].rows += chunk.rows
        told(run.now_ns)
    for axis, recording in found.items():
        kind = run.runtime.parts.axis(axis).kind
        own = own_units(kind, recording.signals)
        recording.units = units_in(run.runtime.snapshot(axis).as_dict()) | own
    return found
