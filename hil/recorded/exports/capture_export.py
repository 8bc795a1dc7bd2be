"""Traffic of a recorded run as pcapng, as `hil capture` writes it of a bench."""

from collections.abc import Callable, Sequence
from datetime import datetime
from typing import BinaryIO

from hil.recorded.exports.run_records import record_sources, run_records
from hil.recorded.recorded_run import RecordedRun
from hil.vocab.time import NS_PER_S, SimTimeNs
from hil.wire.pcapng import RecordKind, frame_record, header, record


def epoch_ns(run: RecordedRun) -> int:
    """Wall time of simulated time 0, in ns since 1970, as the log has it; 0: it has none."""
    if not run.log.begun:
        return 0
    begun = datetime.fromisoformat(run.log.begun)
    return int(begun.replace(microsecond=0).timestamp()) * NS_PER_S + begun.microsecond * 1000


def write_capture(
    file: BinaryIO,
    run: RecordedRun,
    names: Sequence[str],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    told: Callable[[int], object] = lambda now_ns: None,
) -> int:
    """Write what passed at ports and on wires in a window; answers the number of records. Times are as of
    `hil capture`: simulated, counted from the wall's at 0.

    Raises:
        OSError: it cannot be written.
    """
    every = record_sources(run.runtime)
    numbers = {name: number for number, name in enumerate(names)}
    file.write(header(run.log.program, [every[name] for name in names]))
    since_ns, count = epoch_ns(run), 0
    for each in run_records(run, names, from_ns, to_ns, told):
        number, at_ns = numbers[each.interface], since_ns + each.at_ns
        if each.line.is_serial:
            file.write(record(number, at_ns, RecordKind(each.event), each.data, each.comment))
        else:
            file.write(frame_record(number, at_ns, each.data, each.comment))
        count += 1
    return count
