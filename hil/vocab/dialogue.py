"""A dialogue with a board over its terminal: a generator that says what to send and how long to listen.

It has no I/O and no clock. Its runner moves the bytes, over a real serial port or to a twin on the virtual
clock, and answers each ``Listen`` with what came.
"""

from collections.abc import Callable, Generator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from hil.vocab.late_dataclass import dataclass
from hil.vocab.time import SimTimeNs


@dataclass(frozen=True)
class Send:
    """Bytes to the board; answers None."""

    data: bytes


@dataclass(frozen=True)
class Listen:
    """Wait for bytes of the board, at most ``timeout_ns``; answers ``Heard``, with no data on a time-out."""

    timeout_ns: int


@dataclass(frozen=True)
class Heard:
    """Bytes of the board, none on a time-out, and the time (nanoseconds of the runner's clock)."""

    at_ns: SimTimeNs
    data: bytes


@dataclass(frozen=True)
class Progress:
    """Progress report: ``done`` of ``total`` steps, and a text about the last one; answers None."""

    done: int
    total: int
    about: str


Step = Send | Listen | Progress
Result = TypeVar("Result")
Dialogue = Generator[Step, Any, Result]


class DialogueError(Exception):
    """Error of a board that did not answer as it should, or whose port has gone: ``str(error)`` says at what
    step, and what of the work can be believed."""


class Refusal(Exception):
    """Refusal of a dialogue, which sent nothing: a line for each reason."""


class BoardRefusal(Refusal):
    """Refusal because of what the board is or does now: what was asked for is right as it is written."""


TextReader = Callable[[str, str], Mapping[str, Any]]
"""Reader of a text as data in JSON's types: called with the text and the name of its file. Raises
DialogueError or Refusal: it is no such text."""


@dataclass(frozen=True)
class Task:
    """Work that a profile's command wants done: a dialogue, and how to report its result."""

    dialogue: Dialogue[Any]
    report: Callable[[Any], str]
    after_interrupt: Callable[[], Dialogue[Any]] | None = None
    """Dialogue that leaves the board as it should be after Ctrl-C in the middle. A text that it answers is
    told in the place of what the broken one said."""
    file: Path | None = None
    """File for the result's ``content``, written before the report."""
    content: Callable[[Any], bytes] | None = None
