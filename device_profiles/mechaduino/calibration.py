"""Calibration: the look-up table that ``c`` makes from readings at the full steps of a turn. Pure.

Source: firmware 0.1.5's behaviour, checked against tables that it wrote (float32 to the bit).
"""

from array import array
from collections.abc import Sequence

from device_profiles.mechaduino.encoder import AVERAGED
from hil.firmware.arduino import float32

COUNTS_PER_REV = 16384
_ROW_ANGLES = 64
"""Angles in a 256-byte row of the SAMD21's flash: what is written at once."""


def average(readings: Sequence[int]) -> int:
    """Mean of readings taken at one step, made whole across the encoder's zero."""
    total = 0
    last = readings[0]
    for raw in readings:
        if raw - last < -COUNTS_PER_REV // 2:
            raw += COUNTS_PER_REV
        elif raw - last > COUNTS_PER_REV // 2:
            raw -= COUNTS_PER_REV
        total += raw
        last = raw
    mean = int(total / AVERAGED)
    if mean > COUNTS_PER_REV:
        return mean - COUNTS_PER_REV
    return mean + COUNTS_PER_REV if mean < 0 else mean


def _ticks(means: Sequence[int], step: int) -> int:
    """Counts from a step to the next."""
    ticks = means[(step + 1) % len(means)] - means[step % len(means)]
    if ticks < -15000:
        return ticks + COUNTS_PER_REV
    return ticks - COUNTS_PER_REV if ticks > 15000 else ticks


def _zero_crossing(means: Sequence[int]) -> tuple[int, int]:
    """Step after which the encoder passes its zero, and the number of counts after it."""
    found = (0, 0)
    for step in range(len(means)):
        ticks = _ticks(means, step)
        start = means[step] if ticks > 1 else means[len(means) - 1 - step]
        counts = range(ticks) if ticks > 1 else range(-ticks, 0, -1) if ticks < 1 else range(0)
        for j in counts:
            if (start + j) % COUNTS_PER_REV == 0:
                found = (step, j)
    return found


def _angle(step_deg: float, step: int, part: int, ticks: int) -> float:
    """Angle of a count, in the firmware's float32 and int arithmetic, degrees."""
    fraction = float32(float32(step_deg * part) / ticks)
    thousandths = int(float32(1000 * float32(float32(step_deg * step) + fraction)))
    return 0.001 * (thousandths % 360000)


def angles(means: Sequence[int]) -> "array[float]":
    """Calibrated angle of each encoder count from 0 up, as many as the readings cover: 16,384 after a turn
    that went well, none when the encoder did not move, half or twice as many when the firmware is built for
    another motor. ``means``: of the full steps that it takes for a turn."""
    step_deg, steps = float32(360.0 / len(means)), len(means)
    first, first_count = _zero_crossing(means)
    out = array("f")
    for step in range(first, first + steps + 1):
        ticks = _ticks(means, step)
        low = first_count if step == first else 0
        high = first_count if step == first + steps else abs(ticks)
        if ticks > 1:
            out.extend(_angle(step_deg, step, j, ticks) for j in range(low, high))
        elif ticks < 1:
            out.extend(_angle(step_deg, step, ticks + j, ticks) for j in range(high, low, -1))
    return out


def written(old: bytes, new: "array[float]") -> bytes:
    """Write ``new`` over ``old``: whole rows only, nothing past the table's end."""
    whole = len(new) - len(new) % _ROW_ANGLES
    packed = new[: min(whole, COUNTS_PER_REV)].tobytes()
    return packed + old[len(packed) :]


def progress(new: "array[float]", address: int) -> str:
    """Text printed while rows are written from ``address``: dots, and the address at each 4,096 bytes."""
    text = []
    for row in range(len(new) // _ROW_ANGLES):
        at = address + 256 * row
        text.append(f"\r\n0x{at:X}" if at % 4096 == 0 else ".")
    return "".join(text)
