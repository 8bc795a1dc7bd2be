"""Pulses of a move: what the manual's interrupt does to OCR2A, step by step.

A count of n is n ticks of 8 us, as the manual has it. (A timer with n in OCR2A takes n + 1; hil's sketch
writes one less.)
"""

from collections.abc import Iterator, Sequence
from itertools import groupby

from device_profiles.uno.constants import TICK_US, TimerRamp
from hil.vocab.firmware import Pulses

HIGH_NS = 6_000
"""Time for which STEP is high: that of a digitalWrite, 6 to 9 us by the manual."""


def pulses_of(steps: int, ramp: TimerRamp) -> list[Pulses]:
    """Pulses of a move of so many steps, at least 1: the speed grows over the ramp, stays, and falls again.

    A move of at most ``ramp.during`` steps does not slow down at its end. One shorter than both ramps
    slows down from where it has come to, and may so go past 255, where the register begins again at 0.
    """
    return _joined(_runs(steps, ramp))


def _runs(left: int, ramp: TimerRamp) -> Iterator[tuple[int, int]]:
    """Numbers of steps, each with the counts before it."""
    counts, up, down = ramp.first, ramp.during, ramp.during
    while left > 0:
        if left == down:
            yield 1, counts
            down -= 1
            counts = (counts + ramp.delta) % 256
        elif up > 0:
            yield 1, counts
            up -= 1
            counts = (counts - ramp.delta) % 256
        else:
            run = left - down if left > down else left
            yield run, counts
            left -= run
            continue
        left -= 1


def _joined(runs: Iterator[tuple[int, int]]) -> list[Pulses]:
    """Rows of pulses, those of the same counts in one; a count of 0 is one of 256."""
    rows = []
    for counts, same in groupby(runs, key=lambda run: run[1]):
        period_ns = (counts or 256) * TICK_US * 1000
        rows.append(Pulses(sum(steps for steps, _ in same), period_ns, HIGH_NS))
    return rows


def duration_ns(rows: Sequence[Pulses]) -> int:
    """Time from the beginning of a move to its last pulse."""
    return sum(row.number * row.period_ns for row in rows)


def paused(rows: Sequence[Pulses], pause_ns: int) -> list[Pulses]:
    """Delay the first pulse."""
    first = rows[0]
    later = Pulses(1, first.period_ns + pause_ns, first.high_ns)
    return [later, first._replace(number=first.number - 1), *rows[1:]]
