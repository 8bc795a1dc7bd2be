"""A series of samples: columns by signal, over simulated time."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hil.core import KINDS, AxisKind
from hil.core.fields import FIELDS, described
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
    """Units that signals of an axis have in this state, where they are not those of the table."""
    unit = _SETPOINT_UNITS.get(int(state.get("mode") or 0)) if "r" in state else None
    return {} if unit is None else {name: unit for name in ("r", "e") if name in state}


def own_units(kind: AxisKind, signals: Iterable[str]) -> dict[str, str]:
    """Units of those signals that are a board's own, which no table has."""
    return {name: kind.own_fields[name].unit for name in signals if name in kind.own_fields}


@dataclass
class Recording:
    """Samples of one axis. ``rows``: (at_ns, one value for each signal), in time's order."""

    signals: tuple[str, ...]
    rows: list[tuple[float, ...]] = field(default_factory=list)
    lost: int = 0
    """Samples that nobody took in time."""
    origin_ns: float | None = None
    """Time from which drawings count; None: the first sample's."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units of signals that have another one now than usual (``units_in``), or are no fields."""
    interval_ns: float | None = None
    """Time between samples; None: they come as they like."""
    points: int = 1
    """Above 1: rows are two for each interval, with the smallest and the largest value of each signal of so
    many looks, in the order in which they came."""

    @property
    def sampling(self) -> str:
        """Words for how the rows were made; empty where that is not known."""
        if self.interval_ns is None:
            return ""
        interval_ms = f"{float(self.interval_ns) / 1e6:.4g} ms"
        return f"min/max of each {interval_ms}" if self.points > 1 else f"a sample each {interval_ms}"

    def at_s(self, origin_ns: float | None = None) -> list[float]:
        """Times in seconds from ``origin_ns``; None: from the recording's."""
        if origin_ns is None:
            origin_ns = self.origin_ns
        if origin_ns is None:
            origin_ns = self.rows[0][0] if self.rows else 0
        return [(row[0] - origin_ns) * 1e-9 for row in self.rows]

    def column(self, signal: str) -> list[float]:
        at = self.signals.index(signal) + 1
        return [row[at] for row in self.rows]

    def unit(self, signal: str) -> str:
        return self.units[signal] if signal in self.units else described(signal).unit

    def label(self, signal: str) -> str:
        """Name of the signal with its unit."""
        unit = self.unit(signal)
        return f"{signal} [{unit}]" if unit else signal

    def meaning(self, signal: str) -> str:
        """Few words for what the signal is: those of the field's table, up to the first mark; none of what is
        no field."""
        is_field = signal in FIELDS or signal not in self.units
        return re.split(r"[:;,(]", described(signal).meaning)[0].strip() if is_field else ""

    def panels(self) -> list[list[str]]:
        """Signals that share a panel of a picture: those of one unit, in order. The control error has its
        own: beside the angle it would be a straight line. So has the shaft's angle beside the board's, which
        has another zero."""
        groups: dict[tuple[str, str], list[str]] = {}
        for signal in self.signals:
            is_apart = signal == "e" or (signal == "position_deg" and bool(_BOARD_ANGLES & {*self.signals}))
            groups.setdefault((self.unit(signal), signal if is_apart else ""), []).append(signal)
        return list(groups.values())

    def has(self, signal: str) -> bool:
        return signal in self.signals

    def csv(self) -> Iterable[str]:
        """Lines of CSV text, the header first. Extremes have a last column that says so."""
        is_extremes = self.points > 1
        yield ",".join(("at_ns", *self.signals, *["sampling"] * is_extremes)) + "\n"
        end = f",{self.sampling}\n" if is_extremes else "\n"
        for row in self.rows:
            yield ",".join(repr(value) if isinstance(value, float) else str(value) for value in row) + end


def shared_panels(recordings: Iterable[Recording]) -> list[list[str]]:
    """Signals that share a panel, of recordings that may have different ones: ``Recording.panels`` of the
    first, and what others have beside it."""
    panels: list[list[str]] = []
    for recording in recordings:
        known = {signal for panel in panels for signal in panel}
        for panel in recording.panels():
            if more := [signal for signal in panel if signal not in known]:
                of_unit = next((each for each in panels if {*each} & {*panel}), None)
                if of_unit is None:
                    panels.append(more)
                else:
                    of_unit += more
    return panels
