"""Common part of real boards and real drives: hil sees less of them than of a twin."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any, NoReturn

from hil.vocab.axis import AxisNow
from hil.vocab.desk_protocol import AxisLook, Done, Watch
from hil.vocab.device import DeviceProcessor
from hil.vocab.ports import Port, PortStats
from hil.vocab.verbs import VerbRefused

NO_PORT = PortStats(clients=0, connects=0, rx_bytes=0, tx_bytes=0, dropped_bytes=0, unheard_bytes=0)
_COUNTERS = [field.name for field in fields(PortStats) if field.name not in ("clients", "away", "echo")]


def port_counters(stats: PortStats) -> dict[str, int]:
    return {name: getattr(stats, name) for name in _COUNTERS}


def port_row(port: Port) -> dict[str, Any]:
    """Address of a port, and the number of its clients."""
    return {"address": port.address, "clients": port.stats().clients}


class RealDevice(ABC):
    """Device that hil does not emulate. What is not overridden is refused. ``at``: its place, as the
    configuration has it; ``speed``: of the bench, whose time a real thing follows at 1 alone."""

    def __init__(self, name: str, at: str | None, speed: float) -> None:
        self.name, self._at, self._speed = name, at, speed

    def addresses(self) -> Iterator[str]:
        yield self.name

    def no_axis(self) -> VerbRefused | None:
        return None

    @abstractmethod
    def refusal(self) -> VerbRefused:
        """Refusal of what hil cannot do with it."""

    def _refuse(self) -> NoReturn:
        raise self.refusal()

    def set(self, part: str, field: str, value: Any) -> Any:
        self._refuse()

    def zero(self, part: str) -> Done:
        self._refuse()

    def pin(self, part: str, pin: str, level: int) -> Done:
        self._refuse()

    def processor(self) -> DeviceProcessor:
        raise VerbRefused("cannot", f"{self.name} is real: what is in its processor cannot be seen")

    def drive(self, part: str, train: Sequence[Any]) -> Done:
        self._refuse()

    def type(self, part: str, data: bytes) -> Done:
        self._refuse()

    def state(self, part: str) -> dict[str, float | None]:
        self._refuse()

    def packed(self, part: str) -> bytes:
        self._refuse()

    def look(self, part: str) -> AxisLook:
        self._refuse()

    async def wait(
        self,
        part: str,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None,
        set_point: float | None,
    ) -> dict[str, bool]:
        self._refuse()

    def watch(
        self, part: str, interval_ns: int | Fraction, points: int, call: Callable[[bytes], object]
    ) -> Watch:
        self._refuse()

    def signals(self, part: str, names: Sequence[str]) -> tuple[str, ...]:
        self._refuse()

    def in_time(self, now: AxisNow, what: str) -> AxisNow:
        """The axis as a plan begins with it, on a bench that may be faster than the axis."""
        if self._speed == 1:
            return now
        why = f"the bench goes at {self._speed:g} times the speed of its real {what}"
        return replace(now, why_not=why, remedy="write `speed: 1` in its configuration")

    def counters(self) -> Mapping[str, int]:
        return {}

    def listed(self, kinds: Mapping[str, str]) -> dict[str, Any]:
        return {"hardware": "real", "at": self._at}
