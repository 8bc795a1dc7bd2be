"""Bars of commands: how far something is that takes more than a second, on the standard error of a terminal.

    with bar("m1 calibrates", "s simulated", lambda: (now_s, 26)):
        ...

A thread shows it, so that the block may wait, calculate, or be told by somebody else how far it is. It is
there from a second after its beginning on, and gone when the block is over or ``fail`` says something.
"""

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

_SHORT_S = 1.0
"""Time that nobody is told of: up to it an answer seems to come at once."""
_REFRESH_S = 0.2
_END_S = 5.0
"""Maximum wait for a thread that takes the bar away: a terminal may take nothing."""

_MARGIN = 3
"""Columns for the terminal's ^C: behind a full line it would begin another, which nobody takes away."""
_BAR, _NARROW = 20, 60
"""Columns of the bar itself, and of a terminal that has room for one."""

Look = Callable[[], tuple[float, float] | None]
"""Answers how much is done and how much there is, 0: nobody knows; None: neither is known yet. Called from
another thread."""
_bars: list["_Bar"] = []


class ShownProgress:
    """Progress that the block tells. ``total`` 0: nobody knows how much there is."""

    def __init__(self) -> None:
        self.done = self.total = 0.0

    def tell(self, done: float, total: float) -> None:
        """Note how much is done, of how much."""
        self.done, self.total = done, total

    def look(self) -> tuple[float, float] | None:
        return (self.done, self.total) if self.total else None


@contextmanager
def bar(what: str, unit: str = "", look: Look | None = None) -> Iterator[ShownProgress]:
    """Show how far the block is: on a terminal, and not with --json. ``what``: as in ``m1 calibrates``;
    ``unit``: of what is counted, as in ``s simulated``; ``look``: asked for it, in place of what the block
    tells. If nobody says how far it is, the seconds are counted."""
    told = ShownProgress()
    if not _is_shown():
        yield told
        return
    shown = _Bar(what, unit, look or told.look)
    _bars.append(shown)
    try:
        yield told
    finally:
        end_bars()


def end_bars() -> None:
    """Take bars away: something else is said."""
    while _bars:
        _bars.pop().end()


def _is_shown() -> bool:
    from hil.cli.framework.command_answers import wants_json

    return sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb" and not wants_json()


def progress_words(
    what: str, unit: str, found: tuple[float, float] | None, after_s: float, columns: int = 80
) -> str:
    """Format what a bar is of, as in ``m1 calibrates: 12 of 26 s simulated``. ``after_s``: time since its
    beginning, for what nobody knows more of; ``columns``: room, for which the name is cut."""
    if found is None:
        how_far = f": {after_s:.0f} s"
    elif not found[1]:
        how_far = f": {found[0]:,.0f} {unit}".rstrip()
    else:
        done, total = found
        decimals = 0 if total >= 10 or float(total).is_integer() else 1
        how_far = f": {min(done, total):,.{decimals}f} of {total:,.{decimals}f} {unit}".rstrip()
    room = max(columns - len(how_far), 1)
    return (what if len(what) <= room else f"{what[: room - 1]}…") + how_far


class _Bar:
    def __init__(self, what: str, unit: str, look: Look) -> None:
        self._what, self._unit, self._look = what, unit, look
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._is_over.set()
        self._thread.join(_END_S)

    def _run(self) -> None:
        begun_s = time.monotonic()
        if self._is_over.wait(_SHORT_S):
            return
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as Shown
        from rich.table import Column

        from hil.cli.framework.consoles import ShownConsole

        width = max(shutil.get_terminal_size().columns - _MARGIN, 20)
        bars = [BarColumn(bar_width=_BAR)] if width >= _NARROW else []
        room = width - (_BAR + 1) * len(bars)
        with Shown(
            TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True)),
            *bars,
            console=ShownConsole(stderr=True, width=width),
            transient=True,
            auto_refresh=False,
            redirect_stdout=False,
            redirect_stderr=False,
        ) as shown:
            task = shown.add_task("", total=None)
            while True:
                found: Any = None
                with suppress(Exception):  # who is asked has gone, or is busy: the block says what is wrong
                    found = self._look()
                after_s = time.monotonic() - begun_s
                said = progress_words(self._what, self._unit, found, after_s, room)
                done, total = found or (0, 0)
                shown.update(task, description=said, completed=done, total=total or None, refresh=True)
                if self._is_over.wait(_REFRESH_S):
                    return
