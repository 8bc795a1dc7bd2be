"""Events that nobody asks for: clients come and go, runs go on, faults end, health changes.

Somebody looks for them once a second, in slices: a large bench's boards do not wait for it.
"""

import asyncio
import logging
from collections.abc import Iterator, Mapping
from contextlib import suppress

from hil.live.fault_registry import FaultRegistry
from hil.live.places import Places
from hil.live.runs.queue import RunQueue
from hil.operations.event_log import EventLog
from hil.operations.health import Health
from hil.operations.leases import Leases
from hil.operations.motor_events import MotorEvents
from hil.runs import Progress
from hil.sim.bench import BenchRuntime
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.monitoring import LATE_KINDS, HealthProblem

LOOK_S = 1.0
"""Time between two looks."""
_SLICE = 16
"""Ports between two turns of others."""
HERE = "bench"
"""Asker of what nobody asked for."""

log = logging.getLogger("hil")


class SeenEvents:
    """Looks at a bench from ``begin`` to ``end``, and notes in its events what has changed."""

    def __init__(
        self,
        events: EventLog,
        sim: BenchRuntime,
        places: Places,
        faults: FaultRegistry,
        queue: RunQueue,
        bridges: Mapping[str, Bridge],
        health: Health,
        leases: Leases,
    ) -> None:
        self._events, self._sim, self._places = events, sim, places
        self._faults, self._bridges, self._health, self._leases = faults, bridges, health, leases
        self._clients: Mapping[str, int] = {}
        self._active: Mapping[int, tuple[str, str]] = {}
        self._problems: Mapping[tuple[str, str], HealthProblem] = {}
        self._motors = MotorEvents(events, sim)
        self._states: dict[str, str] = {}
        """States of runs that have not ended."""
        self._task: asyncio.Task[None] | None = None
        queue.listeners.append(self.run_changed)

    def begin(self) -> None:
        """Look from now on."""
        self._task = asyncio.get_running_loop().create_task(self._look_on())

    async def end(self) -> None:
        """Look no more."""
        if self._task:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task

    def run_changed(self, progress: Progress) -> None:
        """Note a run that has begun, or ended."""
        before = self._states.pop(progress.run, "")
        if not progress.is_over:
            self._states[progress.run] = progress.state
        if progress.state == before:
            return
        why = f": {progress.why}" if progress.why else ""
        words = f"{progress.run} {progress.state}{why}"
        at_ns = progress.ended_at_ns if progress.is_over else progress.started_at_ns
        self._events.put("runs", ", ".join(progress.axes), HERE, words, at_ns=at_ns)

    async def _look_on(self) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            try:
                for _ in self.look():
                    await asyncio.sleep(0)
            except Exception:  # hil's own error: this look is lost, all else goes on
                log.exception("events: a look at the bench failed")

    def look(self) -> Iterator[None]:
        """Look once; yields where others may have their turn."""
        self._leases.look()
        yield from self._look_at_clients()
        self._look_at_faults()
        yield None
        yield from self._motors.look()
        yield from self._look_at_health()

    def _look_at_clients(self) -> Iterator[None]:
        now = dict[str, int]()
        for number, (label, link) in enumerate(list(self._places.items())):
            now[label] = link.port.stats().clients
            if number % _SLICE == _SLICE - 1:
                yield None
        for door, bridge in self._bridges.items():
            now[f"door {door}"] = int(bridge.status().get("links", 0))
        before, self._clients = self._clients, now
        for label, count in now.items():
            if (was := before.get(label, 0)) == count:
                continue
            by = abs(count - was)
            who = "a client" if by == 1 else f"{by} clients"
            left = f"; {count} there now" if count else ""
            self._events.put("clients", label, label, f"{who} {'came' if count > was else 'left'}{left}")

    def _look_at_faults(self) -> None:
        now = {row["number"]: (row["target"], row["kind"]) for row in self._faults.listed()}
        for number in self._active.keys() - now.keys() - self._events.cleared:
            target, kind = self._active[number]
            self._events.put("faults", target, HERE, f"{number} ended: {kind} on {target}")
        self._events.cleared &= now.keys()
        self._active = now

    def _look_at_health(self) -> Iterator[None]:
        found = list[HealthProblem]()
        for problem in self._health.pieces():
            if problem:
                found.append(problem)
            else:
                yield None
        now = {(problem.kind, problem.about): problem for problem in found}
        before, self._problems = self._problems, now
        for key in now.keys() - before.keys():
            problem = now[key]
            self._note(problem, f"{problem.what}; {problem.remedy}")
        for key in before.keys() - now.keys():
            self._note(before[key], f"over: {before[key].what}")

    def _note(self, problem: HealthProblem, text: str) -> None:
        kind = "lateness" if problem.kind in LATE_KINDS else "trouble"
        self._events.put(kind, problem.about, HERE, text)
