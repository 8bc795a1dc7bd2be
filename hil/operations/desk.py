"""The desk: whatever is asked of a bench is checked here against the table and handed to the part that
answers it, so that it is refused in the same words at every door."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

from hil.config.explain import suggestion
from hil.operations.table import EVERY_BOARDS, OPERATIONS
from hil.vocab.bridges import BenchClock, Description, DeviceInfo, Source, Watch, Watched
from hil.vocab.operation import Target
from hil.vocab.verbs import Role, VerbRefused

CANNOT = "the daemon sees its terminal, not its pins, shaft or encoder; type at it with `hil monitor`"
_SHOWN = 80
_OF_DEVICES = (Target.DEVICE, Target.TWIN, Target.UART)


class Asked(NamedTuple):
    """Who asks, and of what."""

    source: Source
    target: str


Answerer = Callable[..., Any]
"""Called with an ``Asked`` and the operation's parameters; answers, or raises VerbRefused."""


class Watches(Protocol):
    """What can be watched."""

    def open(
        self, what: Watched, target: str, call: Callable[..., object], interval_ns: int | Fraction
    ) -> Watch: ...

    def ports(self) -> Sequence[str]:
        """Names of what bytes pass at."""


class Desk:
    """``hil.vocab.bridges.Desk``. ``answerers``: of all operations of the table, by name."""

    def __init__(
        self,
        bench: str,
        clock: BenchClock,
        devices: Mapping[str, DeviceInfo],
        segments: Mapping[str, object],
        watches: Watches,
        answerers: Mapping[str, Answerer],
    ) -> None:
        self._bench, self._clock, self._devices, self._segments = bench, clock, devices, segments
        self._watches, self._answerers = watches, answerers
        assert answerers.keys() == OPERATIONS.keys(), answerers.keys() ^ OPERATIONS.keys()

    def describe(self) -> Description:
        return Description(
            self._bench, self._clock, self._devices, self._segments.keys(), self._watches.ports(), OPERATIONS
        )

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        if (known := OPERATIONS.get(operation)) is None:
            raise no_operation(operation)
        _permit(source, known.name, known.role)
        self._find(known.target, target)
        answer, asked, values = self._answerers[known.name], Asked(source, target), known.filled(given)
        return self._do(asked, **values) if known.name == "do" else answer(asked, **values)

    def watch(
        self,
        source: Source,
        what: Watched,
        target: str,
        call: Callable[..., object],
        *,
        interval_ns: int | Fraction = 0,
    ) -> Watch:
        if what is Watched.SAMPLES:
            self._find(Target.TWIN, target)
        return self._watches.open(what, target, call, interval_ns)

    def _find(self, kind: Target, target: str) -> None:
        """Refuse devices that are not there, and real ones where the axis has to be seen."""
        if kind not in _OF_DEVICES:
            return
        name = target.partition(".")[0] if kind is Target.UART else target
        if name not in self._devices:
            known = ", ".join(self._devices)
            raise VerbRefused("no_device", f"no device {shown(name)}; there are {known}")
        if kind is Target.TWIN and self._devices[name].is_real:
            raise VerbRefused("cannot", f"{name} is a real board: {CANNOT}")

    def _do(self, asked: Asked, name: str, parameters: Mapping[str, object]) -> Any:
        """A verb of the device. One that all boards have is an operation itself."""
        if name in EVERY_BOARDS:
            return self.ask(asked.source, name, asked.target, parameters)
        device = self._devices[asked.target]
        if (verb := device.verbs.get(name)) is None:
            raise VerbRefused(
                "no_verb",
                f"{device.name}, a {device.profile}, has no {shown(name)}; {suggestion(name, device.verbs)}",
            )
        _permit(asked.source, name, verb.role)
        return self._answerers["do"](asked, verb, verb.filled(parameters))


def no_operation(name: str) -> VerbRefused:
    """What is not in the table, or has no answer in JSON, for those who write JSON."""
    known = ", ".join(each.name for each in OPERATIONS.values() if each.answer is not None)
    return VerbRefused("no_verb", f"there is no verb {shown(name)}; verbs are {known}")


def _permit(source: Source, what: str, role: Role) -> None:
    if source.role < role:
        raise VerbRefused("forbidden", f"{what} needs the role {role.name.lower()}")


def shown(text: str) -> str:
    """A text from outside in a refusal."""
    return repr(text[:_SHOWN]) + "..." * (len(text) > _SHOWN)
