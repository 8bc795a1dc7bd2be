"""Runs that are asked for."""

from collections.abc import Awaitable, Coroutine, Mapping
from typing import Any

from hil.config import ConfigError
from hil.live.runs.other_benches import OtherBenches
from hil.live.runs.part import Parts
from hil.live.runs.queue import RunQueue
from hil.operations.desk import Answerer, Asked
from hil.runs import Progress
from hil.vocab.verbs import VerbRefused


class RunOperations:
    """Of one bench."""

    def __init__(self, runs: RunQueue, parts: Parts, others: OtherBenches) -> None:
        self._runs, self._parts, self._others = runs, parts, others

    def answers(self) -> Mapping[str, Answerer]:
        return {
            "run": self.submit,
            "runs": self.states,
            "cancel_run": self.cancel,
            "part": self.part,
            "benches": self.benches,
        }

    def submit(self, asked: Asked, text: str, file: str, check: bool, anew: bool) -> Any:
        """The run's progress at once, or a coroutine of it for what takes time; of a check how many steps it
        has."""
        if check:
            return _planned(self._runs.check(asked.source, text, file))
        try:
            submitted = self._runs.submit(asked.source, text, file, anew=anew)
            return submitted.result().as_dict() if submitted.done() else _planned(submitted)
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None

    def states(self, asked: Asked) -> list[dict[str, Any]]:
        """Of one run, or of all."""
        name, known = asked.target, self._runs.progress
        if name and name not in known:
            raise VerbRefused("no_run", f"there is no run {name!r}")
        return [progress.as_dict() for progress in known.values() if name in ("", progress.run)]

    def cancel(self, asked: Asked, how: Any) -> dict[str, Any]:
        """Its progress."""
        return self._runs.cancel(asked.source, asked.target, how).as_dict()

    def part(self, asked: Asked, given: Mapping[str, Any]) -> Coroutine[Any, Any, Mapping[str, Any]]:
        """What a bench that leads a run asks of this one."""
        return self._parts.answer(asked.source, asked.target, given)

    def benches(self, asked: Asked) -> Coroutine[Any, Any, list[dict[str, Any]]]:
        """The others that are joined."""
        return self._others.joined(asked.source)


async def _planned(planning: Awaitable[Any]) -> dict[str, Any]:
    try:
        answer = await planning
    except ConfigError as error:
        raise VerbRefused("bad_run", str(error)) from None
    return answer.as_dict() if isinstance(answer, Progress) else dict(answer)
