"""Dialogues with a real Mechaduino, over its menu.

A set-point is typed as ``r`` and a number; the line end ends the number, and is ignored as a command. The
board prints what it took, with two decimals. Its angle cannot be read while it holds: ``p`` stops the loop.
"""

import re
from typing import Any, ClassVar, Literal

from hil.firmware.listening import wait_until
from hil.firmware.set_point_paths import at, length_ns, to_rest
from hil.vocab.axis import How
from hil.vocab.dialogue import Dialogue, DialogueError, Heard, Listen, Send
from hil.vocab.path import DEG_PER_S, Path, PathPiece
from hil.vocab.time import NS_PER_MS, NS_PER_S

_NUMBER = rb"(-?\d+\.\d\d)\r\n"
_ENABLED = re.compile(rb"New setpoint " + _NUMBER)
_TAKEN = re.compile(rb"Enter setpoint:\r\n" + _NUMBER)
BOOT_NS = 6 * NS_PER_S
"""Maximum wait after power-up: the first command is handled after 4 s."""
ANSWER_NS = 500 * NS_PER_MS
"""Maximum wait for an answer: a set-point's comes within a few milliseconds; a USB adapter may add 16."""
READINGS_NS, QUIET_NS = 150 * NS_PER_MS, 30 * NS_PER_MS
"""Silence after which nothing more comes of typed text: ``y`` reads for 100 ms, a set-point does not."""
RATE_NS = 20 * NS_PER_MS
"""Interval of the set-points of a stop."""


class RunAxis:
    """Axis of runs: a board that follows a path by set-points that are typed."""

    kind: ClassVar[Literal["servo", "stepper"]] = "servo"
    taken_by: ClassVar[str] = "enable"

    def __init__(self, line_delay_ns: int = 0) -> None:
        self.commanded_deg: float | None = None
        self._delay_ns = line_delay_ns
        self._typed_deg, self._rate_deg_per_s = 0.0, 0.0

    def acquire(self) -> Dialogue[None]:
        """Switch to position mode and the loop on, in one write: no step acts on another mode's number."""
        self.commanded_deg = None
        yield from _drain(READINGS_NS + self._delay_ns)
        yield Send(b"xy")
        here_deg = yield from _answer(_ENABLED, BOOT_NS + self._delay_ns, "y")
        self._typed_deg, self._rate_deg_per_s = here_deg, 0.0
        self.commanded_deg = here_deg

    def follow(self, path: Path, start_ns: int, period_ns: int) -> Dialogue[None]:
        end_ns = start_ns + length_ns(path)
        at_ns = yield from wait_until(start_ns)
        while True:
            at_ns = min(at_ns, end_ns)
            yield from self._set_point(*at(path, at_ns - start_ns))
            if at_ns >= end_ns:
                return
            # A late set-point is that of its own time, and none is typed twice to catch up.
            at_ns = yield from wait_until(min(at_ns + period_ns, end_ns))

    def stop(self, how: How, acceleration_rpm_per_s: float) -> Dialogue[None]:
        """Stop: ``grace`` brings the set-point to rest on a ramp; ``prejudice`` leaves it as typed last."""
        now_ns = yield from _drain(QUIET_NS + self._delay_ns)
        path: Path = (PathPiece(0, self._typed_deg),)
        if how == "grace":
            path = to_rest(self._typed_deg, self._rate_deg_per_s, acceleration_rpm_per_s * DEG_PER_S)
        yield from self.follow(path, now_ns, RATE_NS)

    def _set_point(self, r_deg: float, rate_deg_per_s: float) -> Dialogue[None]:
        text = f"{r_deg:.3f}"
        self.commanded_deg = None
        self._typed_deg, self._rate_deg_per_s = float(text), rate_deg_per_s
        yield Send(f"r{text}\n".encode())
        taken_deg = yield from _answer(_TAKEN, ANSWER_NS + self._delay_ns, f"r{text}")
        # The board has a float32, and prints two decimals of it.
        if abs(taken_deg - self._typed_deg) > 0.006 + 2e-7 * abs(self._typed_deg):
            raise DialogueError(f'"r{text}" was taken as {taken_deg}: characters were lost on the line')
        self.commanded_deg = self._typed_deg


def enable() -> Dialogue[None]:
    """Switch the loop on, in position mode, where the shaft is."""
    yield from RunAxis().acquire()


def disable() -> Dialogue[None]:
    """Switch loop and current off; the menu says nothing to it."""
    yield Send(b"n")


def _drain(quiet_ns: int) -> Dialogue[int]:
    """Listen until nothing has come for so long; answers the time."""
    while (heard := (yield Listen(quiet_ns))).data:
        pass
    return int(heard.at_ns)


def _answer(pattern: re.Pattern[bytes], timeout_ns: int, asked: str) -> Dialogue[float]:
    start: Heard | None = None
    said = b""
    left_ns = timeout_ns
    while not (match := pattern.search(said)):
        heard: Any = yield Listen(left_ns)
        start = start or heard
        said += heard.data
        left_ns = timeout_ns - (heard.at_ns - start.at_ns)
        if not heard.data or left_ns <= 0:
            raise DialogueError(f'"{asked}" was not answered: {said[-60:]!r}')
    return float(match[1])
