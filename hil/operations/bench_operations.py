"""Operations on a bench as a whole: faults, runs, and the daemon itself."""

import os
import re
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from hil.config import ConfigError
from hil.live.apply.reload import Reloader
from hil.live.fault_registry import FaultRegistry
from hil.live.refusals import ConfigUnreadable, Refused
from hil.live.runs.queue import RunQueue, no_run
from hil.operations.table import Asked
from hil.runs import Progress
from hil.vocab.address import NAME_PATTERN
from hil.vocab.verbs import VerbRefused


@dataclass(frozen=True)
class BenchOperations:
    """Operations on a bench as a whole. ``end``: ends the daemon soon."""

    registry: FaultRegistry
    queue: RunQueue
    reloader: Reloader
    end: Callable[[], None]

    def clear(self, asked: Asked, number: float | str, on: str) -> dict[str, list[int]]:
        """End faults; answers their numbers. ``m1`` stands for its ports too, and not for ``m10``."""
        there = [
            row["number"]
            for row in self.registry.listed()
            if not on or f"{row['target']}.".startswith(f"{on}.")
        ]
        chosen = there if number == "all" else [each for each in there if each == number]
        if number != "all" and not chosen:
            listed = ", ".join(map(str, there)) or "none"
            raise VerbRefused(
                "bad_parameter", f"there is no fault {number}{on and f' on {on}'}; there are {listed}"
            )
        for each in chosen:
            self.registry.clear(each)
        return {"cleared": chosen}

    def run(
        self, asked: Asked, text: str, file: str, check: bool, points: float, name: str, fresh: bool
    ) -> Any:
        """Submit or check a run: its progress at once, or a coroutine of it where that takes time; for a
        check the number of its steps, and ``points`` of its plan at most."""
        if name and not re.fullmatch(NAME_PATTERN, name):
            raise VerbRefused("bad_parameter", f"no name of a run: {name!r}; it is as in `{NAME_PATTERN}`")
        if check:
            return _planned(lambda: self.queue.check(asked.source, text, file, int(points)))
        try:
            submitted = self.queue.submit(asked.source, text, file, name=name, fresh=fresh)
            return submitted.as_dict() if isinstance(submitted, Progress) else _planned(lambda: submitted)
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None

    def runs(self, asked: Asked) -> list[dict[str, Any]]:
        """Progress of one run, or of all."""
        name, known = asked.target, self.queue.progress
        if name and name not in known:
            raise no_run(name, known)
        return [
            progress.as_dict() | self.queue.left(progress)
            for progress in known.values()
            if name in ("", progress.run)
        ]

    async def reload(self, asked: Asked) -> dict[str, Any]:
        """Reload; answers the names of devices that were kept, restarted, added and removed."""
        try:
            return await self.reloader.reload()
        except (ConfigError, ConfigUnreadable) as error:
            raise VerbRefused("bad_config", str(error)) from None
        except Refused as error:
            raise VerbRefused("not_now", str(error)) from None

    def stop(self, asked: Asked) -> dict[str, int]:
        """End the daemon soon; answers its process."""
        self.end()
        return {"pid": os.getpid()}


async def _planned(planning: Callable[[], Awaitable[Any]]) -> dict[str, Any]:
    """Answer for a plan, which is not begun where this is not."""
    try:
        answer = await planning()
    except ConfigError as error:
        raise VerbRefused("bad_run", str(error)) from None
    return answer.as_dict() if isinstance(answer, Progress) else dict(answer)
