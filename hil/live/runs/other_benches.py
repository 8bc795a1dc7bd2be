"""Other benches of a run: questions to them, their answers, and the offsets of their clocks."""

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from hil.live.runs.asked_again import asked_again
from hil.runs import ClockOffset
from hil.vocab.axis import AxisNow
from hil.vocab.bridge_protocol import PROTOCOL_VERSION, BenchDoor, BenchGone, Bridge
from hil.vocab.desk_protocol import Source
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import VerbRefused

LOOKS = 8
"""Number of questions in a row that compare two clocks at the beginning."""
ANSWER_S = 0.3
LEAST_ANSWER_S = 0.01


_BEFORE_IT_MOVES = ("look", "join")
"""Questions that a bench of another protocol is refused with."""


def refuse_protocol(question: object, bench: str, told: Mapping[str, Any], here: str) -> None:
    """Refuse a bench whose protocol is another, before anything moves. ``told``: what it asked or answered;
    ``here``: words for this bench.

    Raises:
        VerbRefused: it is another one.
    """
    there = protocol_of(told)
    if question in _BEFORE_IT_MOVES and there != PROTOCOL_VERSION:
        raise VerbRefused("cannot", protocol_words(bench, there, here))


def protocol_of(told: Mapping[str, Any]) -> int:
    """Version of the protocol that a bench tells; 0: none, as of hil 0.2 and before."""
    version = told.get("protocol", 0)
    return version if type(version) is int else 0


def protocol_words(bench: str, there: int, here: str) -> str:
    """Sentence about a bench of another protocol, which says which of both to update."""
    older = bench if there < PROTOCOL_VERSION else here
    said = f"{bench} speaks protocol {there} between benches, and {here} {PROTOCOL_VERSION}"
    return f"{said}: update hil on {older}"


def stood_still(for_s: float) -> str:
    """Reason why a part ends whose own bench was not running."""
    return f"this bench stood still for {for_s:.1f} s"


def axis_told(axis: AxisNow) -> dict[str, Any]:
    """Axis as benches tell each other: these words are in what they send, whatever they are called here."""
    return {
        "kind": "servo" if axis.follows_paths else "stepper",
        "position_deg": axis.position_deg,
        "fields": axis.fields,
        "pins": axis.pins,
        "why_not": axis.why_not,
        "remedy": axis.remedy,
        "is_real": not axis.tells_position,
        "is_awaited": axis.is_awaited,
        "bounds": {name: _bound_told(bound) for name, bound in axis.bounds.items()},
    }


def axis_heard(told: Mapping[str, Any]) -> AxisNow:
    """Axis that another bench told. Raises KeyError, TypeError: it told something else."""
    return AxisNow(
        told["position_deg"],
        told["kind"] == "servo",
        told["fields"],
        told["pins"],
        told["why_not"],
        str(told.get("remedy", "leave it out")),
        tells_position=not told["is_real"],
        bounds={str(name): _bound_heard(name, bound) for name, bound in told.get("bounds", {}).items()},
        is_awaited=bool(told.get("is_awaited", False)),
    )


def _bound_told(bound: Parameter) -> dict[str, Any]:
    return {
        "least": bound.minimum,
        "most": bound.maximum,
        "default": bound.default,
        "is_whole": bound.is_whole,
    }


def _bound_heard(name: str, told: Mapping[str, Any]) -> Parameter:
    default = None if told["default"] is None else float(told["default"])
    return Parameter(
        name,
        "",
        minimum=float(told["least"]),
        maximum=float(told["most"]),
        default=default,
        is_whole=bool(told["is_whole"]),
    )


@dataclass
class Member:
    """Another bench that takes part. ``names``: its devices, by their names in the run."""

    bench: str
    names: Mapping[str, str]
    clock: ClockOffset = field(default_factory=ClockOffset)
    joined: bool = False
    heard_s: float = 0.0
    report: Mapping[str, Any] = field(default_factory=dict)
    gone: str | None = None

    @property
    def progress(self) -> Mapping[str, Any]:
        return self.report.get("progress") or {}

    @property
    def state(self) -> str:
        return "gone" if self.gone else str(self.progress.get("state", "queued"))

    @property
    def is_over(self) -> bool:
        return self.state not in ("queued", "running")


class OtherBenches:
    """Reaches other benches by the first of ``bridges`` that can. ``bridges``: those that are open."""

    def __init__(self, bridges: Mapping[str, Bridge]) -> None:
        self._bridges = bridges

    def _door(self) -> BenchDoor | None:
        return next((bridge for bridge in self._bridges.values() if isinstance(bridge, BenchDoor)), None)

    async def ask(
        self, source: Source, member: Member, run: str, given: Mapping[str, Any], timeout_s: float = ANSWER_S
    ) -> Mapping[str, Any]:
        """Ask a bench about its part of ``run``; its clock is compared on the way.

        Raises:
            BenchGone: it does not answer in time.
            VerbRefused: it refuses.
        """
        if (door := self._door()) is None:
            why = f"{member.bench}: this bench is joined to no other; it needs `bridges: {{zenoh: ...}}`"
            raise BenchGone(why)
        asked = {**given, "protocol": PROTOCOL_VERSION}
        answered = await door.ask_bench(source, member.bench, f"run/{run}/part", asked, timeout_s)
        refuse_protocol(given.get("do"), f"the bench {member.bench}", answered.content, "this one")
        member.clock.add(answered.asked_ns, int(answered.content["wall_ns"]), answered.heard_ns)
        return answered.content

    async def ask_again(
        self, source: Source, member: Member, run: str, given: Mapping[str, Any], timeout_s: float = ANSWER_S
    ) -> Mapping[str, Any]:
        """Ask as ``ask``, again and again within the time: a question may be lost."""
        try:
            return await asked_again(
                lambda left_s: self.ask(source, member, run, given, max(left_s, LEAST_ANSWER_S)), timeout_s
            )
        except BenchGone as gone:
            if self._door() is None:
                raise
            raise BenchGone(f"the bench {member.bench} did not answer within {timeout_s:g} s") from gone

    async def stop(self, source: Source, how: str, timeout_s: float) -> Sequence[dict[str, Any]]:
        """Stop all other benches, as ``BenchDoor.stop_others``; none where this bench is joined to none."""
        door = self._door()
        return await door.stop_others(source, how, timeout_s) if door else ()

    async def joined(self, source: Source) -> list[dict[str, Any]]:
        """List those that can be in a run with this one, with their clocks; ``why`` says what prevents it."""
        door = self._door()
        rows = list[dict[str, Any]]()
        if door and (clash := door.name_clash()):
            rows.append(_row(Member(clash.bench, {}), f"{clash.what}; {clash.remedy}"))
        names = await door.benches() if door else ()
        return rows + await asyncio.gather(*(self._joined_row(source, name) for name in names))

    async def _joined_row(self, source: Source, name: str) -> dict[str, Any]:
        member = Member(name, {})
        told: Mapping[str, Any] = {}
        try:
            for _ in range(LOOKS + 1):
                told = await self.ask(source, member, "none", {"do": "clock"})
        except (BenchGone, VerbRefused) as error:
            return _row(member, str(error))
        there = protocol_of(told)
        is_like = there == PROTOCOL_VERSION
        return _row(member, None if is_like else protocol_words(f"the bench {name}", there, "this one"), told)


def _row(member: Member, why: str | None, told: Mapping[str, Any] = MappingProxyType({})) -> dict[str, Any]:
    """Row of a bench that is joined, with what it told of itself."""
    clock = member.clock
    return {
        "bench": member.bench,
        "version": told.get("version"),
        "protocol": protocol_of(told) if told else None,
        "speed": told.get("speed"),
        "why": why,
        "clock_offset_ns": clock.offset_ns,
        "clock_error_ns": clock.error_ns,
    }
