"""Chance of a bench: seeds of its faults and axes, all drawn from one."""

import hashlib
import random
from collections import Counter
from collections.abc import Callable, Mapping

from hil.config import BenchConfig
from hil.sim.given_fault import fault_refusal
from hil.vocab.faults import FAULT_KINDS, Fault

FaultKey = tuple[str, str, int]
"""Kind, target, and which one of these two in a bench, from 1: the same in each run of a test."""
SEED_BITS = 53
"""Bits of a fault's seed: a number in any language's JSON."""
SEED = "seed"


def run_seed(own: int, of_run: int) -> int:
    """Seed of a bench for which the test says ``own``, in a run with a seed of ``--hil-seeds``. Where one of
    them is 0 it is the other, so that ``Bench(config, 17)`` is what seed 17 was."""
    return own + (of_run << 32) if own and of_run else own or of_run


def drawn_seed(seed: int, *parts: object) -> int:
    """Draw a seed for a thing that ``parts`` name, the same in each process and on each computer."""
    words = repr((seed, *parts)).encode()
    return int.from_bytes(hashlib.sha256(words).digest()[:8]) >> (64 - SEED_BITS)


class BenchChance:
    """Chance of one bench. With seed 0 all things have the seeds that they are given, as a daemon's have;
    with another, each fault and the axes have seeds of their own, so that one that is left out changes
    nothing for the others. ``leaves_out``: True for faults that are not to be there."""

    def __init__(self, seed: int, leaves_out: Callable[[FaultKey], bool] = lambda key: False) -> None:
        self.seed = seed
        self.random = random.Random(seed)
        """Numbers for the test itself."""
        self._leaves_out = leaves_out
        self._count = Counter[tuple[str, str]]()

    def stream(self, what: str) -> random.Random:
        """Stream of numbers of its own for a thing."""
        return random.Random(drawn_seed(self.seed, what))

    def config(self, config: BenchConfig) -> BenchConfig:
        """Configuration with the seed of its axes."""
        if not self.seed:
            return config
        return config.model_copy(update={SEED: drawn_seed(self.seed, "axes", config.seed)})

    def fault(self, kind: str, target: str, given: Mapping[str, float | str]) -> tuple[Fault, bool]:
        """Make a fault with its seed; the second is True if it is left out.

        Raises:
            FaultRefused: there is no such kind, or a parameter does not do.
        """
        fault = fault_refusal(kind, target, given)
        self._count[kind, target] += 1
        key = kind, target, self._count[kind, target]
        if self.seed and any(each.name == SEED for each in FAULT_KINDS[kind].parameters):
            seed = drawn_seed(self.seed, *key, int(fault.number(SEED)))
            fault = Fault(kind, target, dict(fault.parameters) | {SEED: seed})
        return fault, self._leaves_out(key)
