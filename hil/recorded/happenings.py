"""Moments of a recorded run that a search looks at: bytes, packets and frames, inputs."""

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from hil.compose.decoded_item import DecodedItem
from hil.compose.decoding import Decoder
from hil.recorded.recorded_run import RecordedRun
from hil.recorded.run_events import place_of_sender
from hil.recorded.search_names import FAULT, INPUT, RECEIVED, SENT, VERB, SearchName, wire_counters
from hil.sim.inputs import NAMES, Bytes, Do, Inject, Logged, Play
from hil.sim.twin import Twin
from hil.vocab.time import SimTimeNs
from hil.wire.pcapng import Record, RecordKind


class Happening(NamedTuple):
    """Moment of a run, over at ``at_ns``, begun at ``begun_ns``. ``values``: numbers and texts by name;
    ``counters``: those of its wire then."""

    at_ns: int
    begun_ns: int
    values: Mapping[SearchName, float | bytes]
    counters: Mapping[SearchName, float] = {}


class Happenings:
    """Listener to a run for what some names are of, from the run's present on."""

    def __init__(
        self, run: RecordedRun, events: Iterable[SearchName], counters: Iterable[SearchName]
    ) -> None:
        self._events, counted = {*events}, {*counters}
        self._heard: list[Happening] = []
        self._decoders: dict[str, Decoder] = {}
        if any(name.leaf == SENT for name in self._events):
            run.listeners.append(self._sent)
        has_inputs = any(name.leaf in (RECEIVED, FAULT, VERB, INPUT) for name in self._events)
        self._inputs = deque(sorted(run.log.inputs, key=lambda each: each.at_ns) if has_inputs else ())
        for owner in {name.owner for name in (*self._events, *counted)} & run.runtime.wires.keys():
            self._watch(run, owner, {name for name in counted if name.owner == owner})

    def until(self, at_ns: SimTimeNs, *, is_last: bool) -> list[Happening]:
        """Take what has happened up to a time, to which the run has gone, in the order of times. ``is_last``:
        True if nobody looks at what follows, which ends a packet where silence does."""
        for owner, decoder in self._decoders.items() if is_last else ():
            self._add_items(at_ns, owner, decoder.silence())
        while self._inputs and self._inputs[0].at_ns <= at_ns:
            self._input(self._inputs.popleft())
        self._heard.sort(key=lambda each: each.at_ns)
        # A paced line has a piece later than its board prints it.
        end = next((index for index, each in enumerate(self._heard) if each.at_ns > at_ns), len(self._heard))
        taken, self._heard = self._heard[:end], self._heard[end:]
        return taken

    def _add(self, at_ns: int, values: Mapping[SearchName, float | bytes]) -> None:
        wanted = {name: value for name, value in values.items() if name in self._events}
        if wanted:
            self._heard.append(Happening(at_ns, at_ns, wanted))

    def _sent(self, device: Twin, part: str, at_ns: SimTimeNs, data: bytes) -> None:
        self._add(at_ns, {SearchName(place_of_sender(device, part), SENT): data})

    def _input(self, logged: Logged) -> None:
        to, given = logged.device, logged.input
        values: dict[SearchName, float | bytes] = {}
        if isinstance(given, Bytes):
            values[SearchName(f"{to}.{given.port}" if given.port else to, RECEIVED)] = given.data
        elif isinstance(given, Play):
            data = b"".join(bytes.fromhex(digits) for _, digits in given.bursts)
            values[SearchName(to, RECEIVED)] = data
        elif isinstance(given, Inject):
            values[SearchName(to, FAULT)] = given.kind.encode()
        elif isinstance(given, Do):
            values[SearchName(to, VERB)] = given.verb.encode()
        self._add(logged.at_ns, values | {SearchName(to, INPUT): NAMES[type(given)].encode()})

    def _watch(self, run: RecordedRun, owner: str, counted: set[SearchName]) -> None:
        wire, group = run.runtime.wires[owner], run.runtime.parts.group_of(owner)
        has_items = any(name.owner == owner for name in self._events)
        line, frames = wire.interface(owner), wire.frames
        if has_items:
            self._decoders[owner] = Decoder()

        def heard(event: Any) -> None:
            now_ns = group.now_ns
            if counted:
                told = wire_counters(wire)
                counters = {name: told[name.leaf] for name in counted}
                self._heard.append(Happening(now_ns, event.at_ns, {}, counters))
            if not has_items:
                return
            if frames:
                record = Record(line, event.at_ns, 0, frames.packed(event), event.node, 0)
            else:
                kind = RecordKind.FRAMING_ERROR if event.is_damaged else RecordKind.RX
                record = Record(line, event.at_ns, kind, event.data, event.about, 0)
            self._add_items(now_ns, owner, self._decoders[owner].feed(record))

        wire.watchers.append(heard)

    def _add_items(self, now_ns: int, owner: str, items: Iterable[DecodedItem]) -> None:
        for item in items:
            told = {name: _told(item, name.leaf) for name in self._events if name.owner == owner}
            values = {name: value for name, value in told.items() if value is not None}
            self._heard.append(Happening(now_ns, item.at_ns, values))


def _told(item: DecodedItem, leaf: str) -> Any:
    match leaf:
        case "text":
            return item.say().encode()
        case "data":
            return item.data
        case "error":
            return item.error.encode() or None
        case "kind":
            return str(item.kind).encode()
        case "can_id":
            return item.can_id
        case _:
            party = item.origin if leaf == "from" else item.destination
            return party if party is None or isinstance(party, int) else str(party).encode()
