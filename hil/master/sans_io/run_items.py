"""Items of a run over a line, and what is told of it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple, Protocol

from hil.vocab.path_planning import NodeCommand


class LineOfFile(Protocol):
    """Place in a program."""

    @property
    def line(self) -> int: ...


class CommandOfFile(Protocol):
    """Command of a phrase, and the place in the program that it is of."""

    @property
    def command(self) -> NodeCommand: ...
    @property
    def place(self) -> LineOfFile: ...


class RunPhrase(Protocol):
    """Commands from a rest to a rest, made as they are taken, in the order in which they are to be sent.

    The first command of each axis waits for the release. ``ahead``: commands of each axis that have to be at
    its board before the release. The axes stand at ``begin`` before it and at ``end`` after it, in pulses.
    """

    @property
    def commands(self) -> Iterator[CommandOfFile]: ...
    @property
    def ahead(self) -> int: ...
    @property
    def duration_s(self) -> float: ...
    @property
    def begin(self) -> Mapping[str, int]: ...
    @property
    def end(self) -> Mapping[str, int]: ...
    @property
    def place(self) -> LineOfFile: ...

    def brake(self) -> bool:
        """Brake along the path, by what has not been taken yet: ``duration_s`` and ``end`` change, and the
        items behind it go on from there. False: it cannot, or is as soon at its end."""


@dataclass(frozen=True)
class RunDwell:
    """Pause of a given length."""

    seconds: float
    line: int = 0


@dataclass(frozen=True)
class RunSwitch:
    """Switch: commands for nodes, each of which has to be done before the next; ``name`` for people."""

    name: str
    commands: Sequence[tuple[int, bytes]] = ()
    line: int = 0


@dataclass(frozen=True)
class RunPause:
    """Stop of the program until somebody resumes it."""

    line: int = 0


RunItem = RunPhrase | RunDwell | RunSwitch | RunPause


class RunState(StrEnum):
    """State of a run over a line."""

    READY = "ready"
    RUNNING = "running"
    PAUSED = "paused"
    STOPPING = "stopping"
    ENDED = "ended"
    STOPPED = "stopped"
    FAILED = "failed"

    @property
    def is_over(self) -> bool:
        return self in (RunState.ENDED, RunState.STOPPED, RunState.FAILED)


class AxisEnd(NamedTuple):
    """Position of an axis of a run: ``pulses`` from the machine's zero, if that is known. ``why``: why it is
    not, or how it is known; ``about_pulses``: where it was by the plan when it was stopped."""

    axis: str
    node: int
    pulses: int | None
    why: str
    about_pulses: int | None = None

    @property
    def is_known(self) -> bool:
        return self.pulses is not None


class RunProgress(NamedTuple):
    """Progress of a run. ``done_s``: of the planned time; ``line``: of the program, 0: none yet."""

    state: RunState
    done_s: float
    line: int


@dataclass(frozen=True)
class RunReport:
    """End of a run: its state, why it did not come to its end, and where each axis is. ``late``: commands
    that came after their time; ``packets``: that went out."""

    state: RunState
    why: str
    line: int
    took_s: float
    packets: int
    axes: Sequence[AxisEnd] = field(default_factory=tuple)
