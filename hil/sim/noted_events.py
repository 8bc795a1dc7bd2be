"""Events of a bench in its input log: what happened, and who asked for it.

A run does not need them to run again; without them nobody would know afterwards who asked, what was refused,
and who came. An event that stands for several has a line again when more have joined it: the last one counts.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from hil.sim.input_reading import taken, text, time_ns, whole

SHARED = frozenset({"verbs", "typed", "faults", "runs", "clients", "reloads"})
"""Kinds whose words are those of what a log has anyway; others may have names of folders."""


@dataclass(frozen=True)
class NotedEvent:
    """Event of a bench. ``to_ns``: time of the last of ``count`` that it stands for; ``of``: address that it
    is of, empty: the bench; ``who``: asker."""

    number: int
    kind: str
    at_ns: int
    to_ns: int
    of: str
    who: str
    text: str
    count: int

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def noted_event(event: Mapping[str, Any]) -> NotedEvent:
    """Make an event of the bench's own list one for the log."""
    return NotedEvent(**{name: event[name] for name in NotedEvent.__dataclass_fields__})


def encode_event(event: NotedEvent) -> str:
    """Encode the line of an event, without its end."""
    values = event.as_dict()
    kind = values.pop("kind")
    return json.dumps({"at_ns": values.pop("at_ns"), "event": kind, **values}, separators=(",", ":"))


def decode_event(values: dict[str, Any]) -> NotedEvent:
    """Decode a line's values, the reverse of ``encode_event``. Raises InputLogError: they are none."""
    times = taken(values, "at_ns", time_ns), taken(values, "to_ns", time_ns)
    of, who, words = (taken(values, name, text) for name in ("of", "who", "text"))
    number, count = taken(values, "number", whole), taken(values, "count", whole)
    return NotedEvent(number, taken(values, "event", text), *times, of, who, words, count)


def latest_events(events: Iterable[NotedEvent]) -> list[NotedEvent]:
    """Events as they were at last, in the order of their numbers."""
    return [event for _, event in sorted({event.number: event for event in events}.items())]


def without_names(event: NotedEvent) -> NotedEvent:
    """Event as others may have it: without who asked, and without words that may have names of folders."""
    return replace(event, who="", text=event.text if event.kind in SHARED else event.kind)
