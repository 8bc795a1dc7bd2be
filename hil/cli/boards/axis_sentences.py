"""Sentences about what a verb of an axis has done, for people; programs read the answer itself."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hil.cli.framework.shown_words import counted, fixed, shown_number
from hil.vocab.typed_numbers import unit_in

_TIMES = ("effective_at_ns", "ends_after_ns", "set_point", "done", "interrupted")
"""Keys that each verb of a motion may answer; the others are of the verb alone."""


class VerbDone(NamedTuple):
    """Verb that was carried out. ``given``: values by parameters' names; ``about``: what it is for."""

    device: str
    verb: str
    given: Mapping[str, Any]
    answer: Mapping[str, Any]
    about: str = ""

    @property
    def goal(self) -> str:
        """Angle where it ends; empty: it is not known."""
        goal_deg = self.answer.get("set_point", self.given.get("position_deg"))
        return "" if goal_deg is None else f"{fixed(goal_deg, 2)} deg"

    @property
    def time(self) -> str:
        """Time that it takes; empty: it is not known."""
        takes_ns = self.answer.get("ends_after_ns")
        return "" if takes_ns is None else f"{_seconds(takes_ns / 1e9)} s"

    @property
    def there_in(self) -> str:
        if self.answer.get("ends_after_ns") == 0:
            return ", there at once"
        return f", there in {self.time}" if self.time else ""


def sentence(done: VerbDone) -> str:
    """Say in a sentence what a verb does, or has done after a wait for its end."""
    answer = done.answer
    if answer.get("interrupted"):
        to = f" to {done.goal}" if done.goal else ""
        return f"something else ended the motion of {done.device}{to}"
    if answer.get("done"):
        at = f" at {done.goal}" if done.goal else ""
        return f"{done.device} stands{at}{f' after {done.time}' if done.time else ''}"
    say = _SENTENCES.get(done.verb)
    return say(done) if say else _of_others(done)


def _seconds(time_s: float) -> str:
    return f"{time_s:.0f}" if time_s >= 10 else f"{time_s:.2f}" if time_s >= 0.1 else f"{time_s:.3f}"


def _moves_to(done: VerbDone) -> str:
    return f"{done.device} moves to {done.goal}{done.there_in}"


def _moves_by(done: VerbDone) -> str:
    by_deg = done.answer.get("angle_deg", done.given.get("angle_deg"))
    pulses = f" ({counted(done.answer['pulses'], 'pulse')})" if "pulses" in done.answer else ""
    to = f" to {done.goal}" if "set_point" in done.answer else ""
    return f"{done.device} moves by {fixed(by_deg, 2)} deg{pulses}{to}{done.there_in}"


def _position(done: VerbDone) -> str:
    return f"{done.device}: its set-point is {done.goal}"


def _velocity(done: VerbDone) -> str:
    speed_rpm = done.given["velocity_rpm"]
    if done.about.startswith("set-point"):
        return f"{done.device}: its set-point is {shown_number(speed_rpm)} rpm"
    return f"{done.device} {f'turns at {shown_number(speed_rpm)} rpm' if speed_rpm else 'stops with a ramp'}"


def _torque(done: VerbDone) -> str:
    ((name, value),) = done.given.items()
    return f"{done.device}: its set-point is {_value(name, value)}"


def _gains(done: VerbDone) -> str:
    return f"{done.device}: {_values(done)}"


def _enabled(done: VerbDone) -> str:
    said = f"{done.device}: its control loop is on"
    if remark := done.answer.get("remark"):
        return f"{said}; {remark}"
    return f"{said}, and holds the shaft at {done.goal}" if done.goal else said


def _stops(done: VerbDone) -> str:
    at = f" at {done.goal}" if done.goal else ""
    return f"{done.device} stops{at}{f', in {done.time}' if done.time else ''}"


def _calibrates(done: VerbDone) -> str:
    return f"{done.device} calibrates itself{f', which takes {done.time}' if done.time else ''}"


def _pulses(done: VerbDone) -> str:
    count = done.given.get("count")
    pulses = "pulses" if count is None else counted(count, "pulse")
    return f"{done.device} gets {pulses}{f', the last after {done.time}' if done.time else ''}"


def _zero(done: VerbDone) -> str:
    was_deg, board_deg = done.answer.get("was_deg"), done.answer.get("board_deg")
    said = f"{done.device}: the shaft's angle is 0 now; it was {fixed(was_deg, 2)} deg"
    if board_deg is None:
        return said
    counts = f"The board counts {fixed(board_deg, 2)} deg as before"
    return f"{said}\n{counts}; its set-points and move-abs go by that."


def _queue(done: VerbDone) -> str:
    given = done.given
    speed = f" at {shown_number(given['velocity_rpm'])} rpm" if "velocity_rpm" in given else ""
    return (
        f"{done.device}: entry {given['position']} of its queue is {counted(given['steps'], 'step')}{speed}"
    )


def _loop(done: VerbDone) -> str:
    passes = done.given.get("passes", 1)
    times = "until it is stopped" if not passes else "once" if passes == 1 else f"{passes} times"
    return f"{done.device} runs entries {done.given['first']} to {done.given['last']} of its queue {times}"


def _of_others(done: VerbDone) -> str:
    """Sentence about a verb of a board's own: its name, and what it answers with units."""
    values = _values(done)
    return f"{done.device}: {done.verb.replace('_', '-')}{f': {values}' if values else ' is done'}"


def _values(done: VerbDone) -> str:
    return ", ".join(f"{name} {_value(name, v)}" for name, v in done.answer.items() if name not in _TIMES)


def _value(name: str, value: object) -> str:
    """Value with the unit that its name ends in."""
    unit = {"LPF": "Hz"}.get(name[-3:]) or unit_in(name)
    number = isinstance(value, float | int) and not isinstance(value, bool)
    said = shown_number(value, is_short=True) if number and isinstance(value, float | int) else str(value)
    if unit == "count":
        unit = "count" if value == 1 else "counts"
    return f"{said} {unit}".rstrip() if number else said


_SENTENCES: dict[str, Callable[[VerbDone], str]] = {
    "move_abs": _moves_to,
    "move_to": _moves_to,
    "move_rel": _moves_by,
    "position": _position,
    "velocity": _velocity,
    "torque": _torque,
    "mode": lambda done: f"{done.device}: its set-point means {done.given['mode']} now",
    "gains": _gains,
    "enable": _enabled,
    "disable": lambda done: f"{done.device}: its control loop is off, without current",
    "clear_fault": lambda done: f"{done.device}: its fault is cleared; the control loop stays off",
    "calibrate": _calibrates,
    "stop": _stops,
    "pulses": _pulses,
    "pulse": lambda done: f"{done.device} gets 1 pulse {done.given.get('direction', 'cw')}",
    "queue": _queue,
    "run": lambda done: f"{done.device} runs entry {done.given['position']} of its queue",
    "loop": _loop,
    "sync": lambda done: f"{done.device}: what waited for the sync runs",
    "type": lambda done: f"{done.device}: typed",
    "reset": lambda done: f"{done.device}: off and on again",
    "pin": lambda done: f"{done.device}: {done.given['pin']} is {done.given['level']}",
    "zero": _zero,
    "origin": lambda done: f"{done.device}: its registers call this angle 0",
}
"""Sentences by verbs' names, of all kinds of boards; a board's verb that is not here is told in one form."""
