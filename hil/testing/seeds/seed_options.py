"""Options of many seeds, as a command line has them."""

import re
from typing import NamedTuple

from hil.testing.seeds.late_arrivals import MOST_MS

MOST_SEEDS = 1_000_000
"""Maximum number of seeds of one run; each is an item of pytest, of some kilobytes."""
_UNITS_MS = {"us": 1e-3, "ms": 1.0, "s": 1e3}


class Shard(NamedTuple):
    """Part ``number`` of ``of``, from 1."""

    number: int
    of: int

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


WHOLE = Shard(1, 1)


def seeds_given(text: str) -> range:
    """Seeds of ``1000`` (0 to 999) or of ``2000..2999``. Raises ValueError."""
    found = re.fullmatch(r"(\d+)(?:\.\.(\d+))?", text)
    if not found:
        raise ValueError(f"seeds are a number of them, as 1000, or from..to, as 2000..2999; not {text!r}")
    first, last = (0, int(found[1]) - 1) if found[2] is None else (int(found[1]), int(found[2]))
    if last < first:
        raise ValueError(f"{text!r} has no seeds; at least one is needed")
    if last >= 1 << 32 or last - first >= MOST_SEEDS:
        raise ValueError(f"{text!r}: a run has at most {MOST_SEEDS} seeds, each below 2**32")
    return range(first, last + 1)


def one_seed(text: str) -> range:
    """Seed of ``17`` alone. Raises ValueError."""
    if not text.isdecimal() or not text.isascii():
        raise ValueError(f"a seed is a whole number, as 17; not {text!r}")
    return seeds_given(f"{text}..{text}")


def shard_given(text: str) -> Shard:
    """Shard of ``3/40``. Raises ValueError."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if not found:
        raise ValueError(f"a shard is its number and how many there are, as 3/40; not {text!r}")
    shard = Shard(int(found[1]), int(found[2]))
    if not 1 <= shard.number <= shard.of:
        names = f"1/{shard.of} to {shard.of}/{shard.of}" if shard.of else "at least 1/1"
        raise ValueError(f"there is no shard {text}: they are {names}")
    return shard


def window_given(text: str) -> float:
    """Milliseconds of ``2ms``, ``500us`` or ``0.1s``. Raises ValueError."""
    found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(us|ms|s)", text)
    if not found:
        raise ValueError(f"a window of arrival is a time with its unit, as 2ms, 500us or 0.1s; not {text!r}")
    window_ms = float(found[1]) * _UNITS_MS[found[2]]
    if window_ms > MOST_MS:
        raise ValueError(f"a window of arrival is at most {MOST_MS // 1000} s, not {text}")
    return window_ms
