"""Applies a plan to the bench: at the start all of it, at a reload what has changed.

First everything that can fail is done beside what runs (``Stage``, memories, files). If something fails, the
plan is refused: all of it is taken away again, and nothing has changed. Then the new takes the old's place in
one step (``Swap``); finally, removed parts are closed.
"""

import asyncio
import logging
from dataclasses import dataclass

from hil.live.apply.bench_plan import BenchPlan
from hil.live.apply.staging import Stage, Staged
from hil.live.apply.swap import Swap
from hil.live.bridges import Bridges
from hil.live.devices.bench_devices import Devices
from hil.live.refusals import Refused
from hil.live.reservations import Reservations
from hil.live.store import NvmStore, StoreError
from hil.sim.bench import BenchRuntime

log = logging.getLogger("hil")

COMMIT_S = 5.0
"""Maximum time that a reload waits for boards that are writing their memories."""
_COMMIT_LOOK_S = 0.01


@dataclass(frozen=True)
class Apply:
    """Applies plans to a bench."""

    bench: BenchRuntime
    stage: Stage
    devices: Devices
    files: NvmStore
    reservations: Reservations
    bridges: Bridges
    swap: Swap

    async def carry_out(self, plan: BenchPlan) -> None:
        """Apply a plan. Raises Refused: it cannot be had; at a reload nothing has changed then."""
        staged = Staged()
        try:
            await self.stage.prepare(plan, staged)
            await self._until_stored(plan)
            if problems := self.reservations.problems(plan.named("remove", "restart")):
                raise Refused("\n".join(problems))
            asides = self._keep_aside(plan)
        except BaseException:
            await self.stage.put_away(staged)
            raise
        gone, leaving = self.swap.carry_out(plan, staged, asides)
        closed = await asyncio.gather(
            *(port.close() for port in gone),
            *(device.close() for device in leaving),
            return_exceptions=True,
        )
        begun = [self.devices[name] for name in plan.begun()]
        opened = await asyncio.gather(*(device.begin() for device in begun), return_exceptions=True)
        for error in filter(None, [*closed, *opened]):  # hil's own error: the other ports go on
            log.error("a port that was exchanged", exc_info=error)
        await self.bridges.exchanged(plan.named("remove", "restart", "add"))

    async def _until_stored(self, plan: BenchPlan) -> None:
        """Wait for boards that are writing their memories: each has to know what became of it."""
        devices, loop = self.bench.devices, asyncio.get_running_loop()
        twins = [devices[name] for name in plan.named("remove", "restart") if name in devices]
        until_s = loop.time() + COMMIT_S
        while writing := [device.name for device in twins if device.is_committing]:
            if loop.time() > until_s:
                raise Refused(f"{', '.join(writing)}: the memory is still being written; try again")
            await asyncio.sleep(_COMMIT_LOOK_S)

    def _keep_aside(self, plan: BenchPlan) -> dict[str, str]:
        """Put away the files that are other boards'; all of them, or none. Answers notes by device.

        Not in a thread: between the old board's last commit and its end nothing else may come.

        Raises:
            Refused: one cannot be put away.
        """
        kept = {}
        try:
            for name, memory in plan.memories.items():
                if memory.unfit and (aside := self.files.keep_aside(name, memory.unfit)):
                    kept[name] = aside
        except StoreError as error:
            for aside in kept.values():
                self.files.put_back(aside)
            raise Refused(str(error)) from error
        return {name: aside.note for name, aside in kept.items()}
