"""A reload: the bench becomes what the configuration says now, and what did not change goes on."""

import asyncio
import logging
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil.config import ConfigError
from hil.live.apply import Apply
from hil.live.bench_plan import Plan, plan_reload, problems_of
from hil.live.changes import Changes
from hil.live.configured import Configured
from hil.live.holds import Holds
from hil.live.refusals import Refused
from hil.live.store import NvmStore
from hil.sim.bench import BenchRuntime

log = logging.getLogger("hil")


class Reloader:
    """Of one bench, one reload at a time. ``path``: its configuration, if it has a file; files that it names
    are looked up from ``folder``."""

    def __init__(
        self,
        path: Path | None,
        folder: Path,
        bench: BenchRuntime,
        configured: Configured,
        files: NvmStore,
        holds: Holds,
        apply: Apply,
        changes: Changes,
    ) -> None:
        self._path, self._folder = path, folder
        self._bench = bench
        self._configured = configured
        self._files = files
        self._holds = holds
        self._apply = apply
        self._changes = changes
        self._lock = asyncio.Lock()
        self._is_open = False
        """The bench serves, and can be reloaded."""
        self._waiting: asyncio.Task[None] | None = None

    def open(self, wanted: asyncio.Event) -> None:
        """The bench serves. ``wanted`` is set, perhaps already, where nobody waits for an answer: SIGHUP."""
        self._is_open = True
        self._waiting = asyncio.get_running_loop().create_task(self._wait(wanted))

    async def _wait(self, wanted: asyncio.Event) -> None:
        while True:
            await wanted.wait()
            wanted.clear()
            with suppress(Exception):  # the log has it
                await self.reload()

    async def close(self) -> None:
        """The daemon ends: a reload that has begun is finished, none begins any more."""
        self._is_open = False
        async with self._lock:
            if self._waiting:
                self._waiting.cancel()

    async def reload(self) -> dict[str, Any]:
        """Names of devices that were kept, restarted, added and removed.

        Raises:
            ConfigError: the file has problems; nothing has changed.
            Refused: it cannot be done; nothing has changed.
        """
        async with self._lock:
            if not self._is_open:
                raise Refused("the daemon is starting or ending")
            trouble = ""
            self._changes.tell_begun()
            try:
                return await self._reload()
            except (ConfigError, Refused) as error:
                trouble = problems_of(error)
                log.error("reload refused, nothing has changed:\n%s", error)
                raise
            except Exception:  # ours: who asked may not be there to see it
                log.exception("the reload failed")
                raise
            finally:
                self._changes.tell_ended(trouble)

    async def _reload(self) -> dict[str, Any]:
        if self._path is None:
            raise Refused("this bench has no configuration file")
        configured = self._configured
        plan = await asyncio.to_thread(
            plan_reload, self._path, self._folder, configured.catalogue, configured.config, self._files
        )
        if plan.named("add", "remove", "restart"):
            self._check(plan)
            await self._apply.carry_out(plan)
        words = {"keep": "kept", "restart": "restarted", "add": "added", "remove": "removed"}
        done = {word: plan.named(action) for action, word in words.items()}
        names = [
            f"{word} {', '.join(done[word])}" for word in ("removed", "restarted", "added") if done[word]
        ]
        log.info("reloaded: %s", "; ".join([*names, f"{len(done['kept'])} went on"]))
        return done

    def _check(self, plan: Plan) -> None:
        """What only the running bench knows."""
        problems = self._holds.problems(plan.named("remove", "restart"))
        if self._bench.log:
            problems.append("the run is being logged (--log), and a log holds one bench from its start")
        needed = len(plan.begun(twins=True))
        if needed > (free := self._bench.core.native.max_axes - len(self._bench.devices)):
            problems.append(
                f"{needed} boards begin, and the core has room for {free} beside those that run: change fewer"
                " at a time, or restart the daemon"
            )
        if problems:
            raise Refused("\n".join(problems))
