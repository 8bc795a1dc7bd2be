"""Leads a run that spans benches: who takes part, when each phrase begins, who is gone.

All benches are asked at once. Each phrase begins when all have ended the one before and are heard, at a wall
time that all are told beforehand, each by its own clock. Clocks are compared with every question
(``hil.runs.clock_offset``).
"""

import asyncio
import json
import logging
import secrets
from collections.abc import Coroutine, Mapping
from typing import Any

from hil.config.document import Document, Finding
from hil.live.configured import Configured
from hil.live.core_thread import WallClock
from hil.live.off_loop import off_loop
from hil.live.runs.axis_names import device_names, other_benches
from hil.live.runs.other_benches import (
    ANSWER_S,
    LOOKS,
    Member,
    OtherBenches,
    axis_heard,
    axis_told,
    stood_still,
)
from hil.runs import AxisReport, BenchReport, Execution, Plan, Progress, RunDocument, Told
from hil.runs.run_document import DOCUMENT_BYTES
from hil.vocab.axis import AxisNow, How
from hil.vocab.bridge_protocol import BenchGone
from hil.vocab.desk_protocol import Source
from hil.vocab.seen_over import seen_over
from hil.vocab.verbs import VerbRefused

log = logging.getLogger("hil")

LEAD_WALL_NS = 500_000_000
"""Time from the message of a start to the start. A bench that has not answered after ``ANSWER_S`` ends the
run, and 0.2 s are left to stop those that have."""
LEAD_EACH_S = 0.005
"""Further time of both for each bench: the questions to fifty take a quarter of a second on two cores."""
BEAT_S = 0.1
BEATS_PER_S = 200.0
"""Maximum rate of the beats to all benches of a run."""
FRESH_S = 0.3
"""Time in which a bench was heard, beside that between beats, when a phrase is begun: a link that is away
then is waited for."""
CLOCK_ERROR_NS = 20_000_000
"""Maximum error of a clock with which a run starts: 40 ms there and back."""
JOIN_S, JOIN_EACH_S = 5.0, 0.2
"""Time for the other benches to join, and more for each: they plan a long run meanwhile, perhaps all on one
computer."""
MEMBERS_LOOK_S = 0.01


class Together:
    """Leader of one run.

    Long because each message to a bench depends on what all the others have said.
    """

    def __init__(
        self, configured: Configured, wall: WallClock, others: OtherBenches, source: Source, run: RunDocument
    ) -> None:
        self._config = configured.config
        self._wall = wall
        self._others = others
        self._source = source
        self._run = run
        self.name = run.run
        """Name of the run: the document may say another."""
        self._token = secrets.token_hex(8)
        here = self._config.bench
        self._members = [Member(b, device_names(run, here, b)) for b in other_benches(run, here)]
        self._tasks: list[asyncio.Task[None]] = []
        self._told_end: How | None = None
        self._beat_s = max(BEAT_S, len(self._members) / BEATS_PER_S)
        self._more_s = LEAD_EACH_S * len(self._members)
        self._looked_s = 0.0
        self._execution: Execution | None = None
        self._progress = Progress(self.name)
        self.baton = Told()

    # ---- before it moves ----

    async def look(self, document: Document) -> dict[str, AxisNow]:
        """Ask for the others' axes; answers them by their names in the run.

        Raises:
            ConfigError: a bench does not answer, or cannot take part.
        """
        looked = await asyncio.gather(*map(self._look, self._members), return_exceptions=True)
        axes: dict[str, AxisNow] = {}
        findings = []
        for member, found in zip(self._members, looked, strict=True):
            if isinstance(found, BenchGone | VerbRefused):
                findings.append(_refusal(member, found))
            elif isinstance(found, BaseException):
                raise found
            else:
                axes |= found
        if findings:
            raise document.error(findings)
        return axes

    async def _look(self, member: Member) -> dict[str, AxisNow]:
        for _ in range(LOOKS):
            await self._ask_again(member, {"do": "clock"}, ANSWER_S + self._more_s)
        answer = await self._ask_again(member, {"do": "look"}, ANSWER_S + self._more_s)
        here, there = self._config.speed, answer["speed"]
        if there != here:
            raise VerbRefused(
                "cannot", f"the time of bench {member.bench} goes {there:g} times the wall's, here {here:g}"
            )
        return {f"{member.bench}/{device}": axis_heard(told) for device, told in answer["axes"].items()}

    async def join(self, text: str, plan: Plan) -> None:
        """Hold the others' axes. Raises BenchGone, VerbRefused: one does not take part."""
        axes = {name: axis_told(plan.axes[name]) for name in plan.run.axes}
        given = {"do": "join", "leader": self._config.bench, "document": self._told(text), "axes": axes}
        digests = await off_loop(text, lambda: [plan.digest(member.names) for member in self._members])
        joins = (
            self._join(member, given | {"digest": digest})
            for member, digest in zip(self._members, digests, strict=True)
        )
        for outcome in await asyncio.gather(*joins, return_exceptions=True):
            if isinstance(outcome, BaseException):
                raise outcome

    def _told(self, text: str) -> str:
        """Document as the others get it: JSON is read in a tenth of the time that YAML takes."""
        told = json.dumps(self._run.model_dump(mode="json", exclude_unset=True))
        return told if len(told) <= max(len(text), DOCUMENT_BYTES // 2) else text

    async def _join(self, member: Member, given: Mapping[str, Any]) -> None:
        member.joined = True  # it may have joined, even if it does not say so
        await self._ask_again(member, given, JOIN_S + JOIN_EACH_S * len(self._members))
        if member.clock.error_ns > CLOCK_ERROR_NS:
            most_ms = CLOCK_ERROR_NS / 1e6
            error_ms = seen_over(member.clock.error_ns / 1e6, most_ms)
            why = f"the clock of {member.bench} is known to {error_ms} ms, {most_ms:g} are allowed"
            raise VerbRefused("cannot", f"{why}: the network is too slow")
        self._start(self._beats(member))

    # ---- while it moves ----

    def begin(self, execution: Execution, progress: Progress) -> None:
        """Begin the run. ``progress`` is that of the whole run; ``execution`` has this bench's part of it."""
        self._execution, self._progress = execution, progress
        self._looked_s = asyncio.get_running_loop().time()
        self._start(self._conduct())

    def each(self) -> None:
        """Lead at each look at this bench's part."""
        assert self._execution is not None
        own, whole = self._execution.progress, self._progress
        whole.state, whole.step, whole.started_at_ns = "running", own.step, own.started_at_ns
        whole.step_at_ns, whole.began_at_ns = own.step_at_ns, own.began_at_ns
        whole.why, whole.planned_end_ns = own.why, own.planned_end_ns
        whole.axes |= own.axes
        for member in self._members:
            _notice(member, self._execution, self._run.on_fault)
            whole.axes |= _axes_of(member, self._execution.plan)
            clock = member.clock
            whole.benches[member.bench] = BenchReport(
                member.state,
                member.gone or member.progress.get("why"),
                clock.offset_ns,
                clock.error_ns,
                self._apart_ns(member),
            )
        now_s = asyncio.get_running_loop().time()
        if now_s - self._looked_s > self._run.silence_s:
            self._execution.stop(self._run.on_fault, stood_still(now_s - self._looked_s), "failed")
        self._looked_s = now_s
        ended, how = self._execution.ended, self._execution.stopping
        if ended and how and how != self._told_end:
            self._told_end = how
            told = {"do": "stop", "how": how, "why": str(ended), "state": ended.state}
            for member in self._members:
                if not member.is_over:
                    self._start(self._stop(member, told))

    async def finish(self) -> None:
        """Wait until the others have ended too; then the whole run has."""
        self.each()
        while not all(member.is_over for member in self._members):
            await asyncio.sleep(MEMBERS_LOOK_S)
            self.each()
        assert self._execution is not None
        own, whole = self._execution.progress, self._progress
        whole.state, whole.why, whole.ended_at_ns = own.state, own.why, own.ended_at_ns
        if own.state == "done" and (undone := [m for m in self._members if m.state != "done"]):
            first = undone[0]
            whole.state, whole.why = "failed", first.gone or f"{first.bench}: {first.progress['why']}"

    async def release(self) -> None:
        """Free the others' axes, as the run does not begin."""
        self.leave()
        told = {"do": "stop", "how": "grace", "why": "the run did not begin", "state": "cancelled"}
        joined = [self._ask_again(member, told) for member in self._members if member.joined]
        await asyncio.gather(*joined, return_exceptions=True)

    def leave(self) -> None:
        """Send no more beats: a bench that still holds axes for this run lets go."""
        for task in self._tasks:
            task.cancel()

    async def _conduct(self) -> None:
        execution = self._execution
        assert execution is not None
        for phrase in range(len(execution.plan.phrases) + 1):
            while execution.reached < phrase or not all(self._is_at(phrase, m) for m in self._members):
                await asyncio.sleep(MEMBERS_LOOK_S)
            start_ns = self._wall.times_ns()[1] + LEAD_WALL_NS + round(self._more_s * 1e9)
            try:
                await asyncio.gather(*(self._go(member, phrase, start_ns) for member in self._members))
            except (BenchGone, VerbRefused) as error:
                execution.stop(self._run.on_fault, f"not all could be told when to begin: {error}", "failed")
                return
            late_ns = self._wall.times_ns()[1] - start_ns
            if late_ns >= 0:
                why = f"the start was {seen_over(late_ns / 1e6, 0)} ms ago when all had been told"
                execution.stop(self._run.on_fault, why, "failed")
                return
            self.baton.starts_ns[phrase] = self._wall.sim_ns(start_ns)

    def _is_at(self, phrase: int, member: Member) -> bool:
        """True if a bench has ended all before a phrase, and can be told now when that begins."""
        silent_s = asyncio.get_running_loop().time() - member.heard_s
        return member.report.get("reached", -1) >= phrase and silent_s < FRESH_S + 2 * self._beat_s

    def _apart_ns(self, member: Member) -> int | None:
        """Time between the beginnings of motion here and there."""
        here_ns, there_ns = self._progress.began_at_ns, member.report.get("began_wall_ns")
        if here_ns is None or there_ns is None:
            return None
        return int(there_ns) - member.clock.offset_ns - self._wall.wall_ns(here_ns)

    async def _go(self, member: Member, phrase: int, start_ns: int) -> None:
        told = {"do": "go", "phrase": phrase, "start_wall_ns": start_ns + member.clock.offset_ns}
        member.report = await self._ask_again(member, told, ANSWER_S + self._more_s)

    async def _stop(self, member: Member, told: Mapping[str, Any]) -> None:
        while not member.is_over and told["how"] == self._told_end:
            try:
                member.report = await self._ask(member, told)
                return
            except (BenchGone, VerbRefused):
                await asyncio.sleep(BEAT_S)

    async def _beats(self, member: Member) -> None:
        loop = asyncio.get_running_loop()
        member.heard_s = loop.time()
        while not member.is_over:
            try:
                member.report = await self._ask(member, {"do": "beat"})
                member.heard_s = loop.time()
            except (BenchGone, VerbRefused) as error:
                silent_s = loop.time() - member.heard_s
                is_refused = isinstance(error, VerbRefused) and error.code != "busy"
                if silent_s > self._run.silence_s or is_refused:
                    why = str(error) if is_refused else f"silent for {silent_s:.1f} s"
                    member.gone = f"the bench {member.bench} is gone: {why}"
                    log.warning("run %s: %s", self.name, member.gone)
            await asyncio.sleep(self._beat_s)

    async def _ask(
        self, member: Member, given: Mapping[str, Any], timeout_s: float = ANSWER_S
    ) -> Mapping[str, Any]:
        given = {**given, "token": self._token}
        return await self._others.ask(self._source, member, self.name, given, timeout_s)

    async def _ask_again(
        self, member: Member, given: Mapping[str, Any], timeout_s: float = ANSWER_S
    ) -> Mapping[str, Any]:
        given = {**given, "token": self._token}
        return await self._others.ask_again(self._source, member, self.name, given, timeout_s)

    def _start(self, doing: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(doing)
        self._tasks.append(task)
        task.add_done_callback(self._started_ended)

    def _started_ended(self, task: asyncio.Task[None]) -> None:
        if task.cancelled() or (error := task.exception()) is None:
            return
        log.error("run %s", self.name, exc_info=error)  # ours: without it the run would never end
        if self._execution:
            self._execution.stop(self._run.on_fault, "an error of hil; its log has more", "failed")


def _refusal(member: Member, why: BenchGone | VerbRefused) -> Finding:
    is_gone = isinstance(why, BenchGone)
    remedy = "see `hil list --joined` for those that are joined" if is_gone else "leave it out"
    return Finding(("axes", next(iter(member.names))), str(why), remedy, at_key=True)


def _notice(member: Member, execution: Execution, how: How) -> None:
    """End the run if another bench's part has ended before its end."""
    if execution.ended:
        return
    if member.gone:
        execution.stop(how, member.gone, "failed")
    elif ending := member.report.get("ending"):
        execution.stop(how, f"{member.bench}: {ending['why']}", ending["state"])


def _axes_of(member: Member, plan: Plan) -> dict[str, AxisReport]:
    told = member.progress.get("axes") or {}
    reports = {}
    for axis in member.names:
        report = AxisReport(**told[axis]) if axis in told else AxisReport(plan.ends_deg[axis])
        if member.gone:
            report.at_end = "unknown"
        reports[axis] = report
    return reports
