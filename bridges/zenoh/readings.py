"""Readings under keys, and the answers to queries of one key or of many."""

import asyncio
from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from functools import partial
from time import thread_time
from typing import Any

import zenoh

from bridges.zenoh.documents import OURS, dumped
from bridges.zenoh.inbox import READING_SHARE, SLICE
from bridges.zenoh.keys import SCHEMAS, prefix
from bridges.zenoh.publications import Publications, encoding
from bridges.zenoh.sender import Sender
from hil.vocab.desk_protocol import Desk
from hil.vocab.verbs import VerbRefused

WIDE = 100
"""Maximum number of queries of more keys than a slice that wait for each other."""
AT_A_TIME = 8
"""Number of answers to such a query before others have their turn."""
WIDE_ANSWERS = 200
"""Maximum number of answers not gone out before the next one waits: others come in between."""
_RUNS = "run/<id>/state"
_LAYOUT = ("name", "type", "offset", "unit", "meaning")


Reader = Callable[[], bytes]


class Readings:
    """Readings of one bench. ``work`` carries out what takes time; ``cpu_s`` answers how much."""

    def __init__(
        self,
        desk: Desk,
        publications: Publications,
        sender: Sender,
        work: Callable[[Coroutine[Any, Any, None]], object],
        cpu_s: Callable[[], float] = thread_time,
    ) -> None:
        self._cpu_s = cpu_s
        self._desk = desk
        self._here = desk.describe()
        self._publications = publications
        self._sender = sender
        self._work = work
        self._prefix = prefix(self._here.bench)
        self._wide = asyncio.Lock()
        self._wide_waiting = 0
        self.refresh()

    def refresh(self) -> None:
        """Renew the readers, as the bench's devices are others."""
        desk, here, told = self._desk, self._here, self._publications
        plain: dict[str, Reader] = {
            "sim/clock": told.clock,
            "sim/health": told.health,
            "lease": told.lease,
            "layout": self._layout,
            "about": told.about,
        }
        readers = {pattern: {pattern: reader} for pattern, reader in plain.items()}
        of_segments: dict[str, Reader] = {
            f"segment/{name}/stats": partial(told.stats, name) for name in here.segments
        }
        of_devices: dict[str, Reader] = {f"verbs/{name}": partial(self._verbs, name) for name in here.devices}
        packed: dict[str, Reader] = {}
        states: dict[str, Reader] = {}
        parameters: dict[str, Reader] = {}
        for name, device in here.devices.items():
            if not device.is_seen:
                continue
            packed[f"axis/{name}/state/packed"] = partial(desk.ask, OURS, "packed", name, {})
            states[f"axis/{name}/state"] = partial(told.state_now, name)
            for field in device.fields.values():
                if field.is_settable:
                    read = partial(self._parameter, name, field.name)
                    parameters[f"axis/{name}/param/{field.name}"] = read
        readers |= {
            "segment/<name>/stats": of_segments,
            "verbs/<device>": of_devices,
            "axis/<device>/state": states,
            "axis/<device>/state/packed": packed,
            "axis/<device>/param/<name>": parameters,
        }
        self._readers = {
            pattern: {f"{self._prefix}/{key}": reader for key, reader in group.items()}
            for pattern, group in readers.items()
        }
        """Readers by row of the table of keys, and by key."""

    def read(self, pattern: str, key: str, query: zenoh.Query) -> None:
        """Answer a query that came under a row of the table; one of too many keys waits for its turn. Raises
        VerbRefused: too many such queries wait."""
        found = list(self._matching(pattern, key))
        if len(found) > SLICE:
            if self._wide_waiting >= WIDE:
                raise VerbRefused("busy", f"{WIDE} queries of many keys wait already; ask for less at a time")
            self._wide_waiting += 1
            self._work(self._read_many(pattern, found, query))
            return
        for name in found:
            self._read_one(pattern, name, query)
        self._sender.end(query)

    async def _read_many(self, pattern: str, found: Sequence[str], query: zenoh.Query) -> None:
        """Answer such queries one after the other, no faster than they are read, in a part of the time."""
        try:
            async with self._wide:
                for first in range(0, len(found), AT_A_TIME):
                    began_s = self._cpu_s()
                    for name in found[first : first + AT_A_TIME]:
                        self._read_one(pattern, name, query)
                    took_s = self._cpu_s() - began_s
                    await asyncio.sleep(took_s / READING_SHARE - took_s)
                    while self._sender.waiting > WIDE_ANSWERS:
                        await asyncio.sleep(0.005)
        finally:
            self._wide_waiting -= 1
            self._sender.end(query)

    def _read_one(self, pattern: str, name: str, query: zenoh.Query) -> None:
        if reader := self._readers.get(pattern, {}).get(name):
            self._sender.reply(query, name, reader(), encoding(SCHEMAS[pattern]))
        elif pattern == _RUNS and (progress := self._runs(name.split("/")[3])):
            text = dumped(progress[0], self._here.clock)
            self._sender.reply(query, name, text, encoding(SCHEMAS[_RUNS]))

    def _matching(self, pattern: str, key: str) -> Iterable[str]:
        if pattern == _RUNS:
            name = key.split("/")[3] if "*" not in key else ""
            names = [f"{self._prefix}/run/{progress['run']}/state" for progress in self._runs(name)]
        else:
            names = list(self._readers.get(pattern, ()))
        if "*" not in key:
            return [key] if key in names else []
        wanted = zenoh.KeyExpr(key)
        return [each for each in names if wanted.intersects(zenoh.KeyExpr(each))]

    def _runs(self, name: str) -> Sequence[Mapping[str, Any]]:
        """Progress of one run, none if there is none; of all with an empty name."""
        try:
            found: Sequence[Mapping[str, Any]] = self._desk.ask(OURS, "runs", name, {})
        except VerbRefused:
            return []
        return found

    def _verbs(self, name: str) -> bytes:
        verbs = self._desk.ask(OURS, "verbs", name, {})
        profile = self._here.devices[name].profile
        return dumped({"device": name, "profile": profile, "verbs": verbs}, self._here.clock)

    def _parameter(self, device: str, name: str) -> bytes:
        return dumped({name: self._desk.ask(OURS, "state", device, {})[name]}, self._here.clock)

    def _layout(self) -> bytes:
        fields: dict[str, dict[str, Any]] = {}
        for device in self._here.devices.values():
            for f in device.fields.values():
                fields[f.name] = {name: getattr(f, name) for name in _LAYOUT}
        ordered = sorted(fields.values(), key=lambda row: int(row["offset"]))
        return dumped({"fields": ordered}, self._here.clock)
