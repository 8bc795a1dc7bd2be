"""Profile of a kind of board: ``PROFILE`` in its folder's ``board.py``, all that hil asks of its Python.

The numbers of the board, its motor and its encoder are in the ``profile.yaml`` beside it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any

from hil.vocab.axis_plan import AxisPlan
from hil.vocab.dialogue import Dialogue, Task, TextReader
from hil.vocab.firmware import MAIN, Board, Firmware
from hil.vocab.framing import Framing
from hil.vocab.late_dataclass import dataclass
from hil.vocab.line_node import LineNodes
from hil.vocab.path_planning import PathPlanner
from hil.vocab.recorded_session import SessionPlan
from hil.vocab.terminal_axis import TerminalAxis
from hil.vocab.verbs import Verb, table_of

AskBench = Callable[..., Any]
"""Asks the bench that a command means for an operation, with arguments by name, and answers its answer. Where
that fails it says why, and ends the command."""


@dataclass(frozen=True, kw_only=True)
class UartSpec:
    """Serial interface of a board. Its speed is in ``profile.yaml``, under the same name."""

    about: str
    """Description of what speaks there, as in "terminal"."""


@dataclass(frozen=True, kw_only=True)
class AxisSpec:
    """Axis of a board with several. Its law and numbers are in ``profile.yaml``, under the same name."""

    about: str
    """Description of what the axis moves."""


@dataclass(frozen=True, kw_only=True)
class Commands:
    """Commands of a board for the command line, ``hil <profile> <command>``, at a twin or a real board."""

    about: str
    functions: tuple[Callable[..., Task], ...]
    """Functions with typer's annotations, named as their commands."""
    baud: int
    """Speed of a real board's port, unless ``--baud`` says another."""


@dataclass(frozen=True, kw_only=True)
class MemoryFile:
    """File that a configuration may have a board's memory begin with: ``flash: {table: FILE}``."""

    section: str
    """Section of the memory that it is put into."""
    most_bytes: int
    """Maximum length of a file."""
    read: Callable[[bytes], bytes]
    """Makes the section of a file's content. Raises ValueError: it cannot; says what the file is not."""
    named: Mapping[str, Callable[[], bytes]] = field(default_factory=dict)
    """Contents that need no file, by the names they have in a configuration."""


@dataclass(frozen=True, kw_only=True)
class Example:
    """Exchange with a board, which ``hil profile check`` tries."""

    types: bytes
    """Bytes that are typed."""
    answer: bytes
    """Bytes that have to be in what it sends from then on, an echo too."""
    within_ms: float = 1000.0
    """Time after which they have come, and the next example begins."""
    uart: str = ""
    """Name of its serial interface; empty: the first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Kind of board."""

    firmware: Callable[[Board], Firmware] | None = None
    """Maker of the board's program, one for each power-up; most often the program's class. None: the board
    does nothing, and closes no loop."""
    sketch: Callable[[str, str], Callable[[Board], Firmware]] | None = None
    """``sketch(file, text)`` makes the maker of its program with a user's sketch; None: it takes none."""
    uarts: Mapping[str, UartSpec] = field(default_factory=lambda: {MAIN: UartSpec(about="terminal")})
    """Serial interfaces by name; ``{}``: it has none."""
    axes: Mapping[str, AxisSpec] = field(default_factory=dict)
    """Axes of a board with several, by name, at most 16; empty: it has one, which needs no name, or none."""
    framing: Framing | None = None
    """Framing of the line that the board is on; None: it has no say in that."""
    line_nodes: LineNodes | None = None
    """Commands and answers between the master of that line and its nodes; None: hil has no master for it."""
    verbs: tuple[Verb, ...] = ()
    """Requests that a twin understands beside those of all boards."""
    starve: Callable[..., bool | None] | None = None
    """``starve(firmware, policy, acceleration_rpm_per_s)`` stops an axis on a set-point time-out; False:
    those were no stream, and nothing was stopped. None: it has no stream of them. On a board with several
    axes it, ``follow`` and each ``Verb.is_of_axis`` get ``axis``, the axis's name."""
    follow: Callable[..., None] | None = None
    """``follow(firmware, path, start_ns)`` lets an axis follow a path of set-points; None: it cannot."""
    dialogues: Mapping[str, Callable[..., Dialogue[Any]]] = field(default_factory=dict)
    """Dialogues with a real board over its terminal, by the verbs that they stand for; each is
    called with what its verb is given."""
    readers: Mapping[str, TextReader] = field(default_factory=dict)
    """Readers of what its terminal says, and of files of its own, by name: a page has such texts as data."""
    terminal_axis: Callable[[int], TerminalAxis] | None = None
    """Maker of what lets a real board be an axis of runs; None: nothing does."""
    paths: PathPlanner | None = None
    """Planning of paths whose pulses its boards make by themselves; None: they make none."""
    shown_first: tuple[str, ...] = ("at_ns", "position_deg", "velocity_rpm", "torque_Nm")
    """Fields of an axis that its short state has."""
    says: Callable[[AxisPlan], Sequence[str]] = lambda plan: ()
    """Says in lines what follows from the numbers of an axis, for `hil check`."""
    examples: tuple[Example, ...] = ()
    """Exchanges with it, one after the other from when it is ready on."""
    memory_file: MemoryFile | None = None
    """File that the board's memory may begin with; None: no file."""
    session: Callable[[Mapping[str, Any]], SessionPlan | None] | None = None
    """Reader of recorded sessions with it, for ``hil.testing.play``: None for one that is of something else;
    raises ``SessionRefused``. None: it reads none."""
    is_own_words: Callable[[str], bool] = lambda line: False
    """Tells whether a line of the twin's is explanation in the project's words: a real board prints other
    ones there."""
    commands: Callable[[], Commands] | None = None
    """Maker of the board's commands for the command line, which alone calls it; None: it has none."""

    @property
    def table(self) -> dict[str, Verb]:
        """Verbs of a twin by name, those of all boards with them."""
        return table_of(self.verbs)
