"""The desk: every request to a bench is checked here against the table and handed to the part that answers
it, so that it is refused in the same words at every door."""

from collections.abc import Callable, Coroutine, Mapping
from fractions import Fraction
from functools import partial
from typing import Any

from hil.config.explain import suggestion
from hil.operations.event_log import EventLog, NotedDoing, Wish
from hil.operations.leases import Leases
from hil.operations.table import EVERY_BOARDS, OPERATIONS, Answerer, Asked
from hil.operations.watch_operations import WatchOperations
from hil.vocab.address import owner_of
from hil.vocab.desk_protocol import Description, Source, Watch, Watched
from hil.vocab.device import Device
from hil.vocab.near_words import meant
from hil.vocab.operation import STOP_VERB, Operation, Target
from hil.vocab.verbs import Effect, Role, VerbRefused, checked

_SHOWN = 80
_STREAMS = ("transmit", "play", "set", "pin")
"""Operations that programs ask for again and again."""
_OF_DEVICES = (Target.DEVICE, Target.MEMBER, Target.TWIN, Target.UART)


class Desk:
    """Desk of a bench, ``hil.vocab.desk_protocol.Desk``. ``description``: current whenever it is looked at;
    ``answerers``: of all operations, by name; ``events``: has what is done, and what is refused; ``leases``:
    says who may command now."""

    def __init__(
        self,
        description: Description,
        devices: Mapping[str, Device],
        looks: WatchOperations,
        answerers: Mapping[str, Answerer],
        events: EventLog,
        leases: Leases,
    ) -> None:
        self._description, self._events, self._leases = description, events, leases
        self._known, self._devices = devices, description.devices
        self._looks, self._answerers = looks, answerers
        assert answerers.keys() == OPERATIONS.keys(), answerers.keys() ^ OPERATIONS.keys()

    def describe(self) -> Description:
        return self._description

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        operation = operation.replace("-", "_")
        if (known := OPERATIONS.get(operation)) is None:
            raise no_operation(operation)
        if operation != "do" and known.role is Role.VIEWER:
            return self._answer(source, known, target, given)
        wish = self._wish(Asked(source, target), operation, given)
        try:
            answer = self._answer(source, known, target, given)
        except VerbRefused as refusal:
            self._events.refused(wish, refusal)
            raise
        except Exception:
            self._events.not_ended(wish)
            raise
        if isinstance(answer, Coroutine):
            events = self._events
            ends = (events.done, events.refused, events.not_ended)
            return NotedDoing(answer, *(partial(end, wish) for end in ends))
        self._events.done(wish, answer)
        return answer

    def note_refusal(
        self, source: Source, operation: str, target: str, given: Mapping[str, object], refusal: VerbRefused
    ) -> None:
        operation = operation.replace("-", "_")
        known = OPERATIONS.get(operation)
        if known and (operation == "do" or known.role is not Role.VIEWER):
            self._events.refused(self._wish(Asked(source, target), operation, given), refusal)

    def _answer(self, source: Source, known: Operation, target: str, given: Mapping[str, object]) -> Any:
        require_role(source, known.name, known.role)
        asked = Asked(source, self._find(known.target, target))
        values = checked(known.name, known.parameters, given)
        if known.name == "do":
            return self._do(asked, **values)
        if known.role is not Role.VIEWER:
            self._leases.check(source, known.name, values)
        return self._answerers[known.name](asked, **values)

    def _wish(self, asked: Asked, operation: str, given: Mapping[str, object]) -> Wish:
        """Request as an event has it; a device's verb in the place of ``do``."""
        if operation != "do":
            return Wish(asked, operation, operation, given, operation in _STREAMS)
        name = str(given.get("name", ""))[:_SHOWN].replace("-", "_")
        device, parameters = self._devices.get(asked.target), given.get("parameters")
        verb = device.verbs.get(name) if device else None
        streams = verb is not None and verb.effect is Effect.STREAM
        named = parameters if isinstance(parameters, Mapping) else {}
        return Wish(asked, name if name in EVERY_BOARDS else "do", name, named, streams)

    def watch(
        self,
        source: Source,
        what: Watched,
        target: str,
        call: Callable[..., object],
        *,
        interval_ns: int | Fraction = 0,
        points: int = 1,
    ) -> Watch:
        if what is Watched.SAMPLES:
            target = self._find(Target.TWIN, target)
        return self._looks.open(what, target, call, interval_ns, points)

    def _find(self, kind: Target, target: str) -> str:
        """Address that a target means, as hil writes it. Refuses devices and axes that are not there, and
        real ones where the axis has to be seen; whether a UART is there, who types there finds."""
        if kind not in _OF_DEVICES:
            return target
        name = owner_of(target) if kind is Target.UART else target
        found = self._devices.get(name)
        if found is None or (kind is Target.DEVICE and found.name != owner_of(target)):
            raise VerbRefused("no_device", f"no device {shown(name)}; {meant(name, self._devices)}")
        if kind is Target.TWIN and (refused := self._known[owner_of(name)].no_axis()):
            raise refused
        return target if kind is Target.UART else found.name

    def _do(self, asked: Asked, name: str, parameters: Mapping[str, object]) -> Any:
        """Carry out a verb of the device. A verb that all boards have is an operation itself."""
        name = name.replace("-", "_")  # as in move-abs
        if name in EVERY_BOARDS:
            return self._answer(asked.source, OPERATIONS[name], asked.target, parameters)
        device = self._devices[asked.target]
        if (verb := device.verbs.get(name)) is None:
            raise VerbRefused(
                "no_verb",
                f"{device.name}, a {device.profile}, has no {shown(name)}; {suggestion(name, device.verbs)}",
            )
        require_role(asked.source, name, verb.role)
        values = verb.filled(parameters)
        if verb.role is not Role.VIEWER and name != STOP_VERB:
            self._leases.check(asked.source, "do", values)
        return self._answerers["do"](asked, verb, values)


def require_role(source: Source, what: str, role: Role) -> None:
    """Refuse an asker with less than this role: a door finds out who asks, and which role that is. ``what``:
    the operation or the verb, for the text.

    Raises:
        VerbRefused: it is not allowed.
    """
    if source.role < role:
        raise VerbRefused("forbidden", f"{what} needs the role {role.name.lower()}")


def no_operation(name: str) -> VerbRefused:
    """Refusal of what is not in the table, or has no answer in JSON, for those who write JSON."""
    known = [each.name for each in OPERATIONS.values() if each.answer is not None]
    return VerbRefused("no_verb", f"there is no verb {shown(name)}; {meant(name, known)}")


def shown(text: str) -> str:
    """Format a text from outside for a refusal."""
    return repr(text[:_SHOWN]) + "..." * (len(text) > _SHOWN)
