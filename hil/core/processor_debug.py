"""Hold of a debugger on a bank's processor, and counts of where its time goes."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from hil.core._native import NativeCore

MOST_FUNCTIONS = 512
"""Maximum number of functions whose time is counted."""
WORD_BYTES = 2


class FunctionCount(NamedTuple):
    """Cycles that the instructions of a function took, and how often its first one was carried out."""

    cycles: int
    calls: int


class ProcessorDebug:
    """Debugging of a processor. While there are breakpoints, a step or counts, it runs an instruction at a
    time: with the same result, more slowly. The group is owned."""

    def __init__(self, native: NativeCore, axis: int) -> None:
        self._native, self._axis = native, axis
        self._breakpoints = frozenset[int]()

    @property
    def is_halted(self) -> bool:
        """True while it stands for a debugger."""
        return self._native.processor_is_halted(self._axis)

    def halt(self) -> None:
        """Let it stand, now; an instruction that is under way is still to be carried out."""
        self._native.processor_halt(self._axis)

    def go(self, breakpoints: Collection[int], *, is_step: bool) -> None:
        """Let it go on. It stands again, with an event ``halted``, before the instruction at one of these
        byte addresses, except the next one; ``is_step``: after that one."""
        wanted = frozenset(breakpoints)
        for address in wanted ^ self._breakpoints:
            self._native.processor_break(self._axis, address, address in wanted)
        self._breakpoints = wanted
        self._native.processor_go(self._axis, is_step)

    def jump(self, address: int) -> None:
        """Let it go on at another byte address."""
        self._native.processor_jump(self._axis, address)

    @property
    def stack_lowest(self) -> int:
        """Lowest address at which a byte was put on the stack since the reset."""
        return self._native.processor_stack_lowest(self._axis)

    # ---- counts ----

    def count(self, starts: Sequence[int], lap_at: int | None = None) -> None:
        """Count from now on: cycles in functions, by the byte addresses of their first instructions,
        ascending; and cycles from one time at an instruction to the next. Nothing: end."""
        words = [start // WORD_BYTES for start in starts[:MOST_FUNCTIONS]]
        self._native.processor_count(self._axis, words, -1 if lap_at is None else lap_at // WORD_BYTES)

    def counted(self) -> tuple[int, list[FunctionCount]]:
        """Cycles since ``count``, and those of each function."""
        cycles, rows = self._native.processor_counted(self._axis)
        return cycles, [FunctionCount(*row) for row in rows]

    @property
    def laps(self) -> list[int]:
        """Cycles from one time at the instruction to the next, the latest 1,024."""
        return self._native.processor_laps(self._axis)
