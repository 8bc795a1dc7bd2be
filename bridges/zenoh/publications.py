"""Publications of the bridge, made while somebody listens."""

import asyncio
import json
import logging
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cache, partial
from math import isfinite
from struct import Struct
from typing import Any

import zenoh

from bridges.zenoh.documents import OURS, dumped
from bridges.zenoh.keys import BYTES, JSON_VERSION, KEYS, PACKED, SCHEMAS, prefix
from bridges.zenoh.options import Options
from hil.vocab.address import owner_of
from hil.vocab.desk_protocol import AxisField, Desk, DeviceInfo, Watch, Watched
from hil.vocab.packed_fields import struct_of
from hil.vocab.segment import SegmentEvent
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import VerbRefused

IDLE_LOOK_S = 0.5
"""Interval of looks whether somebody listens."""
SLOW_S = 1.0
"""Interval of clock, health and stats."""
TAKES_PER_S = 4000
"""Maximum rate of takes of samples from the core; with many axes each take brings several."""
SHORTEST_S = 0.005
_BINARY = {key.schema for key in KEYS if key.payload in (PACKED, BYTES)}

log = logging.getLogger("hil")


@cache
def encoding(schema: str) -> zenoh.Encoding:
    """Encoding of what is published or answered."""
    is_binary = schema in _BINARY
    kind = zenoh.Encoding.APPLICATION_OCTET_STREAM if is_binary else zenoh.Encoding.APPLICATION_JSON
    return kind.with_schema(schema)


def _interval_ns(rate_hz: float) -> Fraction:
    """Exact interval: at 30 Hz sample k is at k * 10^9 / 30 ns, rounded down."""
    return NS_PER_S / Fraction(str(rate_hz)).limit_denominator(10**6)


def is_heard(publisher: Any) -> bool:
    """True if somebody has subscribed to a publisher's key."""
    return bool(publisher.matching_status.matching)


def undeclare(entity: Any) -> None:
    """Undeclare an entity; zenoh's own types leave this out."""
    entity.undeclare()


def short_state(desk: Desk, devices: Mapping[str, DeviceInfo], device: str) -> dict[str, float | None]:
    """State of an axis as it is published, now; None for what is no number that JSON has. Empty for a device
    that a reload has taken away."""
    if device not in devices:
        return {}
    fields = devices[device].fields
    return {
        name: value for name, value in desk.ask(OURS, "state", device, {}).items() if fields[name].is_state
    }


class StateText:
    """Encoder of states to JSON from the binary layout. By a format, for it runs thousands of times a second;
    ``json`` comes in where a value is no number that JSON has."""

    def __init__(self, fields: Sequence[AxisField]) -> None:
        ordered = sorted(fields, key=lambda field: field.offset)
        self._names = [field.name for field in ordered]
        self._unpack = struct_of((field.type, field.offset) for field in ordered).unpack_from
        self._format = (
            f'{{"v":{JSON_VERSION},"wall_ns":%d,' + ",".join(f'"{n}":%r' for n in self._names) + "}"
        )

    def of(self, packed: bytes, wall_ns: int) -> bytes:
        """Encode one sample."""
        values = self._unpack(packed)
        text = self._format % (wall_ns, *values)
        if not isfinite(sum(values)) and ("nan" in text or "inf" in text):  # the sum may be too large alone
            named = zip(self._names, values, strict=True)
            finite = {n: v if abs(v) < float("inf") else None for n, v in named}  # a NaN is not less either
            text = json.dumps({"v": JSON_VERSION, "wall_ns": wall_ns} | finite)
        return text.encode()


class _Told:
    """Publication that runs while somebody listens to one of the keys."""

    def __init__(self, publishers: Sequence[zenoh.Publisher], begin: Callable[[], Watch]) -> None:
        self._publishers = publishers
        self._begin = begin
        self._watch: Watch | None = None
        self._is_refused = False
        self.lost = 0
        """Number of samples that found no room in the core's ring, in watches that have ended."""

    def look(self) -> None:
        """Begin or end, as there are listeners."""
        is_wanted = any(is_heard(publisher) for publisher in self._publishers)
        if is_wanted and self._watch is None:
            self._try()
        elif not is_wanted:
            self._is_refused = False
            self._end()

    def _try(self) -> None:
        """Try again to begin: other watchers may have gone since."""
        try:
            self._watch = self._begin()
        except VerbRefused as refusal:
            if not self._is_refused:
                log.warning("zenoh: %s is not told: %s", self._publishers[0].key_expr, refusal)
            self._is_refused = True

    @property
    def is_on(self) -> bool:
        return self._watch is not None

    def flush(self) -> None:
        if self._watch is not None:
            self._watch.flush()

    def _end(self) -> None:
        if self._watch is not None:
            self.lost += self._watch.lost
            self._watch.close()
            self._watch = None

    def close(self) -> None:
        self._end()
        for publisher in self._publishers:
            undeclare(publisher)


class _Samples(_Told):
    """Samples of an axis. ``begin``: begins to watch with this call; ``content``: payload for a sample."""

    def __init__(
        self,
        publisher: zenoh.Publisher,
        begin: Callable[[Callable[[bytes], object]], Watch],
        content: Callable[[bytes], bytes] | None = None,
    ) -> None:
        self._came: list[bytes] = []
        self._put, self._content = publisher.put, content
        super().__init__([publisher], partial(begin, self._came.append))

    def flush(self) -> None:
        """Put what came. All texts are made first: zenoh's thread wakes for each put that comes alone."""
        super().flush()
        for content in [*map(self._content, self._came)] if self._content else self._came:
            self._put(content)
        self._came.clear()


def commands_told(desk: Desk, publisher: zenoh.Publisher) -> _Told:
    """Publication of the commands to a bench: their lines, as they are kept."""

    def tell(line: str, _: Mapping[str, Any]) -> None:
        publisher.put(line)

    return _Told([publisher], partial(desk.watch, OURS, Watched.COMMANDS, "", tell))


class Publications:
    """Publications of a bench."""

    def __init__(self, session: zenoh.Session, desk: Desk, options: Options) -> None:
        self._session = session
        self._desk = desk
        self._here = desk.describe()
        self._options = options
        self._prefix = prefix(self._here.bench)
        self.rejections = 0
        self._tasks: list[asyncio.Task[None]] = []
        self._states: dict[str, _Told] = {}
        self._packed: dict[str, _Told] = {}
        self._ports: dict[str, _Told] = {}
        self._single = [self._packets(name) for name in self._here.segments]
        self._lost_before = 0
        self._begin(list(self._here.devices))
        slow = {"sim/clock": self.clock, "sim/health": self.health, "lease": self.lease}
        self._slow = [(self._publisher(key), content) for key, content in slow.items()]
        for name in self._here.segments:
            self._slow.append((self._publisher("segment/<name>/stats", name), partial(self.stats, name)))
        self._about = self._publisher("about")
        self._about_told: Mapping[str, Any] | None = None
        """Content that was told last; None: nobody listens."""
        self._runs = desk.watch(OURS, Watched.RUNS, "", self._tell_run)
        self._rejected = self._publisher("sim/rejected")
        self._single.append(commands_told(desk, self._publisher("sim/commands")))

    def _begin(self, devices: Collection[str]) -> None:
        """Begin the publications of devices: their axes and ports; at the first time the taps' ports too."""
        there = self._here.devices
        for name in devices:
            if name in there and there[name].is_seen:
                self._states[name] = self._state(name)
                self._packed[name] = self._packed_state(name)
        ports = self._desk.describe().ports
        self._ports |= {name: self._bytes(name) for name in ports if name not in self._ports}

    def devices_changed(self, names: Collection[str]) -> None:
        """Begin again for devices that were added, removed or exchanged, with all their axes."""
        told = {*self._states, *self._here.devices}
        addresses = [address for address in told if owner_of(address) in names]
        for name in addresses:
            for stream in (self._states.pop(name, None), self._packed.pop(name, None)):
                if stream:
                    stream.close()
                    self._lost_before += stream.lost
        for port in [port for port in self._ports if owner_of(port) in names]:
            self._ports.pop(port).close()
        self._begin(addresses)
        self.tell_about()

    @property
    def _demand(self) -> list[_Told]:
        return [*self._states.values(), *self._packed.values(), *self._single, *self._ports.values()]

    @property
    def dropped(self) -> int:
        """Number of samples that found no room in the core's ring."""
        streams = (*self._states.values(), *self._packed.values())
        return self._lost_before + sum(stream.lost for stream in streams)

    def start(self) -> None:
        loop = asyncio.get_running_loop()
        states = self._pump(self._states, 1 / self._options.state_hz)
        packed = self._pump(self._packed, 1 / self._options.packed_hz)
        self._tasks += map(loop.create_task, (states, packed, self._look(), self._tell_slowly()))

    def _tell_run(self, progress: Mapping[str, Any]) -> None:
        key = f"{self._prefix}/run/{progress['run']}/state"
        text, kind = dumped(progress, self._here.clock), encoding("hil.run.v1")
        self._session.put(key, text, encoding=kind, allowed_destination=zenoh.Locality.REMOTE)

    async def stop(self) -> None:
        self._runs.close()
        for task in self._tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
        for each in self._demand:
            each.close()
        for publisher, _ in self._slow:
            undeclare(publisher)
        undeclare(self._about)
        undeclare(self._rejected)

    def rejected(self, text: bytes) -> None:
        """Publish that a command was refused."""
        self.rejections += 1
        self._rejected.put(text)

    # ---- contents ----

    def clock(self) -> bytes:
        return dumped({}, self._here.clock)

    def health(self) -> bytes:
        health = self._desk.ask(OURS, "health", "", {})
        return dumped({"rejected": self.rejections} | health, self._here.clock)

    def lease(self) -> bytes:
        return dumped(self._desk.ask(OURS, "lease", "", {}), self._here.clock)

    def about(self) -> bytes:
        return dumped(self._desk.ask(OURS, "about", "", {}), self._here.clock)

    def tell_about(self) -> None:
        """Tell what the bench is, if somebody listens, and it has changed since."""
        if not is_heard(self._about):
            self._about_told = None
            return
        now = self._desk.ask(OURS, "about", "", {})
        if now != self._about_told:
            self._about_told = now
            self._about.put(dumped(now, self._here.clock))

    def stats(self, segment: str) -> bytes:
        segments = self._desk.ask(OURS, "segments", "", {})
        return dumped(next(row for row in segments if row["segment"] == segment), self._here.clock)

    def state_now(self, device: str) -> bytes:
        return dumped(short_state(self._desk, self._here.devices, device), self._here.clock)

    # ---- who tells ----

    def _publisher(self, pattern: str, name: str = "") -> zenoh.Publisher:
        """Publisher of a key of the table, with this name in it."""
        return self._session.declare_publisher(
            f"{self._prefix}/{re.sub('<[a-z]+>', name, pattern)}",
            encoding=encoding(SCHEMAS[pattern]),
            congestion_control=zenoh.CongestionControl.DROP,
            allowed_destination=zenoh.Locality.REMOTE,
        )

    def _state(self, name: str) -> _Told:
        publisher = self._publisher("axis/<device>/state", name)
        fields = self._here.devices[name].fields.values()
        text, wall_ns = StateText([field for field in fields if field.is_state]), self._here.clock.wall_ns
        at_ns = Struct("<q").unpack_from
        begin = self._watching(name, self._options.state_hz)
        return _Samples(publisher, begin, lambda packed: text.of(packed, wall_ns(at_ns(packed)[0])))

    def _packed_state(self, name: str) -> _Told:
        publisher = self._publisher("axis/<device>/state/packed", name)
        return _Samples(publisher, self._watching(name, self._options.packed_hz))

    def _watching(self, name: str, rate_hz: float) -> Callable[[Callable[[bytes], object]], Watch]:
        """Function that begins to watch the samples of an axis."""
        return partial(self._desk.watch, OURS, Watched.SAMPLES, name, interval_ns=_interval_ns(rate_hz))

    def _packets(self, name: str) -> _Told:
        publisher = self._publisher("segment/<name>/packets", name)

        def tell(event: SegmentEvent) -> None:
            publisher.put(dumped(vars(event) | {"data": event.data.hex()}, self._here.clock))

        return _Told([publisher], partial(self._desk.watch, OURS, Watched.PACKETS, name, tell))

    def _bytes(self, name: str) -> _Told:
        publishers = {
            "board": self._publisher("port/<name>/rx", name),
            "client": self._publisher("port/<name>/tx", name),
        }

        def tell(towards: str, data: bytes) -> None:
            publishers[towards].put(data, attachment=dumped({}, self._here.clock))

        watch = partial(self._desk.watch, OURS, Watched.BYTES, name, tell)
        return _Told(list(publishers.values()), watch)

    # ---- when ----

    async def _look(self) -> None:
        while True:
            for each in self._demand:
                each.look()
            await asyncio.sleep(IDLE_LOOK_S)

    async def _pump(self, streams: Mapping[str, _Told], interval_s: float) -> None:
        while True:
            on = [stream for stream in streams.values() if stream.is_on]
            for stream in on:
                stream.flush()
            await asyncio.sleep(max(interval_s, SHORTEST_S, len(on) / TAKES_PER_S) if on else IDLE_LOOK_S)

    async def _tell_slowly(self) -> None:
        while True:
            for publisher, content in self._slow:
                if is_heard(publisher):
                    publisher.put(content())
            self.tell_about()
            await asyncio.sleep(SLOW_S)
