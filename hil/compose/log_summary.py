"""Summary of a log's file from its beginning and its end: a long one is not read."""

import json
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO

from hil.compose.log_lines import GZIP_MAGIC, LogLines
from hil.compose.recordings_folder import is_written
from hil.host.regular_file import open_regular
from hil.sim.inputs import InputLogError
from hil.sim.log_reading import LogReading

_MEMBER = GZIP_MAGIC + b"\x08"
_TAIL_BYTES = 1 << 17
"""Part of a file to look for its end in: text of many checks, or a packed member."""


@dataclass(frozen=True)
class LogSummary:
    """Summary of a log. ``bench``: name, empty where the log has no header; ``begun``: date of time 0;
    ``end_ns``: time up to which it says something; ``why``: reason in its end line, empty: it has none.
    ``inputs`` and ``faults``, by kind, are None where the log is of a version without totals.
    ``written``: a program has it open to write."""

    path: Path
    size: int
    written: bool
    bench: str = ""
    begun: datetime | None = None
    speed: float = 1.0
    end_ns: int = 0
    why: str = ""
    inputs: int | None = None
    faults: Mapping[str, int] | None = field(default=None)
    problem: str = ""
    """Reason why it cannot be read."""


def summarise(path: Path) -> LogSummary:
    """Summarise a log.

    Raises:
        OSError: it cannot be read.
    """
    with open_regular(path) as file:
        size, written = os.fstat(file.fileno()).st_size, is_written(file)
        tail = list(_last_lines(file, size))
    bare = LogSummary(path, size, written)
    reading = LogReading(str(path))
    try:
        with LogLines(path) as lines:
            for line in lines.more():
                reading.add(line)
                break
        log = reading.log()
    except InputLogError as error:
        return bare if written and not size else LogSummary(path, size, written, problem=str(error))
    begun = None
    with suppress(ValueError):
        begun = datetime.fromisoformat(log.begun) if log.begun else None
    values = next((each for each in tail if "check" in each), {})
    ended = next((each for each in tail if each.get("end") is True), None)
    times = [each["at_ns"] for each in tail if isinstance(each.get("at_ns"), int)]
    has_totals = isinstance(values.get("faults", {}), dict) and isinstance(values.get("inputs"), int)
    return LogSummary(
        path,
        size,
        written,
        str(log.config.get("bench", "")),
        begun,
        log.speed,
        max(times, default=0),
        str(ended.get("why", "stopped")) if ended else "",
        values["inputs"] if has_totals else None,
        values.get("faults", {}) if has_totals else None,
    )


def _last_lines(file: BinaryIO, size: int) -> Iterator[dict[str, Any]]:
    """Whole lines at the end of the file, the last first; none where its end is damaged."""
    is_packed = file.read(2) == GZIP_MAGIC
    length = _TAIL_BYTES
    while True:
        file.seek(max(size - length, 0))
        text = file.read(length)
        if is_packed:
            text = _unpacked_tail(text)
        lines = text.split(b"\n")[:-1]
        if b'"check":' in text or length >= size:
            break
        length *= 8
    for line in reversed(lines):
        with suppress(ValueError):
            if isinstance(values := json.loads(line), dict):
                yield values


def _unpacked_tail(data: bytes) -> bytes:
    """Text of the last gzip member in some bytes that has a check, with all behind it; empty: there is
    none."""
    at, text = len(data), b""
    while b'"check":' not in text and (at := data.rfind(_MEMBER, 0, at)) >= 0:
        packer = zlib.decompressobj(wbits=31)
        with suppress(zlib.error):
            text = packer.decompress(data[at:]) + text
    return text
