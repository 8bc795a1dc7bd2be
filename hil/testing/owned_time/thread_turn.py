"""Turn of one thread of a program, with what it waits for, and what else there is to wait for."""

import os
import sys
import threading
from collections.abc import Callable
from typing import NamedTuple

import serial

import hil
from hil.testing.serial_ports.line_ends import LineEnd
from hil.vocab.time import FOREVER, SimTimeNs

_SERIAL = os.path.dirname(serial.__file__)
_allocate_lock = threading.Lock  # the real one: this module is imported before it is replaced
_HIL, _PYTHON = os.path.dirname(hil.__file__) + os.sep, os.path.dirname(os.__file__)


def is_hils(file: str) -> bool:
    """True for a file of hil."""
    return file.startswith(_HIL)


def is_pythons(file: str) -> bool:
    """True for a file of Python's library."""
    return file.startswith("<frozen") or (file.startswith(_PYTHON) and "-packages" not in file)


def _is_ours_or_pythons(file: str) -> bool:
    return file.startswith((_HIL, _SERIAL)) or is_pythons(file)


class Wait(NamedTuple):
    """Wait of a thread, for ``ready``, or ``until_ns``. ``what``: for people; ``end``: the line that it
    comes from; ``is_outside``: it comes from outside, at the wall's pace."""

    ready: Callable[[], bool]
    until_ns: int = FOREVER
    what: str = "its start"
    end: LineEnd | None = None
    is_outside: bool = False
    is_look: bool = False


class Turn:
    """A thread of the program, and what it waits for."""

    def __init__(self, name: str, number: int) -> None:
        self.name, self.number = name, number
        self.wait = Wait(lambda: True)
        self.is_over = False
        self.is_beside = False
        """True while it runs, or stands, beside the others."""
        self.wants_back = False
        self.steps = 0
        """Number of times that it has waited or looked."""
        self.identity = 0
        """Number that Python has for the thread."""
        self.gate = _allocate_lock()
        self.gate.acquire()

    def place(self) -> str:
        """File and line of the program where it is, for people."""
        frame = sys._current_frames().get(self.identity)
        while frame and _is_ours_or_pythons(frame.f_code.co_filename):
            frame = frame.f_back
        return f" at {frame.f_code.co_filename}:{frame.f_lineno}" if frame else ""

    def is_due(self, now_ns: int) -> bool:
        """True if it may go on."""
        if self.is_beside:
            return self.wants_back
        return now_ns >= self.wait.until_ns or self.wait.ready()


class Interrupts:
    """Interruptions of the main thread, by signals."""

    @property
    def due_ns(self) -> SimTimeNs:
        """Time of the next."""
        return FOREVER

    def run(self, now_ns: SimTimeNs) -> None:
        """Call the handlers that are due."""

    def ring_beside(self, now_ns: SimTimeNs) -> None:
        """Interrupt a main thread that does not wait."""


class Outside:
    """Sources of events beside the bench."""

    def is_there(self) -> bool:
        """True while time has to pass at the wall's pace."""
        return False

    def pass_on(self, now_ns: SimTimeNs) -> None:
        """Pass on what has come from outside, and what goes there."""
