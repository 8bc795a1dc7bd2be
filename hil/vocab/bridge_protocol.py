"""What a bridge has to be: ``Bridge``, and ``BenchDoor`` if it reaches other benches too."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from hil.vocab.desk_protocol import Source


class Bridge(Protocol):
    """One door."""

    async def open(self) -> None:
        """Begin. Raises BridgeError."""

    async def close(self) -> None:
        """End, and leave nothing behind."""

    async def devices_changed(self, names: Collection[str]) -> None:
        """These devices of the host were added, taken away or exchanged, with their ports. Raises
        BridgeError."""

    def status(self) -> Mapping[str, Any]:
        """What ``hil status`` shows of it: ``root``, ``listen``, ``connect``, ``links``, ``insecure``,
        where that is not all ``risk`` (what whoever reaches it may do), and counters."""


class BridgeError(Exception):
    """A bridge cannot be opened: ``str(error)`` says why and what to do."""


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
