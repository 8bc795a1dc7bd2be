"""Findings of a check."""

import gc
import os
from collections.abc import Iterable
from random import Random

SHOWN = 160
"""Maximum length of a value that is shown."""


class CheckFailed(AssertionError):
    """A check found something wrong: a line for each, which begins with the word for it."""

    def __init__(self, what: str, findings: Iterable[str]) -> None:
        self.findings = tuple(findings)
        super().__init__("\n  ".join((f"{what} does not pass its check:", *self.findings)))

    @property
    def words(self) -> set[str]:
        """The words that the findings begin with."""
        return {finding.partition(":")[0] for finding in self.findings}


def shown(value: object) -> str:
    """Show a value, cut where it is long."""
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}... ({len(text)} characters)"


def raised(error: BaseException) -> str:
    """Show an error."""
    return f"{type(error).__name__}: {error}"


def descriptors() -> int:
    """Number of open file descriptors, without those that only garbage holds."""
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


def cuts(data: bytes, random: Random) -> list[list[bytes]]:
    """Cut bytes in several ways: not at all, at each byte, in two anywhere, and in pieces of any size."""
    ways = [[data], [data[n : n + 1] for n in range(len(data))]]
    for _ in range(6):
        places = sorted(random.choices(range(len(data) + 1), k=random.choice((1, 1, 3, 8))))
        ways.append([data[a:b] for a, b in zip([0, *places], [*places, len(data)], strict=True) if a < b])
    return ways
