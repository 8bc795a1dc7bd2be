"""Size of an export before it is made, and what is too much to begin unasked."""

from collections.abc import Sequence
from typing import NamedTuple

from hil.core.fields import described
from hil.recorded.exports.csv_table import column
from hil.recorded.exports.export_formats import ExportFormat
from hil.recorded.recorded_fields import RunField
from hil.telemetry.sampler import Interval

MOST_ROWS = 10_000_000
"""Maximum rows that are written without being asked for again: an hour of two axes at each control step has
24 million, which takes minutes."""
_NUMBER_BYTES = {"f32": 10, "f64": 17, "i32": 5, "i64": 8}
"""Size of a number as text, about."""
_ROW_BYTES = 15
_COMPRESSED = 4
"""Ratio by which samples in JSON become smaller in MCAP, about."""


class ExportSize(NamedTuple):
    """Size of an export, about."""

    rows: int
    size_bytes: int

    @property
    def is_large(self) -> bool:
        return self.rows > MOST_ROWS

    def words(self) -> str:
        size = self.size_bytes
        for unit in ("bytes", "kB", "MB", "GB", "TB"):
            if size < 1000 or unit == "TB":
                break
            size = round(size / 1000)
        return f"{self.rows:,} rows, about {size:,} {unit}"


def export_size(
    kind: ExportFormat, fields: Sequence[RunField], length_ns: int, interval_ns: Interval
) -> ExportSize:
    """Estimate the samples of fields in a window of this length: rows of all axes together, except in a
    table, which has one for all."""
    axes = len({field.axis for field in fields})
    samples = int(length_ns // interval_ns) + 1 if fields else 0
    rows = samples if kind.ending == "csv" else samples * axes
    row = sum(_NUMBER_BYTES[described(field.name).type] for field in fields) + _ROW_BYTES
    if kind.ending == "mcap":
        row += sum(len(column(field)) for field in fields)
        return ExportSize(rows, samples * row // _COMPRESSED)
    return ExportSize(rows, samples * row)
