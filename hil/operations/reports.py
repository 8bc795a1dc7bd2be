"""Reports on a bench: its devices, segments and bridges, and their state."""

import asyncio
import os
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from hil import __version__
from hil.config import DeviceConfig
from hil.config.port_kinds import port_kinds
from hil.core.core import octaves
from hil.host.real_time import Grant
from hil.live.configured import Configured
from hil.live.devices.bench_devices import Devices
from hil.live.fault_registry import FaultRegistry
from hil.live.places import Places
from hil.live.run_recording import RunRecording
from hil.live.runs.queue import RunQueue
from hil.operations.health import Health
from hil.operations.table import Asked
from hil.operations.wire_reports import echoes, listed_nodes, listed_wires
from hil.sim.bench import BenchRuntime
from hil.vocab.address import Address, owner_of
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import DeviceInfo, Encoded
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import VerbRefused, described
from hil.vocab.wire import Report
from hil.wire.json_text import json_pieces

PIECE_S = 0.002
"""Time after which others have their turn."""
PART_BYTES = 1 << 16


class SharedReport:
    """Report as JSON. ``made``: answers an iterator that yields None where others may have their turn, and
    the report at last. Each asker gets one that was begun after the question; one is made at a time."""

    def __init__(self, made: Callable[[], Iterator[Any]]) -> None:
        self._made = made
        self._turn = asyncio.Lock()
        self._next: asyncio.Task[Encoded] | None = None

    async def read(self) -> Encoded:
        """Make the report, or wait for the next one, which others wait for already."""
        if self._next is None:
            self._next = asyncio.get_running_loop().create_task(self._make())
        return await asyncio.shield(self._next)

    async def _make(self) -> Encoded:
        async with self._turn:
            self._next = None  # who asks from now on gets another one
            loop = asyncio.get_running_loop()
            parts, part, began_s = list[bytes](), bytearray(), loop.time()
            for piece in self._pieces():
                part += piece
                if len(part) > PART_BYTES:
                    parts.append(bytes(part))
                    part.clear()
                if loop.time() - began_s > PIECE_S:
                    await asyncio.sleep(0)
                    began_s = loop.time()
            return Encoded((*parts, bytes(part)))

    def _pieces(self) -> Iterator[bytes]:
        content: Any = None
        for content in self._made():
            if content is None:
                yield b""
        yield from json_pieces(content)


Piece = TypeVar("Piece")


def _gathered(pieces: Iterator[Piece | None]) -> Generator[None, None, list[Piece]]:
    """Pieces of which a report is made. Others may have their turn where one is None."""
    found = []
    for piece in pieces:
        if piece is None:
            yield None
        else:
            found.append(piece)
    return found


NAMED = 5
"""Maximum number of failed devices named in a line."""


@dataclass(frozen=True)
class Reports:
    """Reports on one bench. ``drawing``: answers the digest of its last drawing; ``lease``: who has it."""

    sim: BenchRuntime
    configured: Configured
    places: Places
    devices: Devices
    faults: FaultRegistry
    bridges: Mapping[str, Bridge]
    grant: Grant
    health: Health
    runs: RunQueue
    recording: RunRecording
    drawing: Callable[[], str | None] = lambda: None
    lease: Callable[[], dict[str, Any]] = lambda: {"lease": None}

    def listed(self) -> Iterator[dict[str, Any]]:
        """List the bench's devices, taps and CANopen nodes, and the addresses of their ports."""
        yield self._list(is_status=False)

    def _list(self, *, is_status: bool) -> dict[str, Any]:
        """List that has its rows of devices made one by one, when it is encoded: a thousand at a time would
        be some 30,000 objects for the garbage collection, which stops the loop for 12 ms."""
        config = self.configured.config
        kinds = port_kinds(config)
        taps = [
            {"tap": name, "kind": kinds[name]}
            | {"port": tap.port.address, "clients": tap.port.stats().clients}
            for name, tap in self.places.items()
            if owner_of(name) in self.sim.wires
        ]
        return {
            "bench": config.bench,
            "pid": os.getpid(),
            "version": __version__,
            "devices": self._rows(list(config.devices.items()), kinds, is_status=is_status),
            "taps": taps,
            "nodes": listed_nodes(self.sim),
        }

    def _rows(
        self, configs: Iterable[tuple[str, DeviceConfig]], kinds: Mapping[str, str], *, is_status: bool
    ) -> Iterator[dict[str, Any]]:
        for name, config in configs:
            if device := self.devices.get(name):  # a reload may have removed it meanwhile
                row = self._row(name, config, kinds)
                yield row | device.status() if is_status else row

    def _row(self, name: str, config: DeviceConfig, kinds: Mapping[str, str]) -> dict[str, Any]:
        return {
            "device": name,
            "profile": config.profile,
            "hardware": config.hardware,
            "port": config.port.kind if config.port else None,
            "greeting": self._greeting(name, config.profile),
            "ready_in_ns": self._ready_in_ns(name, config.profile),
            "address": None,
            "clients": 0,
            "network": None,
            "ports": {},
            "axes": [],
            "failed": None,
        } | self.devices[name].listed(kinds)

    def _greeting(self, name: str, profile: str) -> str:
        """Text that a board answers at once; what a program of a user's own answers is not known."""
        twin = self.sim.devices.get(name)
        is_known = twin is None or not twin.has_program
        return self.configured.catalogue.profiles[profile].greeting if is_known else ""

    def _ready_in_ns(self, name: str, profile: str) -> int:
        """Simulated time until a board that has just got its power answers; 0: it does, or is not known."""
        twin = self.sim.devices.get(name)
        if twin is None or twin.has_program or twin.failed:
            return 0
        ready_after_s = self.configured.catalogue.profiles[profile].ready_after_s
        return max(twin.started_ns + round(ready_after_s * NS_PER_S) - self.sim.now_ns, 0)

    def status(self) -> Iterator[dict[str, Any] | None]:
        """List the same with counters, health and all else that is known: None where others may have their
        turn, then the report."""
        listed = self._list(is_status=True)
        yield None
        problems = yield from _gathered(self.health.pieces())
        adapters = yield from _gathered(echoes(self.devices, self.sim, self.places, self.bridges))
        rt, config = self.sim.core.native.rt_stats(), self.configured.config
        yield listed | {
            "health": self.health.as_dict(problems),
            "bridges": {name: dict(bridge.status()) for name, bridge in self.bridges.items()},
            "echoes": dict(adapters),
            **self._wires(),
            "switches": self._switches(),
            "faults": self.faults.listed(),
            **self.lease(),
            "runs": self.runs.under_way(),
            "drawing": self.drawing(),
            "recording": self.recording.report(),
            "rt": self.grant.state,
            "rt_line": self.grant.line(),
            "rate_hz": config.rate_hz,
            "speed": config.speed,
            "sim_ns": self.sim.now_ns,
            "is_paused": self.sim.real_time.is_held,
            "period_ns": 1_000_000_000 // config.rate_hz,
            "elapsed_ns": rt["elapsed_ns"],
            "ticks": rt["ticks"],
            "missed": rt["missed"],
            "overruns": rt["overruns"],
            "wake_latency": octaves(rt["wake_latency"]),
            "lag": list(self.sim.real_time.lag),
        }

    def _switches(self) -> list[dict[str, Any]]:
        return [
            {
                "switch": str(Address(owner_of(switch.axis), name)),
                "axis": switch.axis,
                "to": switch.to,
                "is_active": self.sim.parts.switches[name].is_active,
            }
            for name, switch in self.configured.config.switches.items()
        ]

    def _wires(self) -> dict[str, list[Report]]:
        kinds = self.configured.catalogue.wire_infos
        return {told.key: listed_wires(self.sim, self.places, kind) for kind, told in kinds.items()}

    def health_in_short(self) -> dict[str, Any]:
        rt, devices = self.sim.core.native.rt_stats(), self.sim.devices.values()
        return {
            "rt": self.grant.state,
            "ticks": rt["ticks"],
            "missed": rt["missed"],
            "overruns": rt["overruns"],
            "failed": {device.name: device.failed for device in devices if device.failed},
            "starved": {device.name: n for device in devices if (n := device.setpoints.starved)},
        } | self.health.as_dict(self.health.problems())

    def verbs(self, asked: Asked) -> list[dict[str, Any]]:
        return described(self._info(asked).verbs)

    def _info(self, asked: Asked) -> DeviceInfo:
        device, part = self.devices.at(asked.target)
        return device.info(part)

    def registers(self, asked: Asked) -> Mapping[str, Any]:
        maps, info = self.configured.catalogue.maps, self._info(asked)
        if maps is None:
            raise VerbRefused("cannot", "no bus here shows registers")
        return maps.registers(info)


def status_line(sim: BenchRuntime, configured: Configured, places: Places, grant: Grant) -> str:
    """Format the bench in a line for systemd: devices, failures, clients, real time, missed ticks."""
    failed = [name for name, device in sim.devices.items() if device.failed]
    failed += [label for label, link in places.items() if owner_of(label) in sim.devices and link.failure]
    clients = sum(link.port.stats().clients for link in places.values())
    missing = f" (no {' and no '.join(grant.missing)})" if grant.missing else ""
    return "; ".join(
        [
            f"bench {configured.config.bench}",
            _counted(len(configured.config.devices), "device")
            + (f", {len(failed)} failed ({_names(failed)})" if failed else ""),
            _counted(clients, "client"),
            f"real time {grant.state}{missing}",
            _counted(sim.core.native.rt_stats()["missed"], "missed tick"),
        ]
    )


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _names(names: list[str]) -> str:
    return ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
