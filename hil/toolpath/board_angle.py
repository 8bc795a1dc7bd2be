"""Angles of axes by their boards' zeros, where set-points are, and by the shafts', which `hil zero` moves."""

from collections.abc import Mapping
from typing import Any

from hil.core import KINDS


def board_signal(signals: Mapping[str, Any]) -> str:
    """Signal of an axis that tells where it stands by its board's zero: what a servo's encoder counts, or
    what the board of a stepper has commanded. Empty: the board has no zero of its own."""
    names = (name for kind in KINDS.values() for name in kind.board_angles[:1])
    return next((name for name in names if name in signals), "")


def zero_shift_deg(state: Mapping[str, Any]) -> float:
    """Board's angle less the shaft's, of the state of an axis that stands; 0 for a servo that is off, which
    counts no angle."""
    signal = board_signal(state)
    if not signal or not state.get("loop_on", 1) or state[signal] is None:
        return 0.0
    return float(state[signal] - state["position_deg"])
