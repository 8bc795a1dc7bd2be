"""Screens of a SAC as its companion reads them: the listing, the configuration, the session, the speed.

Source: SAC user manual, queue, configure; ``q``, ``cc``, ``cf`` and ``vd`` at the prompt.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

from device_profiles.sac.companion_files import ROWS, Row
from hil.vocab.dialogue import DialogueError

_WHOLE = r"(\d{1,10})"
STEPS_PER_REV = rf"a sprf\s+{_WHOLE}\b"
INTERRUPT_OVERHEAD_US = rf"H ihd\s+{_WHOLE}\b"
CLOCK_CORRECTION_US = rf"I xclk\s+{_WHOLE}\b"
MICROSTEP_EXPONENT = rf"J ustep\s+{_WHOLE}\b"
SLOW_RPM = rf"L slow\s+{_WHOLE}\b"
DEVICE_ID = rf"M d_id\s+{_WHOLE}\b"
SOFT_OPS = r"soft_ops\s+(\d)"
_DECIMAL = r"(\d{1,10}\.?\d{0,10})"
_ROW = re.compile(
    rf"{_WHOLE}\t{_WHOLE}\t([ +])(CW|CCW)\t{_WHOLE}\t{_WHOLE}"
    rf"\t([ *]){_DECIMAL}\t{_DECIMAL}\t{_WHOLE}\t(s?) +{_WHOLE}"
)
_PLACE = re.compile(rf"Q is at {_WHOLE}\b")
_SPEED = re.compile(rf"{_WHOLE}\t{_WHOLE}")


def number_on(screen: str, pattern: str) -> int:
    """Read a number of ``cc`` or ``cf``.

    Raises:
        DialogueError: the screen has none.
    """
    if not (match := re.search(pattern, screen)):
        raise DialogueError(f"this is not a SAC's screen: {screen[:80]!r}")
    return int(match[1])


class Listing(NamedTuple):
    """Listing of a queue. ``at``: the running row, or else where the next command goes; 0: not told."""

    rows: list[Row]
    at: int


def read_listing(lines: Sequence[str]) -> Listing:
    """Read the lines of ``q``.

    Raises:
        DialogueError: they are not all rows of a queue.
    """
    rows: list[Row] = []
    at = 0
    for line in lines:
        if place := _PLACE.match(line):
            at = int(place[1])
        # Debug lists the continuous command too, as row 0.
        elif (match := _ROW.fullmatch(line)) and (row := _row(match)).position:
            if row.position != len(rows) + 1:
                raise DialogueError(f"row {len(rows) + 1} is missing in the listing")
            rows.append(row)
    if len(rows) != ROWS:
        raise DialogueError(f"the listing has {len(rows)} rows that can be read, not {ROWS}")
    return Listing(rows, at)


def _row(match: re.Match[str]) -> Row:
    position, steps, pulses, direction, rpm, cycle_us, ramp, acc, dec, extra, sync, wait_us = match.groups()
    return Row(
        position=int(position),
        steps=int(steps),
        is_ccw=int(direction == "CCW"),
        is_full=int(pulses == " "),
        rpm=int(rpm),
        cycle_us=int(cycle_us),
        is_linear=int(ramp == "*"),
        acc_hundredths=round(float(acc) * 100),
        dec_hundredths=round(float(dec) * 100),
        extra_pulses=int(extra),
        is_sync=int(sync == "s"),
        wait_us=int(wait_us),
    )


class Speed(NamedTuple):
    """Speed of now; 0 and 0: the motor stands."""

    rpm: int
    period_us: int


def read_speed(lines: Sequence[str]) -> Speed | None:
    """Read the lines of ``vd``; None: they tell none."""
    match = _SPEED.fullmatch(lines[0]) if lines else None
    return Speed(int(match[1]), int(match[2])) if match else None
