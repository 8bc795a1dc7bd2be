"""One run of a test at a seed: what its benches are made with, and which faults they are without."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from hil.testing.seeds.bench_chance import FaultKey, run_seed
from hil.testing.seeds.seed_options import WHOLE, Shard

PARAMETER = "hil_seed"
"""Parameter, and fixture, that has a run's seed."""
_SEED_OF_ID = re.compile(r"(?s)(.*)([\[-])seed-(\d+)\]")


class AskedFault(NamedTuple):
    """Fault that a test asks for: the number of its bench, from 1, and which one it is there."""

    bench: int
    key: FaultKey

    def __str__(self) -> str:
        kind, target, number = self.key
        again = f", no. {number}" if number > 1 else ""
        return f"{kind} at {target}{again}" + (f" of bench {self.bench}" if self.bench > 1 else "")


@dataclass
class SeedRun:
    """Run of one test at one seed."""

    seed: int
    window_ms: float
    left_out: frozenset[AskedFault] = frozenset()
    asked: list[AskedFault] = field(default_factory=list)
    """Faults that were asked for so far, with those left out."""
    is_again: bool = False
    """True for runs in search of the smallest set of faults."""
    _benches: int = 0

    def begin(self, left_out: frozenset[AskedFault]) -> None:
        """Begin again, without some faults."""
        self.is_again, self.left_out, self._benches = True, left_out, 0
        self.asked.clear()

    def options(self, seed: int) -> dict[str, Any]:
        """Options of the next bench, for which the test says ``seed``."""
        self._benches += 1
        return {
            "seed": run_seed(seed, self.seed),
            "arrival_window_ms": self.window_ms,
            "leaves_out": self._leaves_out(self._benches),
        }

    def _leaves_out(self, bench: int) -> Callable[[FaultKey], bool]:
        def leaves_out(key: FaultKey) -> bool:
            fault = AskedFault(bench, key)
            self.asked.append(fault)
            return fault in self.left_out

        return leaves_out


@dataclass(frozen=True)
class SeedSettings:
    """Settings of seeds from the command line. ``seeds``: None without them."""

    seeds: range | None = None
    window_ms: float = 0.0
    shard: Shard = WHOLE
    results: Path | None = None
    farm: str = ""


SETTINGS = pytest.StashKey[SeedSettings]()
RUN = pytest.StashKey[SeedRun]()


def run_of(item: pytest.Item, seed: int) -> SeedRun:
    """Run that an item is in; it begins with the first who asks."""
    if RUN not in item.stash:
        settings = item.config.stash.get(SETTINGS, SeedSettings())
        item.stash[RUN] = SeedRun(seed, settings.window_ms)
    return item.stash[RUN]


def is_again(item: pytest.Item) -> bool:
    """True while an item runs in search of the smallest set of faults."""
    return RUN in item.stash and item.stash[RUN].is_again


def parts_of(node_id: str) -> tuple[str, int | None]:
    """Test and seed of a node id; None: it has no seed."""
    found = _SEED_OF_ID.fullmatch(node_id)
    if not found:
        return node_id, None
    return found[1] + ("]" if found[2] == "-" else ""), int(found[3])
