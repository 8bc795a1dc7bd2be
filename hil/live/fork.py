"""Bench that goes on from a recorded run: its configuration, and its way to the time at which it begins.

Its devices begin at time 0 with the memories that they had. The recorded inputs are given to them on the
virtual clock, and nobody outside hears of it. Then the core's thread takes them on from there. Answers to
commits come from the recording up to that time, and then from the files of the fork.
"""

import asyncio
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hil.compose import find_catalogue
from hil.compose.log_course import LogCourse, LoggedBench, LoggedStore, MemoryOptions
from hil.config import BenchConfig, Catalogue, from_dict
from hil.firmware.nvm import Content
from hil.live.apply.bench_plan import BenchPlan, plan_start
from hil.live.log_file import LogFile
from hil.live.memory_commits import Commits
from hil.live.places import Places
from hil.live.refusals import Refused
from hil.live.store import Loaded, NvmStore
from hil.net.endpoint import LOOPBACK, has_port
from hil.sim.bench import BenchRuntime
from hil.sim.firmware_guard import Guard, Guarded, LoggedStops
from hil.sim.input_log import InputLog
from hil.sim.inputs import InputLogError
from hil.sim.noted_events import NotedEvent, latest_events
from hil.vocab.address import address_of
from hil.vocab.firmware import NETWORK
from hil.vocab.time import NS_PER_S, SimTimeNs

USUAL_PORT = "pty"
NO_PORTS = ("memory", "serial")
"""Kinds of ports that a fork does not open: the first has no client, the second is a real adapter."""
OF_OTHERS = {"host", "users", "tls", "token", "insecure", "names", "connect"}
"""Options of doors that concern other computers: a fork's doors are for this one."""


def fork_config(log: InputLog, bench: str, *, with_page: bool = False) -> BenchConfig:
    """Make the configuration of a fork, which can run beside the bench that was recorded: the same twins with
    ports of the same kinds, at addresses of its own, and its doors, for this computer alone, at free ports.
    ``with_page``: with the page's door, if the bench had none.

    Raises:
        ConfigError: it does not fit this program.
    """
    was = from_dict(log.config, find_catalogue({"memory": MemoryOptions}))
    config = deepcopy(log.config) | {"bench": bench, "cpu": None, "faults": []}
    config["devices"] = {name: config["devices"][name] for name in was.twins}
    kinds = log.ports or {name: USUAL_PORT for name, device in was.twins.items() if device.port}
    for name, device in config["devices"].items():
        device |= {"port": None, "network": None, "ports": {}}
        device["flash"] = (device.get("flash") or {}) | {"table": "stored"}  # of its memory at time 0
        for part, kind in _of(kinds, name).items():
            if part in ("", NETWORK):
                device[{"": "port", NETWORK: "network"}[part]] = kind
            else:
                device["ports"][part] = kind
    for wires in (config.get(key) or {} for key in was.bus_keys):
        for name, wire in wires.items():
            own = _of(kinds, name)
            for tap, options in (wire.get("taps") or {}).items():
                options["port"] = own.get(tap, USUAL_PORT)
    doors = config.get("bridges") or {}
    config["bridges"] = {kind: _door(options) for kind, options in doors.items()}
    if with_page:
        config["bridges"].setdefault("web", {})
    return from_dict(config, find_catalogue(path=was.profile_path))


def _of(kinds: Mapping[str, str], owner: str) -> dict[str, str]:
    """Kinds of ports of a device or a wire by the names of their parts."""
    found = ((address_of(label), kind) for label, kind in kinds.items())
    own = {at.part: kind for at, kind in found if at.owner == owner}
    return {part: USUAL_PORT if kind in NO_PORTS else kind for part, kind in own.items()}


def _door(options: Mapping[str, Any]) -> dict[str, Any]:
    own = {name: value for name, value in options.items() if name not in OF_OTHERS}
    if isinstance(own.get("port"), int):
        own["port"] = 0
    match own.get("listen"):
        case str() as listen:
            own["listen"] = LOOPBACK + ":0" * has_port(listen)
        case list():
            own["listen"] = ["tcp/127.0.0.1:0"]
    return own


@dataclass
class Fork:
    """Fork of a recorded run. ``at_ns``: the time at which it goes on by itself; ``source``: the recording
    and the time, for people; ``absent``: real boards of the recorded bench, with where they were;
    ``stands``: its time stands at first. ``on_problem``: as ``LogCourse`` has it."""

    log: InputLog
    at_ns: SimTimeNs
    source: str
    absent: Mapping[str, str]
    stands: bool = False
    on_problem: Callable[[int, str], None] | None = None
    store: LoggedStore = field(init=False)
    _guard: "ForkGuard | None" = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.store = LoggedStore(is_lenient=self.on_problem is not None)
        self._stops = LoggedStops({})

    def plan(self, config: BenchConfig, catalogue: Catalogue, files: NvmStore) -> BenchPlan:
        """Plan the start of its devices, with the memories of the log.

        Raises:
            Refused: as ``plan_start``.
        """
        plan, stored = plan_start(config, Path(), catalogue, files), self.log.memories
        return replace(
            plan,
            memories={
                name: Loaded(Content(config.devices[name].profile, 0, dict(stored.get(name, {}))), None)
                for name in plan.memories
            },
        )

    def guard(self, then: Guard) -> Guard:
        """Guard of its firmwares: as the log says, and ``then`` from when it goes on by itself."""
        self._guard = ForkGuard(self._stops, then)
        return self._guard

    def events(self) -> list[NotedEvent]:
        """Events of the recorded run up to the fork's time."""
        return latest_events(event for event in self.log.events if event.at_ns <= self.at_ns)

    async def go_through(
        self,
        sim: BenchRuntime,
        config: BenchConfig,
        catalogue: Catalogue,
        places: Places,
        commits: Commits,
        file: LogFile | None,
    ) -> None:
        """Take the bench, at time 0, to the fork's time.

        Raises:
            Refused: it cannot take an input of the log.
        """
        epoch_ns = time.time_ns() - round(self.at_ns / config.speed)
        bench = LoggedBench(config, catalogue, self.store, self._stops, sim)
        course = LogCourse(self.log, self.on_problem, bench=bench)
        for begin_ns in range(0, self.at_ns + 1, NS_PER_S):
            try:
                course.run_until(SimTimeNs(min(begin_ns + NS_PER_S, self.at_ns)))
            except InputLogError as error:
                raise Refused(str(error)) from None
            for link in places.values():
                link.backend.lose(sim.now_ns)
            if file:
                file.write_past(epoch_ns)
            await asyncio.sleep(0)
        if self._guard:
            self._guard.is_past = True
        commits.replayed = None
        for device, waiting in self.store.waiting.items():
            for sections, answered in waiting:
                commits.commit(device, sections, answered)


class ForkGuard(Guard):
    """Guard of a fork's firmwares: that of the log, and then another."""

    def __init__(self, first: Guard, then: Guard) -> None:
        self._first, self._then = first, then
        self.is_past = False

    def __call__(self, device: Guarded) -> AbstractContextManager[object]:
        return self._then(device) if self.is_past else self._first(device)

    def aside(self) -> AbstractContextManager[object]:
        return self._then.aside() if self.is_past else self._first.aside()
