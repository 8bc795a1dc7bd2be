"""Reading of a real drive."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Reading:
    """Answer of a drive to a request that was sent at ``at_ns``, simulated time. ``values`` are by the names
    of a map, set-point and parameters included; ``bits`` by dotted names, as in ``status.moving``; ``words``:
    what stood in the answer, as its bus has it."""

    at_ns: int
    values: Mapping[str, float] = field(default_factory=dict)
    bits: Mapping[str, bool] = field(default_factory=dict)
    words: Mapping[Any, Mapping[int, int]] = field(default_factory=dict)
