"""Answers about one time, or one window, of a recorded run: state, samples, bytes at ports, packets."""

import json
from array import array
from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import isfinite
from sys import byteorder
from typing import Any

from hil.lookback.seen_run import NotWanted, SeenRun
from hil.net.condition import parse_condition
from hil.recorded.recorded_fields import NoSuchField, parse_fields
from hil.recorded.sampled import sampled
from hil.recorded.search import search
from hil.vocab.near_words import meant
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.wire.packet_words import PacketWords

FULL_NS = 150_000
"""Interval of samples at full rate: no control step of any board is shorter."""
MOST_ROWS = 400_000
"""Maximum number of samples that are looked at for one answer: a minute of an axis at full rate."""
LONGEST_NS = 900 * NS_PER_S
MOST_POINTS = 20_000
MOST_PACKETS = 500
FOUND_NS = 600 * NS_PER_S
"""Length of what is searched for one answer."""
FIND_NS = NS_PER_MS
"""Interval at which fields are compared."""

Row = tuple[float, ...]


class Unanswerable(Exception):
    """Error of a request that has no answer: ``str(error)`` says why and what to ask."""


def answer(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> bytes:
    """Answer a request, which has ``what``, ``from_ns``, ``to_ns``, as JSON. The run goes there.

    Raises:
        Unanswerable: there is no such thing.
        NotWanted: nobody waits for it any more.
        InputLogError: the run cannot be followed so far.
    """
    told = _ANSWERS[asked["what"]](seen, asked, is_wanted)
    at_ns = int(seen.run.now_ns)
    return json.dumps({"at_ns": at_ns} | told, separators=(",", ":")).encode()


def _state(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> dict[str, Any]:
    """All fields of all axes, the devices that have stopped, and the faults, at a time."""
    seen.run_until(asked["to_ns"], is_wanted)
    runtime = seen.run.runtime
    axes = {address: _told(runtime.snapshot(address).as_dict()) for address in runtime.parts.axes}
    failed = {name: device.failed for name, device in runtime.devices.items() if device.failed}
    return {"axes": axes, "failed": failed, "faults": seen.faults()}


def _told(fields: Mapping[str, float]) -> dict[str, float | None]:
    return {name: value if isfinite(value) else None for name, value in fields.items()}


def _bytes(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> dict[str, Any]:
    """Last bytes at a port before a time."""
    name = asked["of"]
    if name not in seen.ports:
        raise Unanswerable(f"there was no port {name!r}; {meant(name, seen.ports)}")
    seen.run_until(asked["to_ns"], is_wanted)
    pieces = [piece for piece in seen.ports[name].pieces if piece.at_ns <= asked["to_ns"]]
    items = [{"at_s": at_ns / 1e9, "to": to, "hex": data.hex()} for at_ns, to, data in pieces]
    return {"items": items}


def _packets(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> dict[str, Any]:
    """Last packets or frames of a wire before a time, in words as the wire view has them."""
    name = asked["of"]
    if name not in seen.wires:
        raise Unanswerable(f"there was no wire {name!r}; {meant(name, seen.wires)}")
    seen.run_until(asked["to_ns"], is_wanted)
    wire, events = seen.run.runtime.wires[name], seen.wires[name]
    items: list[Any] = []
    if wire.frames:
        words = wire.frames.words()
        items = [words(event) for event in events]
    else:
        told = PacketWords(seen.run.runtime.segments[name])
        for event in events:
            assert isinstance(event, SegmentEvent)
            items += told.say(event)
        now_ns = seen.run.now_ns
        items += [*told.silence(now_ns), *told.unfinished(now_ns)]
    return {"items": items[-MOST_PACKETS:], "left_out": max(len(items) - MOST_PACKETS, 0)}


def _samples(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> dict[str, Any]:
    """Samples of fields over a window: each, or the smallest and the largest of each interval."""
    try:
        fields = parse_fields(seen.run.runtime, asked["fields"])
    except NoSuchField as error:
        raise Unanswerable(str(error)) from None
    if not fields:
        raise Unanswerable("fields: name those that are wanted, as m1.position_deg")
    from_ns, to_ns = SimTimeNs(asked["from_ns"]), SimTimeNs(asked["to_ns"])
    if to_ns - from_ns > LONGEST_NS:
        raise Unanswerable(
            f"a window of {(to_ns - from_ns) / 1e9:g} s; {LONGEST_NS // NS_PER_S} s are the most"
        )
    axes = dict.fromkeys(field.axis for field in fields)
    interval_ns = _interval_ns(to_ns - from_ns, len(axes))
    rows_of_all = (to_ns - from_ns) // interval_ns + 1
    folds = {axis: _Fold(rows_of_all, asked["points"]) for axis in axes}
    names: dict[str, Sequence[str]] = {}
    seen.run_until(SimTimeNs(max(from_ns - 1, 0)), is_wanted)
    for chunk in sampled(seen.run, fields, from_ns, to_ns, interval_ns):
        names[chunk.axis] = chunk.fields
        folds[chunk.axis].add(chunk.rows)
        if not is_wanted():
            raise NotWanted
    series = [
        {"axis": axis, "fields": names[axis], "is_summed": fold.size > 1, "rows": fold.end(),
         "data": fold.encoded()}
        for axis, fold in folds.items()
        if axis in names
    ]  # fmt: skip
    return {"from_ns": from_ns, "interval_ns": interval_ns, "series": series}


def _find(seen: SeenRun, asked: Mapping[str, Any], is_wanted: Callable[[], bool]) -> dict[str, Any]:
    """First time after one at which a condition begins to hold, or last one before it; of ten minutes."""
    at_ns, is_back, known_ns = asked["to_ns"], asked["back"], asked["known_ns"]
    from_ns = max(at_ns - FOUND_NS, 0) if is_back else at_ns
    to_ns = max(at_ns - 1, 0) if is_back else min(at_ns + FOUND_NS, known_ns)
    found_ns = None
    try:
        condition = parse_condition(asked["condition"])
        for each in search(seen.run, condition, SimTimeNs(from_ns), SimTimeNs(to_ns), FIND_NS):
            if not is_wanted():
                raise NotWanted
            if is_back or each.begins_ns > at_ns:
                found_ns = each.begins_ns
                if not is_back:
                    break
    except ValueError as error:
        raise Unanswerable(str(error)) from None
    return {"found_ns": found_ns, "looked_from_ns": from_ns, "looked_to_ns": to_ns, "end_ns": known_ns}


def _interval_ns(window_ns: int, axes: int) -> int:
    """Shortest interval at which the samples of a window are not too many."""
    least_ns = window_ns * axes / MOST_ROWS
    return FULL_NS if least_ns <= FULL_NS else -int(-least_ns // NS_PER_MS) * NS_PER_MS


class _Fold:
    """Rows of an axis, or two for each interval of rows, of the smallest and the largest value of each
    column in the order in which they came."""

    def __init__(self, rows: int, points: int) -> None:
        self.size = 1 if rows <= points else -(-2 * rows // points)
        self._pending: list[Row] = []
        self._out = array("d")
        self._rows = 0

    def add(self, rows: Sequence[Row]) -> None:
        self._pending += rows
        whole = len(self._pending) - len(self._pending) % self.size
        for at in range(0, whole, self.size):
            self._put(self._pending[at : at + self.size])
        del self._pending[:whole]

    def _put(self, rows: Sequence[Row]) -> None:
        if self.size == 1:
            self._out.append(rows[0][0] / 1e9)
            self._out.extend(rows[0][1:])
            self._rows += 1
            return
        firsts, seconds = [rows[0][0] / 1e9], [rows[len(rows) // 2][0] / 1e9]
        for column in _columns(rows):
            low, high = min(column), max(column)
            is_low_first = low == high or column.index(low) < column.index(high)
            firsts.append(low if is_low_first else high)
            seconds.append(high if is_low_first else low)
        self._out.extend(firsts)
        self._out.extend(seconds)
        self._rows += 2

    def end(self) -> int:
        """Fold what is left; answers the number of rows."""
        if self._pending:
            self._put(self._pending)
            self._pending = []
        return self._rows

    def encoded(self) -> str:
        """Rows as numbers of 64 bits, little-endian, in base64."""
        if byteorder == "big":
            self._out.byteswap()
        return b64encode(self._out.tobytes()).decode()


def _columns(rows: Sequence[Row]) -> Iterator[tuple[float, ...]]:
    columns = zip(*rows, strict=True)
    next(columns)
    return columns


_ANSWERS = {"state": _state, "bytes": _bytes, "packets": _packets, "samples": _samples, "find": _find}
WHATS = frozenset(_ANSWERS)
"""Kinds of requests."""
