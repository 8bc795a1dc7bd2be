"""Figures of a step response."""

from dataclasses import dataclass
from itertools import pairwise

from hil.telemetry.recording import Recording

BAND = 0.02
"""Settling band, relative to the step: within it for good is settled. 2 % is usual in control engineering."""

_TYPED = 0.01
"""Resolution of a typed set-point: two digits after the point."""
_HELD = 2**-22
"""Relative resolution of a set-point: a board holds it in 32 bits of floating point."""


@dataclass(frozen=True)
class StepResponse:
    """Target and amplitude in the signals' unit; times from the step of the set-point, None: never."""

    at_ns: float
    target: float
    amplitude: float
    rise_ms: float | None
    """Time from 10 % to 90 % of the step."""
    overshoot_pct: float
    settling_ms: float | None
    """Time until the value stays within 2 % of the step."""
    final_error: float
    """Mean of the last tenth, less the target."""

    def line(self, unit: str) -> str:
        rise = "never" if self.rise_ms is None else f"{self.rise_ms:.2f} ms"
        settling = "never" if self.settling_ms is None else f"{self.settling_ms:.2f} ms"
        return (
            f"step of {self.amplitude:.2f} {unit}: rise {rise} (10 to 90 %), "
            f"overshoot {self.overshoot_pct:.1f} %, settled after {settling} (2 %), "
            f"final error {self.final_error:+.3f} {unit}"
        )


def step_response(recording: Recording, setpoint: str = "r", value: str = "yw") -> StepResponse:
    """Compute the figures of the last step of the set-point in a recording.

    Raises:
        ValueError: the set-point does not step, or not between the first and the last sample.
    """
    times, wanted, seen = (
        [row[0] for row in recording.rows],
        recording.column(setpoint),
        recording.column(value),
    )
    steps = [i for i in range(1, len(wanted)) if wanted[i] != wanted[i - 1]]
    if not steps or steps[-1] > len(times) - 10:
        raise ValueError(f"no step of {setpoint} in the recording")
    at = steps[-1]
    start, target = seen[at - 1], wanted[at]
    amplitude = target - start
    if amplitude == 0:
        raise ValueError(f"{value} is where {setpoint} steps to already")
    share = [(y - start) / amplitude for y in seen[at:]]
    after = [(t - times[at]) * 1e-6 for t in times[at:]]
    tail = seen[-max(1, len(share) // 10) :]
    return StepResponse(
        at_ns=times[at],
        target=target,
        amplitude=amplitude,
        rise_ms=_rise(share, after),
        overshoot_pct=100 * max(0.0, max(share) - 1),
        settling_ms=_settling(share, after),
        final_error=sum(tail) / len(tail) - target,
    )


def other_motion(recording: Recording, asked: float, setpoint: str = "r") -> str | None:
    """Description of what the set-point did in a recording other than the one step by ``asked``, or None."""
    wanted = recording.column(setpoint)
    steps = [(before, after) for before, after in pairwise(wanted) if before != after]
    if len(steps) > 1:
        return f"{setpoint} changed {len(steps)} times: another motion is under way"
    for before, after in steps:
        if abs(after - before - asked) > _TYPED + _HELD * max(abs(before), abs(after)):
            return (
                f"{setpoint} stepped by {after - before:.2f} instead of {asked:.2f}: something else moves it"
            )
    return None


def _rise(share: list[float], after: list[float]) -> float | None:
    low = next((t for y, t in zip(share, after, strict=True) if y >= 0.1), None)
    high = next((t for y, t in zip(share, after, strict=True) if y >= 0.9), None)
    return None if low is None or high is None else high - low


def _settling(share: list[float], after: list[float]) -> float | None:
    outside = [i for i, y in enumerate(share) if abs(y - 1) > BAND]
    if not outside:
        return 0.0
    return after[outside[-1] + 1] if outside[-1] + 1 < len(after) else None
