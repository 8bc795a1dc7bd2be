"""A series of samples: columns by signal, over simulated time."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hil.core import FIELDS, KINDS, AxisKind
from hil.vocab.near_words import meant


def check_signals(signals: Sequence[str], kind: AxisKind) -> tuple[str, ...]:
    """Check that signals are fields of a kind of axis; answers them.

    Raises:
        ValueError: there is no such field; says which are like it.
    """
    if not signals:
        raise ValueError("no signals; name at least one")
    for name in signals:
        if name not in kind.fields or name == "at_ns":
            known = [each for each in kind.fields if each != "at_ns"]
            raise ValueError(f"an axis of this kind has no signal {name!r}; {meant(name, known)}")
    return tuple(dict.fromkeys(signals))


_BOARD_ANGLES = {name for kind in KINDS.values() for name in kind.board_angles}
"""Angles by the zero of a board; `hil zero` moves that of the shaft's, ``position_deg``."""
_SETPOINT_UNITS = {ord("v"): "rpm", ord("t"): ""}
"""Units of a closed loop's set-point and its error by its mode where they are no angles: a velocity, and
counts of effort."""


def units_in(state: Mapping[str, Any]) -> dict[str, str]:
    """Units that signals of an axis have in this state, where they are not those of ``FIELDS``."""
    unit = _SETPOINT_UNITS.get(int(state.get("mode") or 0)) if "r" in state else None
    return {} if unit is None else {name: unit for name in ("r", "e") if name in state}


@dataclass
class Recording:
    """Samples of one axis. ``rows``: (at_ns, one value for each signal), in time's order."""

    signals: tuple[str, ...]
    rows: list[tuple[float, ...]] = field(default_factory=list)
    lost: int = 0
    """Samples that nobody took in time."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units of signals that have another one now than usual: ``units_in``."""

    def at_s(self, origin_ns: float | None = None) -> list[float]:
        """Times in seconds from ``origin_ns``; None: from the first sample."""
        if origin_ns is None:
            origin_ns = self.rows[0][0] if self.rows else 0
        return [(row[0] - origin_ns) * 1e-9 for row in self.rows]

    def column(self, signal: str) -> list[float]:
        at = self.signals.index(signal) + 1
        return [row[at] for row in self.rows]

    def unit(self, signal: str) -> str:
        return self.units.get(signal, FIELDS[signal].unit)

    def label(self, signal: str) -> str:
        """Name of the signal with its unit."""
        unit = self.unit(signal)
        return f"{signal} [{unit}]" if unit else signal

    def panels(self) -> list[list[str]]:
        """Signals that share a panel of a picture: those of one unit, in order. The control error has its
        own: beside the angle it would be a straight line. So has the shaft's angle beside the board's, which
        has another zero."""
        groups: dict[tuple[str, str], list[str]] = {}
        for signal in self.signals:
            is_apart = signal == "e" or (signal == "position_deg" and bool(_BOARD_ANGLES & {*self.signals}))
            groups.setdefault((self.unit(signal), signal if is_apart else ""), []).append(signal)
        return list(groups.values())

    def csv(self) -> Iterable[str]:
        """Lines of CSV text, the header first."""
        yield ",".join(("at_ns", *self.signals)) + "\n"
        for row in self.rows:
            yield ",".join(repr(value) if isinstance(value, float) else str(value) for value in row) + "\n"
