"""Planning of paths for boards that make the pulses of their motions themselves, as a SAC does.

A machine's planner (``hil.toolpath``) knows millimetres, limits and corners; a board's planner
(``Profile.paths``) knows which commands make its motor keep to that. Between them are pulses and
microseconds. Nothing moves here, and no clock is read: a plan is data, which the master of a line sends.

A *phrase* begins and ends at rest. The first command of each of its axes is held; one broadcast
(``PathPlanner.release``) starts all of them, and from then on each axis goes by its own clock.
"""

from collections.abc import Mapping, Sequence
from typing import Protocol

from hil.vocab.late_dataclass import dataclass


@dataclass(frozen=True)
class StepperAxis:
    """Axis as its board is set up."""

    steps_per_rev: int = 200
    microstep_exponent: int = 1
    """Number J: a full step is 2**J pulses."""
    slow_rpm: int = 10
    """Speed up to which the board makes no ramp."""

    @property
    def pulses_per_step(self) -> int:
        return 1 << self.microstep_exponent


@dataclass(frozen=True)
class AxisMotion:
    """Share of an axis in a straight line from rest to rest. Speed and acceleration are the most that it
    may have here; all axes of a line are slowed down alike."""

    axis: StepperAxis
    pulses: int
    """Signed, positive clockwise; never 0."""
    speed_per_s: float
    """In pulses a second."""
    acceleration_per_s2: float


@dataclass(frozen=True)
class NodeCommand:
    """Command for the board of one axis."""

    axis: str
    data: bytes
    """Command as the board reads it, without the frame of a packet."""
    pulses: int
    """Signed pulses that it makes."""
    start_us: float
    """Time of its first pulse after the release."""
    end_us: float
    """Time after the release that is one period after its last pulse."""
    needed_us: float
    """Time after the release at which the command has to be at its board: the end of the one before; 0 for
    the first, which has to be there before the release."""


@dataclass(frozen=True)
class NodePhrase:
    """Commands from a rest to a rest, in the order in which they are to be sent: by ``needed_us``."""

    commands: Sequence[NodeCommand]
    duration_us: float
    """Time from the release until the last axis stands."""


class PhrasePlan(Protocol):
    """Phrase made piece by piece, while earlier pieces move already."""

    def add(self, duration_us: float, pulses: Mapping[str, int]) -> Sequence[NodeCommand]:
        """Add a piece in which each axis has one speed: its signed pulses; an axis left out, or with 0,
        rests. Answers the commands that it makes; an axis that comes from rest waits by its own clock.

        Time errors are corrected in the next piece: an axis is never more than half a microsecond a full
        step of one piece away.
        """

    @property
    def at_us(self) -> float:
        """Time from the release to the end of the last piece."""

    def again_from(self, at_us: float, last: Mapping[str, NodeCommand]) -> "PhrasePlan":
        """Plan other pieces from a time on, in place of those that no board has yet. ``last``: the last
        command of each axis that a board has or will get."""


class PathPlanner(Protocol):
    """Planner of a kind of board's commands."""

    @property
    def release(self) -> bytes:
        """Data that, sent to all, starts a phrase."""

    @property
    def queue_length(self) -> int:
        """Number of commands that may wait at a board; it drops the next one silently."""

    def line_characters(self, data_bytes: int) -> int:
        """Character times for which a command of so many bytes occupies the line: its packet, the
        turnaround, the answer."""

    def line(self, moves: Mapping[str, AxisMotion]) -> NodePhrase:
        """Plan a straight line from rest to rest that all axes keep to, at the speed and the acceleration
        that their limits allow: the ramps are in the ratio of the ways.

        Raises:
            ValueError: a move has no pulses, or a speed or acceleration that is not above 0.
        """

    def stream(self, axes: Mapping[str, StepperAxis]) -> PhrasePlan:
        """Begin a phrase of pieces of constant speed, without ramps and without gaps."""
