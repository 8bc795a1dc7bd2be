"""Real board as an axis of runs, by dialogues of its profile over its terminal alone.

``Profile.terminal_axis`` makes one of these, a ``TerminalServo`` or a ``TerminalStepper``, from the maximum
delay of the line beside that of a cable, there and back, in ns: it waits so much longer for answers. Times
are those of the clock that answers ``Listen``.
"""

from typing import ClassVar, Literal, Protocol

from hil.vocab.axis import How
from hil.vocab.dialogue import Dialogue
from hil.vocab.path import Path


class TerminalAxis(Protocol):
    """Axis of one real board. Its dialogues are carried out one after the other; each may be broken off
    between two of its steps."""

    kind: ClassVar[Literal["servo", "stepper"]]
    taken_by: ClassVar[str]
    """The verb that ``acquire`` stands for."""
    commanded_deg: float | None
    """Set-point as the board confirmed it; None: unknown."""

    def acquire(self) -> Dialogue[None]:
        """Make the board ready for motion, at rest, and learn where it is."""

    def stop(self, how: How, acceleration_rpm_per_s: float) -> Dialogue[None]:
        """End all motion; the dialogue ends when the board stands."""


class TerminalServo(TerminalAxis, Protocol):
    """A board whose set-point can be typed."""

    def follow(self, path: Path, start_ns: int, period_ns: int) -> Dialogue[None]:
        """Type the set-points of a path, one each ``period_ns`` and the last exactly.

        Raises:
            DialogueError: one was not confirmed.
        """


class TerminalStepper(TerminalAxis, Protocol):
    """A board that makes ramps of its own."""

    def move_abs(self, position_deg: float, velocity_rpm: float, start_ns: int) -> Dialogue[None]:
        """Begin a motion at a time; ends when the board stands.

        Raises:
            DialogueError: it did not take its command before the start, or does not come to its end.
        """
