"""Real boards as axes of runs: a run's inputs are typed at their terminals.

The daemon knows what a board does only if it was the last to type at it. So a board is first taken in hand,
by the verb that its profile names (``enable``, ``reset``); when a program has typed at it, or it was away, or
a motion was cut short, that has to be done again. While a run has a board, programs' bytes for it wait.
"""

import asyncio
import logging
import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, cast

from hil.compose.find import load_terminal_axis
from hil.live.board_end import BoardEnd
from hil.live.configured import Configured
from hil.live.places import Places
from hil.runs import AxisNow, BenchAxes, Refused, Rows
from hil.sim.bench import BenchRuntime
from hil.sim.inputs import Do, Follow, Input
from hil.vocab.dialogue import Dialogue, DialogueError
from hil.vocab.terminal_axis import How, TerminalAxis, TerminalServo, TerminalStepper

log = logging.getLogger("hil")

LEAD_WALL_NS = 250_000_000
"""Time to tell a SAC its motion before a phrase: 20 ms at 38400 baud, and 32 ms of a USB adapter."""
SETPOINT_RATE_HZ = 50.0
"""Default rate of set-points: a menu answers within a few milliseconds."""
BUSY = ("motion_state", "pending", "following")
COMMANDED = ("r", "commanded_deg")
STOP_S = 2.0
"""Maximum time for a board to stop in when the daemon ends."""


class _Board:
    """Real board, and what the daemon knows of it."""

    def __init__(self, through: BoardEnd, axis: TerminalAxis, period_ns: int) -> None:
        self.through = through
        self.axis = axis
        self.period_ns = period_ns
        self.failure: str | None = None
        """Failure in the present run."""
        self._known_as: tuple[int, int] | None = None
        self._task: asyncio.Task[None] | None = None

    def _line(self) -> tuple[int, int]:
        return self.through.typed_bytes, self.through.line.stats().connects

    @property
    def away(self) -> str | None:
        stats = self.through.line.stats()
        return None if stats.clients else f"{self.through.line.address} is away"

    @property
    def is_known(self) -> bool:
        return self._known_as == self._line() and self.axis.commanded_deg is not None

    @property
    def is_busy(self) -> bool:
        return self._task is not None and not self._task.done()

    async def take(self) -> None:
        self._known_as = None
        await self.through.talk(self.axis.take())
        self._known_as = self._line()

    def forget(self) -> None:
        self._known_as = None

    def why_not(self) -> str | None:
        """Reason why it cannot be an axis now, or None."""
        if self.away:
            return f"it is a real board, and {self.away}"
        if not self.is_known:
            name = self.through.name
            return f"what this real board does is not known; `hil axis {name} {self.axis.taken_by}` first"
        return None

    def why_failed(self) -> str | None:
        if why := self.failure or self.away:
            return why
        if self.through.is_held and self._known_as != self._line():
            return "it was away, and is back"
        return None

    def begin(self, dialogue: Dialogue[None]) -> None:
        """Begin a dialogue after those that were begun before."""
        self._task = asyncio.get_running_loop().create_task(self._carry_out(dialogue, self._task))

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        """Break off what the board does, and stop it."""
        if self._task:
            self._task.cancel()
        if not self.away:
            self.begin(self.axis.stop(how, acceleration_rpm_per_s))

    async def _carry_out(self, dialogue: Dialogue[None], before: "asyncio.Task[None] | None") -> None:
        if before:
            await asyncio.wait([before])
        try:
            await self.through.talk(dialogue)
        except DialogueError as error:
            self.failure = self.failure or str(error)
        except Exception as error:  # ours: that axis stops its run, the others live on
            self.failure = f"an error of hil, see its log: {error!r}"
            log.exception("%s: a dialogue of a run", self.through.name)

    def hold(self) -> None:
        self.failure = None
        self.through.hold_clients(True)

    def release(self) -> None:
        """Release the board when it stands."""
        if self._task and not self._task.done():
            self._task.add_done_callback(lambda _: self.release())
        else:
            self.through.hold_clients(False)

    async def end(self) -> None:
        """End what a run had begun, as the daemon ends."""
        if self.through.is_held or self.is_busy:
            self.stop("grace", 600.0)
        if self._task:
            with suppress(TimeoutError):
                async with asyncio.timeout(STOP_S):
                    await asyncio.shield(self._task)


class RealAxes:
    """Real boards as ``hil.runs.RunBench``. ``bench``: the bench whose time they go by."""

    def __init__(self, places: Places, configured: Configured, bench: BenchRuntime) -> None:
        self._places = places.boards
        self._configured = configured
        self._bench = bench
        self._boards: dict[str, _Board] = {}
        """Boards that were asked for, by name."""

    def __contains__(self, name: str) -> bool:
        return name in self._places

    def _board(self, name: str) -> _Board | None:
        """Board of a name, renewed when the name is another's, as after a reload. None: no use for runs."""
        through, config = self._places[name].end, self._configured.config.devices[name]
        board = self._boards.get(name)
        if board is not None and board.through is through:
            return board
        if (make := load_terminal_axis(config.profile)) is None:
            return None
        rate_Hz = config.setpoint_rate_Hz or SETPOINT_RATE_HZ
        board = self._boards[name] = _Board(through, make(), round(1e9 / rate_Hz))
        return board

    async def carry_out(self, name: str, verb: str, dialogue: Dialogue[Any]) -> None:
        """Carry out a verb of a board that no run has; the verb that takes it in hand does so.

        Raises:
            DialogueError: it is away, or does not answer as it should.
        """
        board = self._board(name)
        if board and verb == board.axis.taken_by:
            await board.take()
            return
        if board:
            board.forget()
        await self._places[name].end.talk(dialogue)

    async def close(self) -> None:
        """Stop what still moves."""
        await asyncio.gather(*(board.end() for board in self._boards.values()))

    def axes(self) -> dict[str, AxisNow]:
        """All real boards, as a plan begins with them."""
        return {name: self._axis(name) for name in self._places}

    def _axis(self, name: str) -> AxisNow:
        board = self._board(name)
        if board is None:
            why = (
                f"a real {self._configured.config.devices[name].profile} has nothing for runs at its terminal"
            )
            return AxisNow("stepper", 0.0, (), (), why, is_real=True)
        why_not = board.why_not()
        if (speed := self._configured.config.speed) != 1:
            why_not = f"the bench goes at {speed:g} times the speed of its real boards"
        return AxisNow(board.axis.kind, board.axis.commanded_deg or 0.0, (), (), why_not, is_real=True)

    # ---- RunBench ----

    @property
    def now_ns(self) -> int:
        return self._bench.now_ns

    def give(self, axis: str, given: Input, refused: Refused) -> None:
        board = self._boards[axis]
        if isinstance(given, Follow):
            servo = cast(TerminalServo, board.axis)
            board.begin(servo.follow(given.path, self._wall_ns(given.start_ns), board.period_ns))
            return
        assert isinstance(given, Do), given
        parameters: dict[str, Any] = dict(given.parameters)
        if given.verb == "stop":
            board.stop(parameters["how"], parameters.get("acceleration_rpm_per_s", 0.0))
            return
        assert given.verb == "move_abs", given
        stepper = cast(TerminalStepper, board.axis)
        at_ns = self.now_ns if given.at_ns is None else given.at_ns
        board.begin(stepper.move_abs(**parameters, start_ns=self._wall_ns(at_ns)))

    def _wall_ns(self, sim_ns: int) -> int:
        """Time on the clock of dialogues; the bench's speed is 1."""
        return round(asyncio.get_running_loop().time() * 1e9) + sim_ns - self.now_ns

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        return [self._field(self._boards[axis], name) for name in names]

    @staticmethod
    def _field(board: "_Board", name: str) -> float:
        if name in BUSY:
            return float(board.is_busy)
        if name in COMMANDED and board.axis.commanded_deg is not None:
            return board.axis.commanded_deg
        return math.nan

    def failure(self, axis: str) -> str | None:
        return self._boards[axis].why_failed()

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        """Begin a run: the board is its own until the rows are closed."""
        self._boards[axis].hold()
        return _NoRows(self._boards[axis])


class _NoRows:
    def __init__(self, board: _Board) -> None:
        self._board = board

    def take(self) -> Sequence[tuple[float, ...]]:
        return ()

    def close(self) -> None:
        self._board.release()


class AllAxes:
    """All axes of a bench, twins and real boards, as ``hil.runs.RunBench``."""

    def __init__(self, twins: BenchAxes, real: RealAxes) -> None:
        self._twins = twins
        self._real = real

    def _of(self, axis: str) -> BenchAxes | RealAxes:
        return self._real if axis in self._real else self._twins

    def axes(self) -> dict[str, AxisNow]:
        return self._twins.axes() | self._real.axes()

    @property
    def now_ns(self) -> int:
        return self._twins.now_ns

    def give(self, axis: str, given: Input, refused: Refused) -> None:
        self._of(axis).give(axis, given, refused)

    def fields(self, axis: str, names: Sequence[str]) -> Sequence[float]:
        return self._of(axis).fields(axis, names)

    def failure(self, axis: str) -> str | None:
        return self._of(axis).failure(axis)

    def sample(self, axis: str, signals: tuple[str, str], interval_ns: int) -> Rows:
        return self._of(axis).sample(axis, signals, interval_ns)
