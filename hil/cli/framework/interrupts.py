"""Early ends of commands: SIGINT and SIGTERM act as Ctrl-C, also where they were inherited as ignored.

A shell without job control starts ``hil capture ... &`` with SIGINT ignored, and Python leaves it so.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM)
came: list[int] = []
"""Signals that came. A loop that waits looks here, too: Python swallows an exception in a destructor."""
_PATIENCE_S = 1


def end_by_signals() -> None:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt in the main thread."""
    for number in ENDING:
        signal.signal(number, _interrupt)


@contextmanager
def noted() -> Iterator[list[int]]:
    """Collect signals in the list that the block is given, for a command that has to end in order."""
    numbers: list[int] = []
    with _handled(numbers.append):
        yield numbers


@contextmanager
def ended_by(end: Callable[[], None]) -> Iterator[None]:
    """Call ``end`` on a signal, which makes the block end; KeyboardInterrupt if it has not a second later."""

    def begin_to_end(number: int) -> None:
        end()
        signal.alarm(_PATIENCE_S)

    before = signal.signal(signal.SIGALRM, _interrupt)
    try:
        with _handled(begin_to_end):
            yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def _handled(take: Callable[[int], None]) -> Iterator[None]:
    before = [signal.signal(number, lambda number, _: take(number)) for number in ENDING]
    try:
        yield
    finally:
        for number, handler in zip(ENDING, before, strict=True):
            signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    came.append(number)
    raise KeyboardInterrupt
