"""Readings under keys, and the answers to queries of one key or of many."""

import asyncio
from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import zenoh

from bridges.zenoh.documents import OURS, dumped
from bridges.zenoh.inbox import SLICE
from bridges.zenoh.keys import SCHEMAS, prefix
from bridges.zenoh.publications import Publications, encoding
from bridges.zenoh.sender import Sender
from hil.vocab.desk_protocol import Desk
from hil.vocab.verbs import VerbRefused

WIDE = 100
"""Maximum number of queries of more keys than a slice that wait for each other."""
WIDE_ANSWERS = 200
"""Maximum number of answers not gone out before the next one waits: others come in between."""
_LAYOUT = ("name", "type", "offset", "unit", "meaning")


class Readings:
    """Readings of one bench. ``work`` carries out what takes its time."""

    def __init__(
        self,
        desk: Desk,
        publications: Publications,
        sender: Sender,
        work: Callable[[Coroutine[Any, Any, None]], None],
    ) -> None:
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
        readers: dict[str, tuple[str, Callable[[], bytes]]] = {
            "sim/clock": (SCHEMAS["sim/clock"], told.clock),
            "sim/health": (SCHEMAS["sim/health"], told.health),
            "layout": (SCHEMAS["layout"], self._layout),
        }
        for name in here.segments:
            readers[f"segment/{name}/stats"] = (SCHEMAS["segment/<name>/stats"], partial(told.stats, name))
        for name, device in here.devices.items():
            readers[f"verbs/{name}"] = (SCHEMAS["verbs/<device>"], partial(self._verbs, name))
            if not device.is_seen:
                continue
            packed = partial(desk.ask, OURS, "packed", name, {})
            readers[f"axis/{name}/state/packed"] = (SCHEMAS["axis/<device>/state/packed"], packed)
            readers[f"axis/{name}/state"] = (SCHEMAS["axis/<device>/state"], partial(told.state_now, name))
            for field in device.fields.values():
                if field.is_settable:
                    key = f"axis/{name}/param/{field.name}"
                    readers[key] = ("hil.param.v1", partial(self._parameter, name, field.name))
        self._readers = {f"{self._prefix}/{key}": reader for key, reader in readers.items()}
        """Readers of schema and content, by key."""

    def read(self, key: str, query: zenoh.Query) -> None:
        """Answer a query; one of too many keys waits for its turn. Raises VerbRefused: too many such queries
        wait."""
        found = list(self._matching(key))
        if len(found) > SLICE:
            if self._wide_waiting >= WIDE:
                raise VerbRefused(
                    "not_now", f"{WIDE} queries of many keys wait already; ask for less at a time"
                )
            self._wide_waiting += 1
            self._work(self._read_many(found, query))
            return
        for name in found:
            self._read_one(name, query)
        self._sender.end(query)

    async def _read_many(self, found: Sequence[str], query: zenoh.Query) -> None:
        """Answer such queries one after the other, no faster than they are read."""
        try:
            async with self._wide:
                for number, name in enumerate(found):
                    self._read_one(name, query)
                    while number % SLICE == 0 and self._sender.waiting > WIDE_ANSWERS:
                        await asyncio.sleep(0.005)
                    if number % SLICE == 0:
                        await asyncio.sleep(0)
        finally:
            self._wide_waiting -= 1
            self._sender.end(query)

    def _read_one(self, name: str, query: zenoh.Query) -> None:
        if name in self._readers:
            schema, content = self._readers[name]
            self._sender.reply(query, name, content(), encoding(schema))
        elif progress := self._runs(name.split("/")[3]):
            text = dumped(progress[0], self._here.clock)
            self._sender.reply(query, name, text, encoding("hil.run.v1"))

    def _matching(self, key: str) -> Iterable[str]:
        if "*" not in key:
            match key.removeprefix(self._prefix + "/").split("/"):
                case ["run", name, "state"] if self._runs(name):
                    return [key]
            return [key] if key in self._readers else []
        wanted = zenoh.KeyExpr(key)
        runs: list[str] = []
        if wanted.intersects(zenoh.KeyExpr(f"{self._prefix}/run/*/state")):
            runs = [f"{self._prefix}/run/{progress['run']}/state" for progress in self._runs("")]
        return [each for each in (*runs, *self._readers) if wanted.intersects(zenoh.KeyExpr(each))]

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
