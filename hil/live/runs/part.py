"""Part of this bench in a run that another bench leads.

The one that leads asks by ``run/<id>/part``, and is answered at once: ``clock`` (what time is it), ``look``
(how are the axes), ``join`` (plan it, and hold the axes for it), ``go`` (when a phrase begins), ``beat`` (how
are you), ``stop``. Each may be asked again, and is done once: a question can be lost. Both make the same plan
from the same document and axes, and compare the digest of this bench's part. A part whose leader says nothing
for the run's ``silence_s`` stops as its ``on_fault`` says.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from hil import __version__
from hil.config import ConfigError
from hil.config.document import Document
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.off_loop import off_loop
from hil.live.reservations import Reservations
from hil.live.runs.axis_names import device_names
from hil.live.runs.other_benches import axis_heard, axis_told, refuse_protocol, stood_still
from hil.live.runs.queue import RunQueue
from hil.runs import Execution, Plan, RunDocument, Told, parse_run, plan_run, run_from_data
from hil.vocab.axis import Axes, AxisNow
from hil.vocab.bridge_protocol import PROTOCOL_VERSION
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import VerbRefused
from hil.wire.json_text import JsonError, read_json

FAR_NS = 10_000_000_000
"""Maximum time between now and a start."""
_SAME_DEG = 1e-9
RELEASED = 64
"""Number of tokens that are remembered of runs that did not begin: what asks to join them comes late."""


@dataclass
class _Part:
    token: str
    leader: str
    execution: Execution
    baton: Told
    heard_s: float
    looked_s: float


class Parts:
    """Parts of this bench in runs of others. Answers benches that lead; ``queue`` carries the parts out."""

    def __init__(
        self, queue: RunQueue, axes: Axes, configured: Configured, wall: WallClock, reservations: Reservations
    ) -> None:
        self._queue = queue
        self._reservations = reservations
        self._axes = axes
        self._configured = configured
        self._wall = wall
        self._parts: dict[str, _Part] = {}
        self._joining: dict[str, asyncio.Task[dict[str, Any]]] = {}
        """Joins that are under way, by their tokens."""
        self._released: deque[str] = deque(maxlen=RELEASED)

    async def answer(self, source: Source, name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """Answer the bench that leads run ``name``. Raises VerbRefused."""
        refuse_protocol(given.get("do"), "the bench that leads the run", given, self._configured.config.bench)
        return {**await self._answer(source, name, given), "protocol": PROTOCOL_VERSION}

    async def _answer(self, source: Source, name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        try:
            match given:
                case {"do": "clock"}:
                    return {"speed": self._configured.config.speed, "version": __version__}
                case {"do": "look"}:
                    return self._look()
                case {"do": "join", "leader": str(leader), "token": str(token), "document": str(text)}:
                    joining = (source, name, leader, token, text, given["axes"], given["digest"])
                    return await self._join_once(token, name, joining)
                case {"do": "go", "token": str(token), "phrase": int(phrase), "start_wall_ns": int(start_ns)}:
                    return self._go(self._part(name, token), phrase, start_ns)
                case {"do": "beat", "token": str(token)}:
                    return self._report(self._part(name, token))
                case {
                    "do": "stop",
                    "token": str(token),
                    "how": "grace" | "prejudice" as how,
                    "state": "cancelled" | "failed" as state,
                    "why": str(why),
                }:
                    self._release(token)
                    part = self._part(name, token)
                    part.execution.stop(how, why, state)
                    return self._report(part)
        # What another bench sends may have any shape.
        except (KeyError, TypeError, AttributeError) as error:
            raise VerbRefused("bad_request", f"no part of a run: {error!r}") from None
        raise VerbRefused("bad_request", "no part of a run: see run/<id>/part in the reference")

    def _look(self) -> dict[str, Any]:
        taken = self._reservations.taken()
        axes = self._axes.axes()
        for device, run in taken.items():
            if device in axes:
                axes[device] = replace(
                    axes[device],
                    why_not=f"it is in the run {run}",
                    remedy="wait for its end, or cancel it",
                )
        return {
            "axes": {name: axis_told(axis) for name, axis in axes.items()},
            "speed": self._configured.config.speed,
        }

    async def _join_once(
        self, token: str, name: str, joining: tuple[Source, str, str, str, str, Any, Any]
    ) -> dict[str, Any]:
        """Join a run, or answer who asks again."""
        if (part := self._parts.get(name)) and part.token == token:
            return {"phrases": len(part.execution.plan.phrases)}
        if token in self._released:
            raise VerbRefused("no_run", f"the run {name!r} did not begin")
        if (task := self._joining.get(token)) is None:
            task = self._joining[token] = asyncio.get_running_loop().create_task(self._join(*joining))
            task.add_done_callback(lambda _: self._joining.pop(token))
        return await asyncio.shield(task)

    def _release(self, token: str) -> None:
        """Let go of what a leader asked for whose run ends: it may still be joining."""
        if not any(part.token == token for part in self._parts.values()):
            self._released.append(token)
        if joining := self._joining.get(token):
            joining.cancel()

    async def _join(
        self, source: Source, name: str, leader: str, token: str, text: str, told: Any, digest: Any
    ) -> dict[str, Any]:
        self._refuse_name(name)
        here = self._configured.config.bench
        try:
            run, document = await off_loop(text, _read, text)
            run = run.model_copy(update={"run": name})  # the leader may have given it another one
            names = device_names(run, leader, here)
            axes = {axis: axis_heard(now) for axis, now in told.items()} | self._mine(names, told)
            plan, own_digest = await off_loop(text, _planned, run, document, axes, names)
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None
        if own_digest != digest:
            raise VerbRefused("cannot", f"it plans this run otherwise; hil is {__version__} here")
        self._refuse_name(name)
        self._mine(names, told)  # the axes may have been taken meanwhile
        baton = Told()
        execution = Execution(plan, self._axes, baton, names)
        now_s = asyncio.get_running_loop().time()
        part = _Part(token, leader, execution, baton, now_s, now_s)
        # Those that the queue has forgotten go with this: nobody else ends them.
        self._parts = {each: p for each, p in self._parts.items() if each in self._queue.progress} | {
            name: part
        }
        self._queue.hold(source, text, names, execution, self._watch(part, run))
        return {"phrases": len(plan.phrases)}

    def _refuse_name(self, name: str) -> None:
        if self._queue.is_under_way(name):
            raise VerbRefused("not_now", f"this bench has a run {name!r} already; give it another name")

    def _mine(self, names: Mapping[str, str], told: Mapping[str, Mapping[str, Any]]) -> dict[str, AxisNow]:
        """Answer this bench's axes as they are now, if that is as they were told."""
        taken, axes = self._reservations.taken(), self._axes.axes()
        for axis, device in names.items():
            if device in taken:
                raise VerbRefused("not_now", f"{axis} is in the run {taken[device]}")
            if abs(axes[device].position_deg - told[axis]["position_deg"]) > _SAME_DEG:
                raise VerbRefused("not_now", f"{axis} has moved since it was looked at")
        return {
            axis: replace(axes[device], position_deg=told[axis]["position_deg"])
            for axis, device in names.items()
        }

    def _part(self, name: str, token: str) -> _Part:
        part = self._parts.get(name)
        if part is None or part.token != token:
            raise VerbRefused("no_run", f"this bench has no part in the run {name!r}")
        part.heard_s = asyncio.get_running_loop().time()
        return part

    def _go(self, part: _Part, phrase: int, start_wall_ns: int) -> dict[str, Any]:
        execution = part.execution
        if execution.ended or execution.progress.is_over:
            return self._report(part)  # the report tells the leader why
        start_ns = self._wall.sim_ns(start_wall_ns)
        if part.baton.starts_ns.get(phrase) == start_ns:
            return self._report(part)  # asked again
        if phrase != execution.reached or phrase in part.baton.starts_ns:
            raise VerbRefused("not_now", f"phrase {phrase} does not begin now")
        late_ns = self._wall.times_ns()[1] - start_wall_ns
        if not -FAR_NS < late_ns < 0:
            raise VerbRefused("not_now", f"the start was {late_ns / 1e6:.1f} ms ago when it was told")
        part.baton.starts_ns[phrase] = start_ns
        return self._report(part)

    def _report(self, part: _Part) -> dict[str, Any]:
        execution = part.execution
        began_ns = execution.progress.began_at_ns
        return {
            "began_wall_ns": None if began_ns is None else self._wall.wall_ns(began_ns),
            "reached": execution.reached,
            "ending": {"state": ended.state, "why": str(ended)} if (ended := execution.ended) else None,
            "progress": execution.progress.as_dict(),
        }

    def _watch(self, part: _Part, run: RunDocument) -> Callable[[], None]:
        def look() -> None:
            now_s = asyncio.get_running_loop().time()
            if now_s - part.looked_s > run.silence_s:  # what came since is old, and the leader has given up
                part.execution.stop(run.on_fault, stood_still(now_s - part.looked_s), "failed")
            part.looked_s = now_s
            silent_s = now_s - part.heard_s
            if silent_s > run.silence_s and part.execution.ended is None:
                why = f"the bench {part.leader}, which leads, is gone: it said nothing for {silent_s:.1f} s"
                part.execution.stop(run.on_fault, why, "failed")

        return look


def _read(text: str) -> tuple[RunDocument, Document]:
    """Read what a leader told: JSON as a rule, which is read in a tenth of the time. Raises ConfigError."""
    try:
        data = read_json(text)
    except JsonError:
        return parse_run(text, "<run>")
    return run_from_data(data) if isinstance(data, dict) else parse_run(text, "<run>")


def _planned(
    run: RunDocument, document: Document, axes: Mapping[str, AxisNow], names: Mapping[str, str]
) -> tuple[Plan, str]:
    plan = plan_run(run, document, axes, names)
    return plan, plan.digest(names)
