"""Pins and lines of a recorded run as VCD, which GTKWave, PulseView and sigrok read."""

from collections.abc import Callable, Sequence
from io import TextIOWrapper
from typing import Any, BinaryIO, TextIO

from hil.recorded.exports.signal_sources import UNKNOWN, SignalCourse, SignalSource
from hil.recorded.recorded_run import RecordedRun
from hil.vocab.time import SimTimeNs


def write_vcd(
    file: BinaryIO,
    run: RecordedRun,
    sources: Sequence[SignalSource],
    names: Sequence[str],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    told: Callable[[int], object] = lambda now_ns: None,
) -> int:
    """Write signals of a window; times are simulated nanoseconds since the run's start. Answers the number of
    edges. ``told``: called with the time reached.

    Raises:
        OSError: it cannot be written.
    """
    from vcd import VCDWriter

    course = SignalCourse(run, sources, names, from_ns, to_ns)
    text = TextIOWrapper(file, "utf-8", newline="\n")
    try:
        count = _write(VCDWriter, text, run, course, from_ns, to_ns, told)
        text.flush()
    finally:
        text.detach()
    return count


def _write(
    make: Any,
    text: TextIO,
    run: RecordedRun,
    course: SignalCourse,
    from_ns: int,
    to_ns: int,
    told: Callable[[int], object],
) -> int:
    writer = make(
        text,
        timescale="1 ns",
        date=run.log.begun or "",
        version=run.log.program,
        comment=f"bench {run.runtime.name}: simulated time since the run's start",
        init_timestamp=from_ns,
    )
    variables = {
        name: writer.register_var(run.runtime.name, name, "wire", size=1, init=_value(level))
        for name, level in course.levels.items()
    }
    count = 0
    for at_ns, name, level in course.edges(told):
        writer.change(variables[name], at_ns, _value(level))
        count += 1
    writer.close(to_ns)
    return count


def _value(level: int) -> int | str:
    return "x" if level == UNKNOWN else level
