"""States of axes as the status has them: a row for each form of a snapshot, with its words."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hil.vocab.axis import CONTROL_MODES

MOTION_STATES = ("standby", "accel", "cruise", "decel", "stop")
"""Names of the native core's states of a motion engine, by their numbers; its import would take long."""
CODED: dict[str, dict[str, int]] = {
    "motion_state": {word: code for code, word in enumerate(MOTION_STATES)},
    "mode": {word: ord(letter) for word, letter in CONTROL_MODES.items()}
    | {letter: ord(letter) for letter in CONTROL_MODES.values()},
}
"""Words that conditions take for the values of fields that are codes, as `hil status` shows them."""
_TWIN = {"position_deg": float, "velocity_rpm": float}

Shot = Mapping[str, Any]


def _commanded(shot: Shot) -> float | None:
    return shot.get("commanded_deg")


class ShownState(NamedTuple):
    """State of a kind of axis. ``form``: what a snapshot of it has, as ``hil.net.answers`` says it. ``word``:
    of the state. ``shaft_deg`` and ``board_deg``: angle of the shaft, and the one that its board counts."""

    form: dict[str, Any]
    word: Callable[[Shot], str]
    board_deg: Callable[[Shot], float | None] = _commanded
    shaft_deg: Callable[[Shot], float | None] = lambda shot: shot["position_deg"]


def _servo_word(shot: Shot) -> str:
    return (chr(int(shot["mode"])) if shot["mode"] else "-") + ("" if shot["loop_on"] else " off")


SHOWN_STATES = {
    "motion_state": ShownState(
        _TWIN | {"motion_state": (0, 1, 2, 3, 4)}, lambda shot: MOTION_STATES[int(shot["motion_state"])]
    ),
    "loop_on": ShownState(
        _TWIN | {"mode": (0, *range(32, 127)), "loop_on": int},
        _servo_word,
        lambda shot: shot.get("yw") if shot["loop_on"] else None,  # off, it counts no angle
    ),
    "to_be_deg": ShownState(
        _TWIN | {"to_be_deg": float, "is_enabled": (0, 1)},
        lambda shot: "on" if shot["is_enabled"] else "off",
        lambda shot: shot.get("measured_deg"),
    ),
    "outputs_on": ShownState(
        _TWIN | {"outputs_on": int, "microsteps": int},
        lambda shot: f"1/{shot['microsteps']}" if shot["outputs_on"] else "off",
    ),
    "enabled": ShownState(  # a real drive, which tells only its own angle, or none
        {"enabled": int, "age_ms": float},
        lambda shot: "real" if shot["enabled"] else "real off",
        lambda shot: shot.get("position_deg"),
        lambda shot: None,
    ),
}
"""States of axes by a field that only such axes have."""


def shown_state(shot: Shot) -> ShownState:
    """State of the axis that a snapshot is of."""
    return next(state for field, state in SHOWN_STATES.items() if field in shot)
