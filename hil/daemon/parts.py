"""This bench's part of a run that another bench leads.

The one that leads asks by ``run/<id>/part``, and is answered at once: ``clock`` (what time is it), ``look``
(how are the axes), ``join`` (plan it, and hold the axes for it), ``go`` (when a phrase begins), ``beat`` (how
are you), ``stop``. Both make the same plan from the same document and axes, and compare its digest. A
part whose leader says nothing for ``LOST_S`` stops as the run's ``on_fault`` says.
"""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from hil import __version__
from hil.config import ConfigError
from hil.daemon.joined import device_names
from hil.runs import AxisNow, Execution, Named, RunDocument, parse_run, plan_run
from hil.vocab.bridges import Source
from hil.vocab.verbs import Role, VerbRefused

if TYPE_CHECKING:
    from hil.daemon.daemon import Daemon
    from hil.daemon.runs import Runs

LOST_S = 1.0
"""Who says nothing for so long is gone: ten beats."""
_SAME_DEG = 1e-9


class Given:
    """A ``hil.runs.Baton`` that is told."""

    def __init__(self) -> None:
        self.starts_ns: dict[int, int] = {}

    def start_ns(self, phrase: int) -> int | None:
        return self.starts_ns.get(phrase)


@dataclass
class _Part:
    token: str
    leader: str
    execution: Execution
    baton: Given
    heard_s: float


@dataclass
class Parts:
    """Of one daemon."""

    daemon: "Daemon"
    runs: "Runs"
    _parts: dict[str, _Part] = field(default_factory=dict)

    def answer(self, source: Source, name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """What the bench that leads run ``name`` asks.

        Raises:
            VerbRefused: no.
        """
        if source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "a run needs the role operator")
        try:
            match given:
                case {"do": "clock"}:
                    return {"speed": self.daemon.config.speed, "version": __version__}
                case {"do": "look"}:
                    return self._look()
                case {"do": "join", "leader": str(leader), "token": str(token), "document": str(text)}:
                    return self._join(source, name, leader, token, text, given["axes"], given["digest"])
                case {"do": "go", "token": str(token), "phrase": int(phrase), "start_wall_ns": int(start_ns)}:
                    return self._go(self._part(name, token), phrase, start_ns)
                case {"do": "beat", "token": str(token)}:
                    return self._report(self._part(name, token))
                case {"do": "stop", "token": str(token), "how": "grace" | "prejudice" as how}:
                    part = self._part(name, token)
                    part.execution.stop(how, str(given["why"]), str(given["state"]))
                    return self._report(part)
        except (KeyError, TypeError, AttributeError) as error:
            raise VerbRefused("bad_request", f"no part of a run: {error!r}") from None
        raise VerbRefused("bad_request", "no part of a run: see run/<id>/part in the reference")

    def _look(self) -> dict[str, Any]:
        taken = self.runs.taken()
        axes = self.runs.axes.axes()
        for device, run in taken.items():
            if device in axes:
                axes[device] = replace(axes[device], why_not=f"it is in the run {run}")
        return {
            "axes": {name: asdict(axis) for name, axis in axes.items()},
            "speed": self.daemon.config.speed,
        }

    def _join(
        self, source: Source, name: str, leader: str, token: str, text: str, axes: Any, digest: Any
    ) -> dict[str, Any]:
        if name in self.runs.progress:
            raise VerbRefused(
                "not_now", f"there is a run {name!r} on this bench already; give it another name"
            )
        here = self.daemon.config.bench
        try:
            run, document = parse_run(text, "<run>")
            names = device_names(run, leader, here)
            known = {axis: AxisNow(**now) for axis, now in axes.items()} | self._mine(names, axes)
            plan = plan_run(run, document, known)
        except ConfigError as error:
            raise VerbRefused("bad_run", str(error)) from None
        if plan.digest() != digest:
            raise VerbRefused("cannot", f"it plans this run otherwise; hil is {__version__} here")
        baton = Given()
        execution = Execution(plan, Named(self.runs.axes, names), baton, set(names))
        part = _Part(token, leader, execution, baton, asyncio.get_running_loop().time())
        self._parts = {each: p for each, p in self._parts.items() if each in self.runs.progress} | {
            name: part
        }
        self.runs.hold(source, text, document, names, execution, self._watch(part, run))
        return {"phrases": len(plan.phrases)}

    def _mine(self, names: Mapping[str, str], told: Mapping[str, Mapping[str, Any]]) -> dict[str, AxisNow]:
        """This bench's axes as they are now, which is as they were told."""
        taken, axes = self.runs.taken(), self.runs.axes.axes()
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
        start_ns = self.daemon.host.sim_ns(start_wall_ns)
        late_ns = self.daemon.bench.now_ns - start_ns
        if late_ns >= 0 and phrase < len(part.execution.plan.phrases):
            raise VerbRefused("not_now", f"the start was {late_ns / 1e6:.1f} ms ago when it was told")
        part.baton.starts_ns[phrase] = start_ns
        return self._report(part)

    @staticmethod
    def _report(part: _Part) -> dict[str, Any]:
        execution = part.execution
        return {
            "reached": execution.reached,
            "ending": {"state": ended.state, "why": str(ended)} if (ended := execution.ended) else None,
            "progress": execution.progress.as_dict(),
        }

    def _watch(self, part: _Part, run: RunDocument) -> Callable[[], None]:
        def look() -> None:
            silent_s = asyncio.get_running_loop().time() - part.heard_s
            if silent_s > LOST_S and part.execution.ended is None:
                why = f"the bench {part.leader}, which leads, is gone: it said nothing for {silent_s:.1f} s"
                part.execution.stop(run.on_fault, why, "failed")

        return look
