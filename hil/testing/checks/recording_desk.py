"""Desk for tests of bridges: a bench of two boards that notes what it is asked."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from hil.vocab.desk_protocol import AxisField, Description, DeviceInfo, Done, Source, Watch, Watched
from hil.vocab.operation import Operation
from hil.vocab.verbs import Verb, VerbRefused, table_of

NOW_NS, WALL_NS = 5_000_000_000, 1_700_000_000_000_000_000
SET_POINT = AxisField("r", "f32", "deg", "set-point", 0, False, True)
WAVE = Verb("wave", "do something that can be seen")


class _Clock:
    def times_ns(self) -> tuple[int, int]:
        return NOW_NS, WALL_NS

    def wall_ns(self, sim_ns: int) -> int:
        return WALL_NS + sim_ns - NOW_NS


class _Watching:
    """Watch on something that never happens."""

    lost = 0

    def __init__(self, desk: "RecordingDesk") -> None:
        self._desk = desk

    def flush(self) -> None:
        """Nothing waits."""

    def close(self) -> None:
        self._desk.watches.discard(self)


class RecordingDesk:
    """``hil.vocab.desk_protocol.Desk`` of a bench with a twin ``m1`` and a real board ``m2``, whose verb
    beside the common ones is ``wave``. It answers ``do`` and what ``answers`` has, and refuses the rest as a
    bench does: what is not there, and all while ``refusal`` is set."""

    def __init__(
        self, answers: Mapping[str, Any] | None = None, operations: Mapping[str, Operation] | None = None
    ) -> None:
        verbs = table_of((WAVE,))
        self.devices = {
            "m1": DeviceInfo("m1", "specimen", False, verbs, {"r": SET_POINT}),
            "m2": DeviceInfo("m2", "specimen", True, verbs, {}),
        }
        self.refusal: VerbRefused | None = None
        self.asked: list[tuple[Source, str, str]] = []
        """Origin, name and target of each operation."""
        self.done: list[tuple[str, str]] = []
        """Device and verb of what was carried out."""
        self.watches: set[_Watching] = set()
        self._answers = answers or {}
        self._operations = operations or {}

    def ask(self, source: Source, operation: str, target: str, given: Mapping[str, object]) -> Any:
        self.asked.append((source, operation, target))
        if self.refusal:
            raise self.refusal
        if operation in self._answers:
            return self._answers[operation]
        if target not in self.devices:
            raise VerbRefused("no_device", f"there is no device {target!r}")
        verb = str(given.get("name", operation))
        if verb not in self.devices[target].verbs:
            raise VerbRefused("no_verb", f"{target} has no verb {verb!r}")
        parameters = given.get("parameters", {})
        self.devices[target].verbs[verb].filled(parameters if isinstance(parameters, Mapping) else {})
        self.done.append((target, verb))
        return Done(NOW_NS, {})

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
        watching = _Watching(self)
        self.watches.add(watching)
        return watching

    def note_refusal(
        self, source: Source, operation: str, target: str, given: Mapping[str, object], refusal: VerbRefused
    ) -> None:
        """Do nothing: it has no events."""

    def describe(self) -> Description:
        ports: Sequence[str] = tuple(self.devices)
        return Description("check", _Clock(), self.devices, {}, ports, self._operations)
