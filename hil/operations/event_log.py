"""Log of what happened to a running bench, and who asked for it: its latest events, for all who look on."""

from collections import OrderedDict
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from hil.operations.table import Asked
from hil.sim.noted_events import NotedEvent
from hil.vocab.verbs import VerbRefused

KIND_OF = {
    "type": "typed",
    "send": "typed",
    "inject": "faults",
    "clear": "faults",
    "run": "runs",
    "cancel_run": "runs",
    "pace_run": "runs",
    "part": "runs",
    "attach": "clients",
    "detach": "clients",
    "reload": "reloads",
}
"""Kinds of events by operations, of ``EVENT_KINDS``; all others are verbs."""
DONE, REFUSED, NOT_ENDED = OUTCOMES = ("done", "refused", "not ended")
"""Outcomes of requests."""
KEPT = 1000
"""Maximum number of events that are kept."""
TEXT = 240
"""Maximum number of characters of an event's text."""
_VALUE = 40
_TOGETHER_NS = 1_000_000_000
"""Time within which what is asked again and again is one event."""

Event = dict[str, Any]
"""Event with ``number``, ``revision``, ``kind``, ``at_ns``, ``to_ns``, ``of``, ``who``, ``text``, ``count``.
One that stands for several has their number as ``count``, and the time of the last as ``to_ns``."""


class Wish(NamedTuple):
    """Request, as an event has it. ``name``: its operation or the device's verb; ``streams``: it is asked for
    again and again, as set-points are."""

    asked: Asked
    operation: str
    name: str
    given: Mapping[str, object]
    streams: bool = False

    @property
    def kind(self) -> str:
        return KIND_OF.get(self.operation, "verbs")

    def words(self) -> str:
        """Format it: ``move_abs position_deg 90``; what is long, as a program, is left out."""
        values = [
            f"{name} {value}"
            for name, value in self.given.items()
            if isinstance(value, int | float) or (isinstance(value, str) and len(value) <= _VALUE)
        ]
        return " ".join([self.name, ", ".join(values)]) if values else self.name


class EventLog:
    """Latest events. ``now_ns``: simulated time, now."""

    def __init__(self, now_ns: Callable[[], int]) -> None:
        self._now_ns = now_ns
        self._events: OrderedDict[int, Event] = OrderedDict()
        self._together: OrderedDict[tuple[str, ...], Event] = OrderedDict()
        """Events that another of their kind may join, by what they have in common."""
        self._number = self._revision = 0
        self.cleared = set[int]()
        """Numbers of faults whose end is in the log already."""
        self.listeners: list[Callable[[Event], object]] = []
        """Called with each event, and again when another joined it."""
        self.outcomes: list[Callable[[Wish, str, VerbRefused | None], object]] = []
        """Called with each request and its outcome of ``OUTCOMES``, and why it was refused."""

    def begin_with(self, events: Iterable[NotedEvent]) -> None:
        """Take the events of a recorded run, of which this one is the future."""
        for noted in events:
            self._revision += 1
            self._number = noted.number
            event = self._events[noted.number] = {**noted.as_dict(), "revision": self._revision}
            for listener in tuple(self.listeners):
                listener(dict(event))
        self._keep_latest()

    def put(
        self, kind: str, of: str, who: str, text: str, *, at_ns: int | None = None, common: str = ""
    ) -> None:
        """Note an event. ``common``: what it has in common with others that may join it; empty: its text."""
        at_ns = self._now_ns() if at_ns is None else at_ns
        text = text if len(text) <= TEXT else f"{text[: TEXT - 1]}…"
        key = (kind, of, who, common or text)
        self._revision += 1
        event = self._together.get(key)
        if event and 0 <= at_ns - event["to_ns"] <= _TOGETHER_NS:
            event |= {"revision": self._revision, "to_ns": at_ns, "text": text, "count": event["count"] + 1}
        else:
            event = self._begin(key, at_ns, text)
        for listener in tuple(self.listeners):
            listener(dict(event))

    def _begin(self, key: tuple[str, ...], at_ns: int, text: str) -> Event:
        kind, of, who, _ = key
        self._number += 1
        event = {"number": self._number, "revision": self._revision, "kind": kind, "at_ns": at_ns}
        event |= {"to_ns": at_ns, "of": of, "who": who, "text": text, "count": 1}
        self._events[self._number] = self._together[key] = event
        self._keep_latest()
        return event

    def _keep_latest(self) -> None:
        for kept in (self._events, self._together):
            while len(kept) > KEPT:
                kept.popitem(last=False)

    def done(self, wish: Wish, answer: Any) -> None:
        """Note that a request was carried out."""
        self._tell(wish, DONE)
        asked, given = wish.asked, wish.given
        if wish.operation.endswith("_lease") or (wish.operation == "run" and given.get("check")):
            return  # a lease has its own words
        words, of = wish.words(), asked.target
        if wish.operation == "run" and isinstance(answer, Mapping):
            of, words = "", f"{answer.get('run', '')} submitted"
        elif wish.operation == "inject":
            words = Wish(asked, "inject", str(given["fault"]), _object(given["parameters"])).words()
        elif wish.operation == "clear" and isinstance(answer, Mapping):
            self.cleared |= set(answer["cleared"])
            words = f"cleared {', '.join(map(str, answer['cleared'])) or 'none'}"
        elif wish.operation == "halt" and isinstance(answer, Mapping):
            words = halt_words(answer)
        elif wish.operation == "stop_site" and isinstance(answer, Mapping):
            words = site_words(answer)
        common = wish.name if wish.streams or wish.kind == "typed" else ""
        self.put(wish.kind, of, asked.source.name, words, at_ns=_effective_at_ns(answer), common=common)

    def refused(self, wish: Wish, refusal: VerbRefused) -> None:
        """Note that a request was refused."""
        self._tell(wish, REFUSED, refusal)
        why = str(refusal).splitlines() or [refusal.code]
        self.put("refusals", wish.asked.target, wish.asked.source.name, f"{wish.name}: {why[0]}")

    def latest_first(self) -> Iterator[Event]:
        """Look at the events that are kept, the latest first."""
        return reversed(self._events.values())

    def not_ended(self, wish: Wish) -> None:
        """Note that nobody waits for a request any more, or that an error of hil's own ended it."""
        self._tell(wish, NOT_ENDED)

    def _tell(self, wish: Wish, outcome: str, refusal: VerbRefused | None = None) -> None:
        for tell in self.outcomes:
            tell(wish, outcome, refusal)

    def told(self, after: int) -> dict[str, Any]:
        """Answer of the operation: events that are new, or have changed, since a revision, the oldest first.
        ``left_out``: number of those before the oldest that is kept."""
        first = next(iter(self._events), self._number + 1)
        new = [dict(event) for event in self._events.values() if event["revision"] > after]
        return {"events": new, "left_out": first - 1, "revision": self._revision}


def site_words(answer: Mapping[str, Any]) -> str:
    """Format an answer of ``stop_site``: what it stopped here, and which benches have not confirmed."""
    own, *others = answer["benches"]
    missing = [row["bench"] for row in others if row["state"] != "confirmed"]
    said = f"{halt_words(own)}; {len(others) - len(missing)} of {len(others)} other benches confirmed"
    return said + (f", not {', '.join(missing)}" if missing else "")


def halt_words(answer: Mapping[str, Any]) -> str:
    """Format an answer of ``halt``: what it stopped, and what could not be stopped."""
    stopped = [*answer["stopped"], *(f"run {name}" for name in answer["runs"])]
    refused = [f"{name}: {why}" for name, why in answer["refused"].items()]
    said = f"stopped {', '.join(stopped)}" if stopped else "nothing moved"
    return "; not stopped: ".join([said, "; ".join(refused)]) if refused else said


def _object(given: object) -> Mapping[str, object]:
    return given if isinstance(given, Mapping) else {}


def _effective_at_ns(answer: Any) -> int | None:
    at_ns = getattr(answer, "effective_at_ns", None)
    return at_ns if isinstance(at_ns, int) else None


class NotedDoing(Generator[Any, Any, Any]):
    """Coroutine that has its end noted. It is the coroutine itself otherwise: one that nobody begins has
    not begun."""

    def __init__(
        self,
        doing: Any,
        done: Callable[[Any], None],
        refused: Callable[[VerbRefused], None],
        not_ended: Callable[[], None],
    ) -> None:
        self._doing, self._done, self._refused, self._not_ended = doing, done, refused, not_ended

    def __await__(self) -> Iterator[Any]:
        return self

    def send(self, value: Any) -> Any:
        return self._step(lambda: self._doing.send(value))

    def throw(self, *error: Any) -> Any:
        return self._step(lambda: self._doing.throw(*error))

    def close(self) -> None:
        self._doing.close()

    def _step(self, step: Callable[[], Any]) -> Any:
        try:
            return step()
        except StopIteration as end:
            self._done(end.value)
            raise
        except VerbRefused as refusal:
            self._refused(refusal)
            raise
        except BaseException:
            self._not_ended()
            raise
