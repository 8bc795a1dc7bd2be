"""Wire of a bench, whatever bus it is of: stations on it hear each other with its times."""

from collections.abc import Callable, Collection, Iterable
from typing import Any, Protocol

from hil.vocab.faults import Fault


class Wire(Protocol):
    """Wire with stations, each under its name. Its bus says how a station joins it, and how it sends.

    Only what happens in the time of its group calls these.
    """

    kind: str
    """Key of a configuration under which it stands."""
    watchers: list[Callable[[Any], None]]
    """Called with what has been on the wire to its end, in order, at that time of the wire's group."""

    def counters(self, elapsed_ns: int) -> dict[str, Any]:
        """Statistics since the start, for JSON."""

    def fault_targets(self, station: str) -> Collection[str]:
        """Targets of faults, keys of ``TARGETS``, that a station on it is; empty: that the wire is itself."""

    def fault_problem(self, fault: Fault, active: Iterable[Fault]) -> str | None:
        """Reason why a fault of the wire, or of a station on it, cannot be beside those that are listed."""

    def inject(self, number: int, fault: Fault, station: str) -> None:
        """Begin a fault of the wire, or of a station on it."""

    def clear(self, number: int, fault: Fault, station: str) -> None:
        """End a fault."""
