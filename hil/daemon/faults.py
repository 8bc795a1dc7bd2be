"""The faults that are active in a daemon: injected under numbers, listed, cleared."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from hil.config.explain import suggestion
from hil.session.pass_through import PassThrough
from hil.vocab.faults import FAULT_KINDS, Fault, fault_of


class FaultRefused(Exception):
    """A fault cannot be: ``str(error)`` says why."""


class FaultRegistry:
    """``real``: the boards that byte faults can be on, by name."""

    def __init__(self, real: Mapping[str, PassThrough]) -> None:
        self._real = real
        self._active: dict[int, Fault] = {}
        self._next = 1

    def inject(self, kind: str, target: str, parameters: Mapping[str, object]) -> int:
        """Put a fault there; its number.

        Raises:
            FaultRefused: there is no such kind or place, or a parameter does not do.
        """
        if kind not in FAULT_KINDS:
            raise FaultRefused(f"there is no fault {kind!r}; {suggestion(kind, FAULT_KINDS)}")
        fault, problems = fault_of(kind, target, parameters)
        if fault is None:
            raise FaultRefused("; ".join(f"{name}: {problem}" for name, problem in problems.items()))
        if target not in self._real:
            known = ", ".join(self._real) or "none"
            raise FaultRefused(f"{target} is no real board; there are: {known}")
        number, self._next = self._next, self._next + 1
        self._real[target].inject(number, fault)
        self._active[number] = fault
        return number

    def clear(self, number: int) -> None:
        """Take a fault away.

        Raises:
            FaultRefused: there is none of this number.
        """
        fault = self._active.pop(number, None)
        if fault is None:
            active = ", ".join(map(str, self._active)) or "none"
            raise FaultRefused(f"there is no fault {number}; there are: {active}")
        self._real[fault.target].clear(number)

    def listed(self) -> list[dict[str, Any]]:
        """All that are active, with how many bytes each has changed."""
        return [
            {
                "number": number,
                **asdict(fault),
                "changed_bytes": self._real[fault.target].changed_bytes(number),
            }
            for number, fault in self._active.items()
        ]
