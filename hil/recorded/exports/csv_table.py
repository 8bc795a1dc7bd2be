"""Samples of a recorded run as one table of CSV."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import BinaryIO

from hil.core.fields import described
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.sampled import Chunk, sampled
from hil.telemetry.recording import own_units
from hil.telemetry.sampler import Interval
from hil.vocab.time import NS_PER_S, SimTimeNs

NUMBERS = {"f32": "%.9g", "f64": "%r", "i32": "%d", "i64": "%d"}
"""Formats of numbers by their types: read back, they are the same. Nine digits tell any two floats of 32 bits
apart."""


def column(field: RunField, unit: str | None = None) -> str:
    """Name of a column: that of the field, and its unit where the name does not end with it. ``unit``: of a
    board's own field."""
    unit = described(field.name).unit if unit is None else unit
    return str(field) if not unit or field.name.endswith(f"_{unit}") else f"{field} [{unit}]"


def slices(
    run: RecordedRun,
    fields: Sequence[RunField],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
    told: Callable[[int], object],
) -> Iterator[list[Chunk]]:
    """Chunks of all axes, slice by slice of simulated time. ``told``: called with the time reached."""
    axes = len({field.axis for field in fields})
    chunks = sampled(run, fields, from_ns, to_ns, interval_ns)
    while slice_of := [*islice(chunks, axes)]:
        yield slice_of
        told(run.now_ns)


def csv_lines(
    run: RecordedRun,
    fields: Sequence[RunField],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
    told: Callable[[int], object] = lambda now_ns: None,
) -> Iterator[str]:
    """Pieces of the table, the header first: ``at_s``, simulated seconds since the run's start, exact to the
    nanosecond, and a column for each field, axis by axis."""
    of_axes: dict[str, list[RunField]] = {}
    for field in fields:
        of_axes.setdefault(field.axis, []).append(field)
    ordered = [field for of_axis in of_axes.values() for field in of_axis]
    kinds = {axis: run.runtime.parts.axis(axis).kind for axis in of_axes}
    heads = [column(field, own_units(kinds[field.axis], [field.name]).get(field.name)) for field in ordered]
    yield ",".join(["at_s", *heads]) + "\n"
    cells = [
        ",".join(NUMBERS[described(field.name).type] for field in of_axis) for of_axis in of_axes.values()
    ]
    for chunks in slices(run, ordered, from_ns, to_ns, interval_ns, told):
        times = [[row[0] for row in chunk.rows] for chunk in chunks]
        is_whole = all(each == times[0] for each in times)
        yield "".join(_whole(chunks, cells) if is_whole else _with_gaps(chunks, cells))


def _whole(chunks: Sequence[Chunk], cells: Sequence[str]) -> list[str]:
    """Lines of chunks that have the same times."""
    line = ",".join(["%d.%09d", *cells]) + "\n"
    if len(chunks) == 1:
        return [line % (*divmod(row[0], NS_PER_S), *row[1:]) for row in chunks[0].rows]
    lines = []
    for first, *more in zip(*(chunk.rows for chunk in chunks), strict=True):
        values = [*divmod(first[0], NS_PER_S), *first[1:]]
        for each in more:
            values += each[1:]
        lines.append(line % tuple(values))
    return lines


def _with_gaps(chunks: Sequence[Chunk], cells: Sequence[str]) -> list[str]:
    """Lines of chunks that have not: a reload has taken an axis away, or brought it."""
    of_axes = [
        {row[0]: of_axis % row[1:] for row in chunk.rows}
        for chunk, of_axis in zip(chunks, cells, strict=True)
    ]
    empty = ["," * of_axis.count(",") for of_axis in cells]
    lines = []
    for at_ns in sorted({at_ns for rows in of_axes for at_ns in rows}):
        seconds, parts = divmod(int(at_ns), NS_PER_S)
        texts = [rows.get(at_ns, gap) for rows, gap in zip(of_axes, empty, strict=True)]
        lines.append(f"{seconds}.{parts:09d},{','.join(texts)}\n")
    return lines


def write_csv(
    file: BinaryIO,
    run: RecordedRun,
    fields: Sequence[RunField],
    from_ns: SimTimeNs,
    to_ns: SimTimeNs,
    interval_ns: Interval,
    told: Callable[[int], object] = lambda now_ns: None,
) -> int:
    """Write the table; answers the number of its rows. Raises OSError: it cannot be written."""
    count = -1
    for piece in csv_lines(run, fields, from_ns, to_ns, interval_ns, told):
        file.write(piece.encode())
        count += piece.count("\n")
    return count
