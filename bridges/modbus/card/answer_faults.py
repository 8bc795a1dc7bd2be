"""Faults of a Modbus node's answers, by their numbers."""

from collections.abc import Iterator

from hil.vocab.faults import MODBUS_NODE, Fault
from hil.vocab.time import NS_PER_MS
from hil.wire.byte_faults import Chance


class AnswerFaults:
    """Faults in force on a node's answers, the oldest first. Each draws its own chance, for each request."""

    target = MODBUS_NODE

    def __init__(self) -> None:
        self._faults: dict[int, tuple[Fault, Chance]] = {}

    @property
    def numbers(self) -> list[int]:
        """Numbers of the faults, the oldest first."""
        return list(self._faults)

    def begin(self, number: int, fault: Fault) -> None:
        self._faults[number] = fault, Chance(int(fault.number("seed")))

    def end(self, number: int) -> None:
        self._faults.pop(number, None)

    def exception(self) -> int | None:
        """Code of the exception that a request gets instead of being carried out, or None."""
        return self._last("modbus_exception", "code")

    def is_silent(self) -> bool:
        """True if there is no answer."""
        return any(list(self._struck("modbus_no_answer")))

    def late_ns(self) -> int:
        """Delay that the faults add to the answer."""
        late_ms = [fault.number("late_ms") for fault in self._struck("modbus_late")]
        return round(late_ms[-1] * NS_PER_MS) if late_ms else 0

    def unit(self, own: int) -> int:
        """Number of the unit in the answer."""
        unit = self._last("modbus_wrong_unit", "unit")
        if unit is None:
            return own
        return unit or own % 247 + 1

    def _last(self, kind: str, parameter: str) -> int | None:
        values = [int(fault.number(parameter)) for fault in self._struck(kind)]
        return values[-1] if values else None

    def _struck(self, kind: str) -> Iterator[Fault]:
        """Faults of a kind that strike this time. All of them draw."""
        for fault, chance in self._faults.values():
            if fault.kind == kind and chance.below(fault.number("rate")):
                yield fault
