"""Faults that are asked for."""

from collections.abc import Mapping
from typing import Any

from hil.live.fault_registry import FaultRegistry
from hil.operations.desk import Answerer, Asked
from hil.vocab.faults import FaultRefused
from hil.vocab.verbs import VerbRefused


class FaultOperations:
    """Of one bench."""

    def __init__(self, registry: FaultRegistry) -> None:
        self._registry = registry

    def answers(self) -> Mapping[str, Answerer]:
        return {"inject": self.inject, "clear": self.clear, "faults": self.listed}

    def inject(self, asked: Asked, fault: str, parameters: Mapping[str, object]) -> dict[str, int]:
        """The new fault's number."""
        try:
            return {"number": self._registry.inject(fault, asked.target, parameters)}
        except FaultRefused as error:
            raise VerbRefused("bad_parameter", str(error)) from None

    def clear(self, asked: Asked, number: float | str, on: str) -> dict[str, list[int]]:
        """The numbers of those that are gone. Those on ``m1`` are those on its ports too, and none of
        ``m10``."""
        there = [
            row["number"]
            for row in self._registry.listed()
            if not on or f"{row['target']}.".startswith(f"{on}.")
        ]
        chosen = there if number == "all" else [each for each in there if each == number]
        if number != "all" and not chosen:
            listed = ", ".join(map(str, there)) or "none"
            raise VerbRefused(
                "bad_parameter", f"there is no fault {number}{on and f' on {on}'}; there are: {listed}"
            )
        for each in chosen:
            self._registry.clear(each)
        return {"cleared": chosen}

    def listed(self, asked: Asked) -> list[dict[str, Any]]:
        """All that are active."""
        return self._registry.listed()
