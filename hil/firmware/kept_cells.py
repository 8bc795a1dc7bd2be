"""Cells of a board that it keeps: what was written to it, what of that is stored, and ramps to new values."""

import json
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from hil.vocab.drive_words import CELL, STORED, cells_of
from hil.vocab.firmware import Commit
from hil.vocab.verbs import VerbRefused

SECTION = "cells"
"""Name of what is stored in the board's non-volatile memory."""


class _Ramp(NamedTuple):
    begin: float
    end: float
    from_ns: int
    duration_ns: int


class KeptCells:
    """Cells by name. A board tells each as ``cell.NAME``, and what is stored as ``stored.NAME``.

    Its owner calls ``step`` now and then, and yields the ``Commit`` that it answers.
    """

    def __init__(self, nvm: Mapping[str, bytes], tell: Callable[[str, float | None], None]) -> None:
        self._tell = tell
        self._stored: dict[str, float] = _stored_in(nvm.get(SECTION, b""))
        self._cells = dict(self._stored)
        self._ramps: dict[str, _Ramp] = {}
        self._is_due = False

    def tell_all(self) -> None:
        """Tell what was stored, as after power-up."""
        for name, value in self._stored.items():
            self._tell(STORED + name, value)
            self._tell(CELL + name, value)

    def take_text(self, text: str, now_ns: int = 0, over_ns: int = 0) -> None:
        """Take cells from a text (``hil.vocab.drive_words.cells_text``). ``over_ns``: duration of a ramp from
        what they have. Raises VerbRefused."""
        try:
            given = cells_of(text)
        except ValueError as error:
            raise VerbRefused("bad_parameter", f"cells: {error}") from None
        for name, value in given.items():
            self._ramps.pop(name, None)
            if over_ns and name in self._cells:
                self._ramps[name] = _Ramp(self._cells[name], value, now_ns, over_ns)
            else:
                self._put(name, value)

    def store(self, names: Iterable[str]) -> None:
        """Store these cells as they are; those that were never written have their defaults."""
        self._stored |= {name: self._cells[name] for name in names if name in self._cells}
        for name in self._stored:
            self._tell(STORED + name, self._stored[name])
        self._is_due = True

    def step(self, now_ns: int) -> Commit | None:
        """Go on with ramps; answers what is to be stored, if something is."""
        for name, ramp in list(self._ramps.items()):
            part = min((now_ns - ramp.from_ns) / ramp.duration_ns, 1.0)
            self._put(name, ramp.end if part >= 1 else ramp.begin + part * (ramp.end - ramp.begin))
            if part >= 1:
                del self._ramps[name]
        if not self._is_due:
            return None
        self._is_due = False
        return Commit(SECTION, json.dumps(self._stored, sort_keys=True).encode())

    def _put(self, name: str, value: float) -> None:
        self._cells[name] = value
        self._tell(CELL + name, value)


def _stored_in(data: bytes) -> dict[str, float]:
    """Cells that are stored; none where the memory has no such content."""
    try:
        known = json.loads(data or b"{}")
    except ValueError:
        return {}
    if not isinstance(known, dict):
        return {}
    return {
        str(name): value
        for name, value in known.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }
