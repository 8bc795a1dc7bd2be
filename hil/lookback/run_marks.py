"""Marks of a time line: what happened in a recorded run, by lanes, summed where it is too much."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hil.recorded.run_events import fault_words, input_event
from hil.sim.inputs import Bytes, Clear, CommitDone, Follow, Inject, Logged, Stopped
from hil.sim.noted_events import NotedEvent
from hil.vocab.faults import FAULT_KINDS
from hil.vocab.time import NS_PER_S, SimTimeNs

LANES = (
    "faults",
    "runs",
    "verbs",
    "typed",
    "refusals",
    "stops",
    "lateness",
    "trouble",
    "reloads",
    "clients",
)
"""Lanes of marks, from the top."""
MOST_MARKS = 400
"""Maximum number of marks of a lane; more are summed."""
_BETWEEN_NS = 1_000_000_000
"""Time without bytes after which a client types again."""
_TEXT = 120
_HAPPENED = frozenset({"refusals", "lateness", "trouble", "reloads", "clients"})
"""Kinds of events of which the inputs say nothing."""
_SAME_NS = 100_000_000
"""Time within which a refusal that was found by running again is the one that an event is of."""

Mark = dict[str, Any]
"""Mark with ``lane``, ``from_ns``, ``to_ns`` (None: it lasts), ``of`` and ``text``; one that stands for
several has ``count``, that of a fault that comes again ``every_ns`` and ``for_ns``, until its end."""


class RunMarks:
    """Marks of a log's inputs, which come in the order of the log."""

    def __init__(self) -> None:
        self._marks: dict[str, list[Mark]] = {lane: [] for lane in LANES}
        self._faults: dict[int, Mark] = {}
        self._typing: dict[str, Mark] = {}
        self._happened: dict[int, Mark] = {}
        """Marks of events that no input is the cause of, by their numbers."""
        self._found: list[Mark] = []
        """Refusals that were found by running again; most are events, too."""
        self.count = 0
        """Counts up with each change."""

    def add(self, logged: Logged) -> None:
        """Note an input, if a time line shows it."""
        at_ns, of, given = logged
        self.count += 1
        match given:
            case Inject():
                self._inject(at_ns, of, given)
            case Clear():
                self._clear(at_ns, given.number)
            case Follow():
                self._follow(at_ns, of, given)
            case Stopped():
                self._put("stops", at_ns, of, f"{of} stopped: {given.reason}")
            case Bytes():
                self._type(at_ns, of, len(given.data))
            case CommitDone():
                pass
            case _:
                self._put("verbs", at_ns, of, f"{of} {input_event(logged).words()}")

    def note(self, notes: Iterable[Mapping[str, Any]]) -> None:
        """Note what the run itself told on its way."""
        for note in notes:
            self.count += 1
            self._put(note["lane"], note["at_ns"], note["of"], note["text"])
            if note["lane"] == "refusals":
                self._found.append(self._marks["refusals"].pop())

    def happen(self, event: NotedEvent) -> None:
        """Note an event, or that others joined it, if no input has its kind."""
        if event.kind not in _HAPPENED:
            return
        self.count += 1
        words = f"{event.of}: {event.text}" if event.of not in ("", event.who) else event.text
        asker = f" ({event.who})" if event.who not in ("", "bench", event.of) else ""
        if (mark := self._happened.get(event.number)) is None:
            mark = self._happened[event.number] = self._put(event.kind, event.at_ns, event.of, "")
        mark |= {"to_ns": event.to_ns, "text": _short(f"{words}{asker}")}

    def told(self, until_ns: int, most: int = MOST_MARKS) -> list[Mark]:
        """Marks of all lanes, by lanes and times; of no lane more than ``most``. ``until_ns``: time up to
        which the run is known, and faults have come again."""
        faults = [each for mark in self._marks["faults"] for each in _times_of(mark, until_ns, most)]
        asked = self._marks["refusals"]
        known = {mark["from_ns"] // _SAME_NS + by for mark in asked for by in (-1, 0, 1)}
        found = (mark for mark in self._found if mark["from_ns"] // _SAME_NS not in known)
        refusals = sorted([*asked, *found], key=lambda mark: mark["from_ns"])
        lanes = self._marks | {
            "refusals": refusals,
            "faults": sorted(faults, key=lambda mark: mark["from_ns"]),
        }
        return [mark for lane in LANES for mark in _summed(lanes[lane], most)]

    def _put(self, lane: str, at_ns: int, of: str, text: str, *, lasts: bool = False) -> Mark:
        mark = {"lane": lane, "from_ns": at_ns, "to_ns": None if lasts else at_ns, "of": of}
        mark["text"] = _short(text)
        self._marks[lane].append(mark)
        return mark

    def _inject(self, at_ns: SimTimeNs, of: str, given: Inject) -> None:
        """Note a fault, up to its end if its time is told."""
        parameters = dict(given.parameters)
        start_ns, for_ns, every_ns = (
            round(float(parameters.get(name, 0.0)) * NS_PER_S) for name in ("start_s", "for_s", "every_s")
        )
        mark = self._put("faults", at_ns, of, fault_words(given.kind, parameters), lasts=True)
        mark |= {"number": given.number, "from_ns": at_ns + start_ns}
        if every_ns:
            mark |= {"every_ns": every_ns, "for_ns": for_ns}
        elif for_ns or FAULT_KINDS[given.kind].is_once:
            mark["to_ns"] = at_ns + start_ns + for_ns
        self._faults[given.number] = mark

    def _clear(self, at_ns: SimTimeNs, number: int) -> None:
        """Note that a fault was cleared, perhaps before it began."""
        if (mark := self._faults.pop(number, None)) is None:
            return
        if mark["from_ns"] > at_ns:
            self._marks["faults"].remove(mark)
        elif mark["to_ns"] is None or mark["to_ns"] > at_ns:
            mark["to_ns"] = at_ns

    def _follow(self, at_ns: SimTimeNs, of: str, given: Follow) -> None:
        """Note a path; axes that begin one together are one mark."""
        from_ns = max(given.start_ns, at_ns)
        to_ns = given.start_ns + sum(piece.duration_ns for piece in given.path)
        before = self._marks["runs"][-1] if self._marks["runs"] else None
        if before and before["from_ns"] == from_ns and of not in before["of"].split(", "):
            before["of"] += f", {of}"
            before["text"] = f"path of {before['of']}"
            before["to_ns"] = max(before["to_ns"], to_ns)
        else:
            self._put("runs", from_ns, of, f"path of {of}")["to_ns"] = max(from_ns, to_ns)

    def _type(self, at_ns: SimTimeNs, of: str, size: int) -> None:
        mark = self._typing.get(of)
        if mark is None or at_ns - mark["to_ns"] > _BETWEEN_NS:
            mark = self._typing[of] = self._put("typed", at_ns, of, "") | {"bytes": 0}
            self._marks["typed"][-1] = mark
        mark["to_ns"], mark["bytes"] = at_ns, mark["bytes"] + size
        mark["text"] = f"{mark['bytes']} bytes to {of}"


def _short(text: str) -> str:
    return text if len(text) <= _TEXT else f"{text[: _TEXT - 1]}…"


def _times_of(mark: Mark, until_ns: int, most: int) -> Iterable[Mark]:
    """Marks of a fault: one for each time that it came, as long as they are not too many."""
    if "every_ns" not in mark:
        return (mark,)
    own = {name: value for name, value in mark.items() if name not in ("every_ns", "for_ns")}
    every_ns, for_ns, end_ns = mark["every_ns"], mark["for_ns"], mark["to_ns"]
    last_ns = until_ns if end_ns is None else end_ns
    begins = range(mark["from_ns"], max(last_ns, mark["from_ns"]) + 1, every_ns)
    if len(begins) > most:
        return (own,)
    return [
        own | {"from_ns": at_ns, "to_ns": at_ns + for_ns if end_ns is None else min(at_ns + for_ns, end_ns)}
        for at_ns in begins
    ]


def _summed(marks: Sequence[Mark], most: int) -> Iterable[Mark]:
    """Marks of a lane, neighbours as one where there are more than ``most``."""
    if len(marks) <= most:
        return marks
    first, last = marks[0]["from_ns"], marks[-1]["from_ns"]
    width = max((last - first) // most, 1)
    groups: dict[int, list[Mark]] = {}
    for mark in marks:
        groups.setdefault((mark["from_ns"] - first) // width, []).append(mark)
    return [group[0] if len(group) == 1 else _sum_of(group) for group in groups.values()]


def _sum_of(group: Sequence[Mark]) -> Mark:
    ends = [mark["to_ns"] for mark in group]
    owners = ", ".join(dict.fromkeys(mark["of"] for mark in group))
    text = f"{len(group)} times, the first: {group[0]['text']}"
    to_ns = None if None in ends else max(ends)
    return {**group[0], "to_ns": to_ns, "of": owners[:_TEXT], "text": text[:_TEXT], "count": len(group)}
