"""The desk: every request to a bench is checked here against the table and handed to the part that answers
it, so that it is refused in the same words at every door."""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from hil.config.explain import suggestion
from hil.operations.table import EVERY_BOARDS, OPERATIONS, Answerer, Asked
from hil.operations.watch_operations import WatchOperations
from hil.vocab.address import owner_of
from hil.vocab.desk_protocol import Description, Source, Watch, Watched
from hil.vocab.device import Device
from hil.vocab.near_words import meant
from hil.vocab.operation import Target
from hil.vocab.verbs import Role, VerbRefused, checked

_SHOWN = 80
_OF_DEVICES = (Target.DEVICE, Target.MEMBER, Target.TWIN, Target.UART)


class Desk:
    """Desk of a bench, ``hil.vocab.desk_protocol.Desk``. ``description``: current whenever it is looked at;
    ``answerers``: of all operations, by name."""

    def __init__(
        self,
        description: Description,
        devices: Mapping[str, Device],
        looks: WatchOperations,
        answerers: Mapping[str, Answerer],
    ) -> None:
        self._description = description
        self._known, self._devices = devices, description.devices
        self._looks, self._answerers = looks, answerers
        assert answerers.keys() == OPERATIONS.keys(), answerers.keys() ^ OPERATIONS.keys()

    def describe(self) -> Description:
        return self._description

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        operation = operation.replace("-", "_")
        if (known := OPERATIONS.get(operation)) is None:
            raise no_operation(operation)
        require_role(source, operation, known.role)
        asked = Asked(source, self._find(known.target, target))
        values = checked(operation, known.parameters, given)
        return self._do(asked, **values) if operation == "do" else self._answerers[operation](asked, **values)

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
            return self.ask(asked.source, name, asked.target, parameters)
        device = self._devices[asked.target]
        if (verb := device.verbs.get(name)) is None:
            raise VerbRefused(
                "no_verb",
                f"{device.name}, a {device.profile}, has no {shown(name)}; {suggestion(name, device.verbs)}",
            )
        require_role(asked.source, name, verb.role)
        return self._answerers["do"](asked, verb, verb.filled(parameters))


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
