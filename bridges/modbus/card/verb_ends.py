"""Ends of motions that requests began: each verb's bit says when its motion has ended."""

from collections.abc import Callable
from typing import NamedTuple

from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from hil.core import CoreAxis
from hil.sim.motion_end import BEGINS_NS, BegunMotion
from hil.sim.twin import Twin
from hil.vocab.time import Clock, SimTimeNs

LOOKS_NS = BEGINS_NS
"""Time between two looks at an axis with a motion, beside those of requests."""


class _Awaited(NamedTuple):
    wanted: Wanted
    motion: BegunMotion


class VerbEnds:
    """Motions of an axis that are awaited: of each verb the last. ``note``: told how each does."""

    def __init__(
        self, clock: Clock, device: Twin, axis: CoreAxis, note: Callable[[Wanted, VerbStage], None]
    ) -> None:
        self._clock, self._device, self._axis, self._note = clock, device, axis, note
        self._awaited: dict[int, _Awaited] = {}
        self._is_looking = False

    def follow(self, wanted: Wanted, number: int, motion: BegunMotion) -> None:
        """Note that the motion of a verb has begun, and later that it has ended."""
        self._note(wanted, VerbStage.BUSY)
        self._awaited.pop(number, None)
        self._awaited[number] = _Awaited(wanted, motion)
        if not self._is_looking:
            self._look_later()

    def drop(self, number: int) -> None:
        """Await a verb's motion no more."""
        self._awaited.pop(number, None)

    def clear(self) -> None:
        self._awaited.clear()

    def look(self, now_ns: int) -> None:
        """Note what has ended by now."""
        if not self._awaited:
            return
        state = self._axis.kind.motion(self._axis.snapshot())
        for number, (wanted, motion) in list(self._awaited.items()):
            is_short = motion.was_cut_short(self._device, self._axis, state, now_ns)
            if is_short is not None:
                del self._awaited[number]
                self._note(wanted, VerbStage.REFUSED if is_short else VerbStage.DONE)

    def _look_later(self) -> None:
        self._is_looking = True
        self._clock.at(self._clock.now_ns + LOOKS_NS, self._look_again)

    def _look_again(self, now_ns: SimTimeNs) -> None:
        self._is_looking = False
        self.look(now_ns)
        if self._awaited:
            self._look_later()
