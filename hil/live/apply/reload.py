"""Reload: the bench becomes what the configuration says now; what did not change goes on."""

import asyncio
import logging
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hil.compose.build import places_of
from hil.config import ConfigError
from hil.host.service import Service
from hil.live.apply.bench_plan import BenchPlan, plan_reload, problems_of
from hil.live.apply.fail_first import Apply
from hil.live.configured import Configured
from hil.live.refusals import Refused
from hil.live.reservations import Reservations
from hil.live.store import NvmStore
from hil.sim.bench import BenchRuntime

log = logging.getLogger("hil")


@dataclass
class Reloader:
    """Reloads a bench, one reload at a time. ``path``: its configuration, if it has a file; files that it
    names are looked up from ``folder``."""

    path: Path | None
    folder: Path
    bench: BenchRuntime
    configured: Configured
    files: NvmStore
    reservations: Reservations
    apply: Apply
    _lock: asyncio.Lock = field(default_factory=asyncio.Lock, init=False)
    _service: Service | None = field(default=None, init=False)
    """Service that is told of reloads; None: the bench does not serve, and cannot be reloaded."""
    _waiting: asyncio.Task[None] | None = field(default=None, init=False)

    def open(self, wanted: asyncio.Event, service: Service) -> None:
        """Serve reloads. ``wanted`` is set for a reload without an answer (SIGHUP), maybe already."""
        self._service = service
        self._waiting = asyncio.get_running_loop().create_task(self._wait(wanted))

    async def _wait(self, wanted: asyncio.Event) -> None:
        while True:
            await wanted.wait()
            wanted.clear()
            with suppress(Exception):  # the log has it
                await self.reload()

    async def close(self) -> None:
        """Serve no more reloads, as the daemon ends: one that has begun is finished."""
        self._service = None
        async with self._lock:
            if self._waiting:
                self._waiting.cancel()

    async def reload(self) -> dict[str, Any]:
        """Reload; answers the names of devices that were kept, restarted, added and removed.

        Raises:
            ConfigError: the file has problems; nothing has changed.
            Refused: it cannot be done; nothing has changed.
        """
        async with self._lock:
            if (service := self._service) is None:
                raise Refused("the daemon is starting or ending")
            trouble = ""
            service.reloading()
            try:
                return await self._reload()
            except (ConfigError, Refused) as error:
                trouble = problems_of(error)
                log.error("reload refused, nothing has changed:\n%s", error)
                raise
            except Exception:  # hil's own error: the asker may not be there to see it
                log.exception("the reload failed")
                raise
            finally:
                service.reloaded(trouble)

    async def _reload(self) -> dict[str, Any]:
        if self.path is None:
            raise Refused("this bench has no configuration file")
        configured = self.configured
        plan = await asyncio.to_thread(
            plan_reload, self.path, self.folder, configured.catalogue, configured.config, self.files
        )
        for problem in plan.config.written.old_keys:
            log.warning("%s", problem)
        if plan.named("add", "remove", "restart"):
            self._check(plan)
            await self.apply.carry_out(plan)
        else:
            configured.config = plan.config  # labels alone may differ
        words = {"keep": "kept", "restart": "restarted", "add": "added", "remove": "removed"}
        done = {word: plan.named(action) for action, word in words.items()}
        names = [
            f"{word} {', '.join(done[word])}" for word in ("removed", "restarted", "added") if done[word]
        ]
        log.info("reloaded: %s", "; ".join([*names, f"{len(done['kept'])} went on"]))
        return done

    def _check(self, plan: BenchPlan) -> None:
        """Check what only the running bench knows."""
        problems = self.reservations.problems(plan.named("remove", "restart"))
        begun, catalogue = plan.tables, self.configured.catalogue
        needed = sum(places_of(plan.config.devices[name], catalogue) for name in begun)
        taken = sum(max(len(device.axes), 1) for device in self.bench.devices.values())
        if needed > (free := self.bench.core.native.max_axes - taken):
            what = "boards" if needed == len(begun) else "axes"
            problems.append(
                f"{needed} {what} begin, and the core has room for {free} beside those that run: change fewer"
                " at a time, or restart the daemon"
            )
        if problems:
            raise Refused("\n".join(problems))
