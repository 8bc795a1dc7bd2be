"""Benches that are joined: what one may ask of another, over whatever bridge joins them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from hil.vocab.bridges import Source


@dataclass(frozen=True)
class Answered:
    """An answer, and when the question left and it came, both in this bench's wall time."""

    content: Mapping[str, Any]
    asked_ns: int
    heard_ns: int


class BenchGone(Exception):
    """Another bench does not answer: ``str(error)`` says which and for how long."""


@runtime_checkable
class BenchDoor(Protocol):
    """A bridge that reaches other benches."""

    async def ask_bench(
        self, source: Source, bench: str, rest: str, given: Mapping[str, Any], timeout_s: float
    ) -> Answered:
        """A command below another bench's keys, for somebody.

        Raises:
            BenchGone: no answer in time.
            VerbRefused: it was not carried out there.
        """

    async def benches(self) -> Sequence[str]:
        """The others that are joined now."""
