"""Sketches of a user's own in Python: ``setup(board)`` and ``loop(board)`` as main program, and interrupts.

What waits is yielded, as in any firmware here. A wait that was made and not yielded would be none: it is an
error, with the line that made it.
"""

import sys
from collections.abc import Callable, Generator, Mapping
from types import CodeType
from typing import Any

from hil.vocab.firmware import Board, ByteAvailable, Delay, Main, Request
from hil.vocab.late_dataclass import dataclass
from hil.vocab.time import NS_PER_MS

LOW, HIGH = 0, 1
INPUT, OUTPUT, INPUT_PULLUP = "input", "output", "input_pullup"
TURN_NS = NS_PER_MS
"""Time of a turn of ``loop()`` that waits for nothing, unless the sketch has a ``LOOP_US``: chosen. A board's
takes some microseconds, and the simulation would have no time for anything else."""
LOOP_US = "LOOP_US"
_LEAST_US, _MOST_US = 0.001, 1e9
"""Limits of a turn: the simulation's step, and what is no turn any more."""

Waiting = Generator[Request, Any, Any]
Hook = Callable[[Any], Waiting | None]


class SketchMistake(Exception):
    """Mistake in a sketch: ``str(error)`` says what is right. ``place``: its file and line, where it is known
    better than by the calls."""

    def __init__(self, message: str, place: str = "") -> None:
        super().__init__(message)
        self.place = place


@dataclass(frozen=True)
class SketchProgram:
    """Compiled sketch. ``name``: its file's, for messages."""

    name: str
    code: CodeType

    def hooks(self) -> Mapping[str, Any]:
        """Run the module, as a power-up initialises all variables, and answer its names."""
        names: dict[str, Any] = {"__name__": "sketch", "__file__": self.name}
        exec(self.code, names)
        return names


def caller(depth: int = 2) -> str:
    """Answer the file and line of the call so many calls above this one."""
    calls = sys._getframe(depth)
    return f"{calls.f_code.co_filename.rpartition('/')[2]}:{calls.f_lineno}"


class SketchWaits:
    """Waits that a sketch makes by its board's calls, and has to yield."""

    def __init__(self) -> None:
        self._made: Delay | Waiting | None = None
        self._words = self._place = ""

    def delay(self, duration_ns: int, words: str) -> Delay:
        """Make a wait. ``words``: how the sketch writes the call, for who forgets to yield it."""
        made = Delay(max(0, duration_ns))
        self._keep(made, f"yield {words}")
        return made

    def steps(self, made: Waiting, words: str) -> Waiting:
        """Take a call that waits several times."""
        self._keep(made, f"yield from {words}")
        return made

    def _keep(self, made: Delay | Waiting, words: str) -> None:
        self.check()
        self._made, self._words, self._place = made, words, caller(4)

    def taken(self, request: Request) -> None:
        """Note what is yielded."""
        if request is self._made:
            self._made = None

    def check(self) -> None:
        """Check that what was made before is waited for. Raises SketchMistake."""
        made, self._made = self._made, None
        if made is None or (isinstance(made, Generator) and not _is_new(made)):
            return
        raise SketchMistake(f'nothing waits here: write "{self._words}"', self._place)


def _is_new(made: Waiting) -> bool:
    from inspect import GEN_CREATED, getgeneratorstate  # who forgets nothing does not wait for it

    return getgeneratorstate(made) == GEN_CREATED


def main(
    board: Board,
    face: object,
    waits: SketchWaits,
    hooks: Mapping[str, Any],
    start: Callable[[], Waiting],
    ready: Callable[[], None],
) -> Main:
    """Run a sketch forever. ``face``: what its functions are called with; ``start``: setup() of one that has
    none; ``ready``: called once setup() has ended."""
    setup, loop = hooks.get("setup"), hooks["loop"]
    turn_ns = _turn_ns(hooks)
    yield from call(setup, face, waits) if setup else start()
    ready()
    while True:
        begun_ns = board.now_ns
        yield from call(loop, face, waits)
        if board.now_ns != begun_ns:
            continue
        if board.uarts and not board.uart.available():
            yield ByteAvailable(timeout_ns=turn_ns)
        else:
            yield Delay(turn_ns)


def _turn_ns(hooks: Mapping[str, Any]) -> int:
    """Time of a turn of ``loop()``. Raises SketchMistake: the sketch has one that there is not."""
    us = hooks.get(LOOP_US, TURN_NS / 1000)
    if isinstance(us, int | float) and _LEAST_US <= us <= _MOST_US:
        return round(us * 1000)
    message = f"{LOOP_US} is the time of a turn in us, above 0, and not {us!r}: write {LOOP_US} = 100"
    raise SketchMistake(message, str(hooks["__file__"]).rpartition("/")[2])


def call(hook: Hook, face: object, waits: SketchWaits) -> Waiting:
    """Call a function of the sketch, and wait for what it waits for."""
    made = hook(face)
    answer: Any = None
    while isinstance(made, Generator):
        try:
            request = made.send(answer)
        except StopIteration:
            break
        if not isinstance(request, Request):
            frame = made.gi_frame
            place = f"{frame.f_code.co_filename.rpartition('/')[2]}:{frame.f_lineno}" if frame else ""
            raise SketchMistake(
                f'{request!r} is nothing that can be waited for: write "yield board.delay(1)"', place
            )
        waits.taken(request)
        answer = yield request
    waits.check()


def interrupt(hook: Hook, face: object, name: str) -> None:
    """Call an interrupt's hook. Raises SketchMistake: it waits."""
    if hook(face) is not None:
        raise SketchMistake(f"{name}() waits or answers something: an interrupt does neither")
