"""Real board as an axis of runs: what a run gives it is typed at its terminal.

The daemon knows what a board does only if it was the last to type at it. So it first takes control of the
board, by the verb that its profile names (``enable``, ``reset``). It loses control when a program types at
the board, when the board is away, or when a motion is cut short. While a run has a board, programs' bytes for
it wait.
"""

import asyncio
import logging
from collections.abc import Sequence
from typing import cast

from hil.live.board_backend import BoardBackend
from hil.sim.bench import BenchRuntime
from hil.vocab.axis import NOT_JOINED, AxisNow, AxisState, How, Sample
from hil.vocab.dialogue import Dialogue, DialogueError
from hil.vocab.path import Path
from hil.vocab.terminal_axis import TerminalAxis, TerminalServo, TerminalStepper
from hil.vocab.verbs import VerbRefused

log = logging.getLogger("hil")

STOP_S = 2.0
"""Maximum time for a board to stop in when the daemon ends."""
STOP_RPM_PER_S = 600.0
"""Ramp of that stop."""


class BoardAxis:
    """Axis of a real board, as ``hil.vocab.axis.Axis``. ``bench``: the bench whose time it goes by, at the
    speed 1; ``period_ns``: interval of set-points that are typed; ``lead_ns``: time before a phrase in which
    the board is told its motion."""

    refusal: str | None = None

    def __init__(
        self, bench: BenchRuntime, through: BoardBackend, terminal: TerminalAxis, period_ns: int, lead_ns: int
    ) -> None:
        self._bench = bench
        self.through = through
        self._terminal = terminal
        self._period_ns = period_ns
        self.lead_ns = lead_ns
        self._failure: str | None = None
        """Failure since ``hold``."""
        self._known_as: tuple[int, int] | None = None
        self._task: asyncio.Task[None] | None = None

    # ---- what is known of it ----

    def _line(self) -> tuple[int, int]:
        # A board that has been away may have been reset meanwhile.
        return self.through.typed_bytes, self.through.line.stats().connects

    @property
    def _away(self) -> str | None:
        stats = self.through.line.stats()
        return None if stats.clients else f"{self.through.line.address} is away"

    @property
    def _is_busy(self) -> bool:
        return self._task is not None and not self._task.done()

    @property
    def taken_by(self) -> str:
        """Verb by which the daemon takes control of the board."""
        return self._terminal.taken_by

    async def acquire(self) -> None:
        """Take control of the board. Raises DialogueError: it is away, or does not answer as it should."""
        self._known_as = None
        await self.through.talk(self._terminal.acquire())
        self._known_as = self._line()

    def forget(self) -> None:
        """Note that somebody else types at it: what it does is not known any more."""
        self._known_as = None

    def now(self) -> AxisNow:
        """The axis as a plan begins with it."""
        at_deg, follows_paths = self._terminal.commanded_deg or 0.0, self._terminal.kind == "servo"
        why_not, remedy = self._obstacle()
        return AxisNow(at_deg, follows_paths, why_not=why_not, remedy=remedy, tells_position=False)

    def _obstacle(self) -> tuple[str | None, str]:
        """Reason why the axis cannot take part, if there is one, and what helps."""
        if self._away:
            return f"it is a real board, and {self._away}", "connect it, or leave it out"
        if self._known_as != self._line() or self._terminal.commanded_deg is None:
            remedy = f"`hil axis {self.through.name} {self.taken_by}` first"
            return "what this real board does is not known", remedy
        return None, ""

    @property
    def failure(self) -> str | None:
        if why := self._failure or self._away:
            return why
        if self.through.is_held and self._known_as != self._line():
            return "it was away, and is back"
        return None

    def state(self) -> AxisState:
        is_busy = self._is_busy
        return AxisState(self._bench.now_ns, self._terminal.commanded_deg, None, is_busy, is_busy)

    def field(self, name: str) -> float:
        raise KeyError(f"a real board tells no {name}")

    def samples(self) -> Sequence[Sample]:
        return ()

    # ---- what a run does with it ----

    def hold(self) -> None:
        self._failure = None
        self.through.hold_clients(True)

    def release(self) -> None:
        if self._task and not self._task.done():
            # Programs' bytes would come in the middle of what is being typed.
            self._task.add_done_callback(lambda _: self.release())
        else:
            self.through.hold_clients(False)

    def follow(self, path: Path, start_ns: int) -> int:
        servo = cast(TerminalServo, self._terminal)
        self._begin(servo.follow(path, self._wall_ns(start_ns), self._period_ns))
        return max(start_ns, self._bench.now_ns)

    def join(self, path: Path, start_ns: int) -> None:
        raise VerbRefused("cannot", NOT_JOINED)

    def move(self, position_deg: float, velocity_rpm: float, start_ns: int) -> None:
        stepper = cast(TerminalStepper, self._terminal)
        self._begin(stepper.move_abs(position_deg, velocity_rpm, self._wall_ns(start_ns)))

    def stop(self, how: How, acceleration_rpm_per_s: float) -> None:
        """Break off what the board does, and stop it."""
        if self._task:
            self._task.cancel()
        if not self._away:
            self._begin(self._terminal.stop(how, acceleration_rpm_per_s))

    def set_pin(self, pin: str, level: int, at_ns: int) -> None:
        raise VerbRefused("cannot", "nobody but its wires drives the inputs of a real board")

    def _wall_ns(self, sim_ns: int) -> int:
        """Time on the clock of dialogues."""
        return round(asyncio.get_running_loop().time() * 1e9) + sim_ns - self._bench.now_ns

    def _begin(self, dialogue: Dialogue[None]) -> None:
        """Begin a dialogue after those that were begun before."""
        self._task = asyncio.get_running_loop().create_task(self._carry_out(dialogue, self._task))

    async def _carry_out(self, dialogue: Dialogue[None], before: "asyncio.Task[None] | None") -> None:
        if before:
            await asyncio.wait([before])
        try:
            await self.through.talk(dialogue)
        except DialogueError as error:
            self._failure = self._failure or str(error)
        except Exception as error:  # hil's own error: that axis stops its run, the others go on
            self._failure = f"an error of hil, see its log: {error!r}"
            log.exception("%s: a dialogue of a run", self.through.name)

    async def end(self) -> None:
        """End what a run had begun, as the daemon ends."""
        if self.through.is_held or self._is_busy:
            self.stop("grace", STOP_RPM_PER_S)
        if self._task:
            await asyncio.wait([self._task], timeout=STOP_S)
