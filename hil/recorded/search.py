"""Times of a recorded run at which a condition begins to hold, and how long it does.

Fields of axes are looked at each multiple of an interval, counters of wires when something has been on the
wire; these last. Bytes, packets, frames and inputs are moments: with one of them a condition holds for none.
"""

import math
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hil.net.condition import Condition, TextTest, compiled
from hil.recorded.happenings import Happening, Happenings
from hil.recorded.recorded_fields import RunField
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.sampled import LONGEST_SLICE_NS, Chunk, sampled
from hil.recorded.search_names import RECEIVED, SENT, SearchName, SearchNames, read_names, wire_counters
from hil.telemetry.sampler import Interval
from hil.vocab.time import SimTimeNs

_LINE_ENDS = re.compile(rb"[\r\n]+")
_LONGEST_LINE = 4096
"""Maximum of a line's bytes that are compared."""


@dataclass(frozen=True)
class FoundTime:
    """Time at which a condition began to hold. ``ends_ns``: time at which it did no more, None: at the end of
    what was looked at it held, the time it began: it was a moment. ``values``: what it compares, then."""

    begins_ns: int
    ends_ns: int | None
    values: Mapping[str, float | str]


def search(
    run: RecordedRun, condition: Condition, from_ns: SimTimeNs, to_ns: SimTimeNs, interval_ns: Interval
) -> Iterator[FoundTime]:
    """Find where a condition begins to hold, from a time to another, both included; the run goes there.

    Raises:
        ConditionError: it names something that is not there.
        ValueError: there is no such interval.
    """
    names = read_names(run, condition)
    happenings = Happenings(run, names.events.values(), names.counters.values())
    eye = _Eye(condition, names)
    eye.counters.update(_counters(run, names))
    before_ns = SimTimeNs(max(from_ns - 1, 0))
    run.run_until(before_ns)
    for each in happenings.until(before_ns, is_last=False) if from_ns else ():
        eye.note(each)
    if names.counters and not names.fields:
        yield from eye.happen(Happening(from_ns, from_ns, {}, eye.counters))
    for chunks in _slices(run, names, from_ns, to_ns, interval_ns):
        rows, at = eye.rows(chunks), 0
        for each in happenings.until(run.now_ns, is_last=run.now_ns >= to_ns):
            end = bisect_right(rows, each.at_ns, at, key=eye.time_of)
            yield from eye.look(rows, at, end)
            yield from eye.happen(each)
            at = end
        yield from eye.look(rows, at, len(rows))
    yield from eye.end()


def _counters(run: RecordedRun, names: SearchNames) -> Iterator[tuple[SearchName, float]]:
    for name in names.counters.values():
        yield name, wire_counters(run.runtime.wires[name.owner])[name.leaf]


def _slices(
    run: RecordedRun, names: SearchNames, from_ns: SimTimeNs, to_ns: SimTimeNs, interval_ns: Interval
) -> Iterator[Sequence[Chunk]]:
    """Go through a window slice by slice, with a chunk of each axis that is compared."""
    fields = [*dict.fromkeys(names.fields.values())]
    if not fields:
        while True:
            run.run_until(SimTimeNs(min(run.now_ns + LONGEST_SLICE_NS, to_ns)))
            yield ()
            if run.now_ns >= to_ns:
                return
    chunks = sampled(run, fields, from_ns, to_ns, interval_ns)
    yield from zip(*[chunks] * len({field.axis for field in fields}), strict=True)


class _Eye:
    """Eye of a search: what it has seen so far, and what it makes of what comes."""

    def __init__(self, condition: Condition, names: SearchNames) -> None:
        self._condition, self._names = condition, names
        self._testers = [(names.events[test.name], _tester(test, names)) for test in condition.tests]
        self.counters: dict[SearchName, float] = {}
        self._fields: dict[RunField, float] = dict.fromkeys(names.fields.values(), math.nan)
        """Latest values."""
        self._begun: FoundTime | None = None
        """Time since which it holds; None: it does not."""
        self._columns: list[RunField] = []
        """Fields of a row, in its order."""
        self._bulk: Callable[..., list[bool]] | None = None
        self._is_one = len({field.axis for field in self._fields}) < 2

    # ---- what lasts ----

    def rows(self, chunks: Sequence[Chunk]) -> list[Any]:
        """Rows of all axes side by side, of one axis alone as they are."""
        if chunks and not self._bulk:
            self._compile(chunks)
        if not chunks or self._is_one:
            return chunks[0].rows if chunks else []
        return [*zip(*(chunk.rows for chunk in chunks), strict=True)]

    def time_of(self, row: Any) -> int:
        """Time of a row."""
        return int(row[0] if self._is_one else row[0][0])

    def _compile(self, chunks: Sequence[Chunk]) -> None:
        """Make the function that looks at rows."""
        operands = dict(zip(self._condition.fields, self._condition.operands, strict=False))
        named: dict[RunField, str] = {}
        expression = self._condition.expression
        for text, field in self._names.fields.items():
            first = named.setdefault(field, operands[text])  # a field may have two addresses
            expression = re.sub(rf"\b{operands[text]}\b", first, expression)
        parts = [[RunField(chunk.axis, name) for name in chunk.fields] for chunk in chunks]
        self._columns = [field for part in parts for field in part]
        patterns = [f"(_, {', '.join(named[field] for field in part)},)" for part in parts]
        pattern = patterns[0] if self._is_one else f"({', '.join(patterns)},)"
        parameters = ", ".join(["rows", *self._condition.operands])
        self._bulk = compiled(f"lambda {parameters}: [{expression} for {pattern} in rows]")

    def look(self, rows: list[Any], begin: int, end: int) -> Iterator[FoundTime]:
        """Look at rows, none of which is at a moment."""
        if self._bulk is None or begin == end:
            return
        looked_at = rows if end - begin == len(rows) else rows[begin:end]
        held = bytes(self._bulk(looked_at, *self._operands({})))
        at = held.find(not self._begun)
        while at >= 0:
            yield from self._turn(self.time_of(looked_at[at]), looked_at[at])
            at = held.find(not self._begun, at)
        self._keep(looked_at[-1])

    def _keep(self, row: Any) -> None:
        values = row[1:] if self._is_one else [value for part in row for value in part[1:]]
        self._fields.update(zip(self._columns, values, strict=True))

    def _turn(self, at_ns: int, row: Any = None) -> Iterator[FoundTime]:
        """Note that the condition begins or ceases to hold."""
        if self._begun:
            yield replace(self._begun, ends_ns=at_ns)
            self._begun = None
            return
        if row is not None:
            self._keep(row)
        self._begun = FoundTime(at_ns, None, self._values({}))

    def end(self) -> Iterator[FoundTime]:
        """Answer what holds still."""
        if self._begun:
            yield self._begun

    # ---- what happens ----

    def note(self, happening: Happening) -> None:
        """Note what happened before there is anything to find."""
        self.counters.update(happening.counters)
        self._tested(happening)

    def happen(self, happening: Happening) -> Iterator[FoundTime]:
        """Look at a moment."""
        if happening.counters:
            self.counters.update(happening.counters)
            if self._condition.function(*self._operands({})) is not bool(self._begun):
                yield from self._turn(happening.begun_ns)
        tests = self._tested(happening)
        if happening.values and not self._begun:
            numbers = {
                name: value for name, value in happening.values.items() if isinstance(value, int | float)
            }
            if self._condition.function(*self._operands(numbers)[: len(self._condition.fields)], *tests):
                yield FoundTime(happening.begun_ns, happening.begun_ns, self._values(happening.values))

    def _tested(self, happening: Happening) -> list[bool | None]:
        """Outcomes of the tests, None of those that are of something else."""
        texts = {name: _text(value) for name, value in happening.values.items()}
        return [test(texts[name]) if name in texts else None for name, test in self._testers]

    def _operands(self, numbers: Mapping[SearchName, float]) -> list[float | None]:
        """Values of all operands now, without tests."""
        names = self._names
        values = [
            self._fields[names.fields[text]]
            if text in names.fields
            else self.counters[names.counters[text]]
            if text in names.counters
            else numbers.get(names.events[text], math.nan)
            for text in self._condition.fields
        ]
        return [*values, *(None for _ in self._condition.tests)]

    def _values(self, told: Mapping[SearchName, float | bytes]) -> dict[str, float | str]:
        """Present values of all that the condition names, without what is not told."""
        values: dict[str, float | str] = {}
        numbers = {name: value for name, value in told.items() if isinstance(value, int | float)}
        for text, value in zip(self._condition.fields, self._operands(numbers), strict=False):
            if value is not None and not math.isnan(value):
                values[text] = value
        for test in self._condition.tests:
            if (said := told.get(self._names.events[test.name])) is not None:
                values[test.name] = _text(said).decode("utf-8", "backslashreplace")
        return values


def _text(value: float | bytes) -> bytes:
    return value if isinstance(value, bytes) else str(value).encode()


def _tester(test: TextTest, names: SearchNames) -> Callable[[bytes], bool | None]:
    """Make a function of each text that a test is of, in their order; None: it cannot be said yet."""
    if names.events[test.name].leaf not in (SENT, RECEIVED):
        return lambda text: test.data in text if test.sign == "has" else test.data == text
    held = b""

    def passes(piece: bytes) -> bool:
        """Find bytes in a stream, of which this is the next piece."""
        nonlocal held
        text = held + piece
        held = text[max(len(text) - len(test.data) + 1, 0) :]
        return test.data in text

    def is_line(piece: bytes) -> bool | None:
        """Compare the lines that a piece ends."""
        nonlocal held
        *lines, held = _LINE_ENDS.split(held + piece)
        held = held[:_LONGEST_LINE]
        told = [line for line in lines if line]
        return test.data in told if told else None

    return passes if test.sign == "has" else is_line
