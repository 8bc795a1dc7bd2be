"""Reader of what is typed at a SAC: numbers, and the attributes of a motion command."""

from collections.abc import Callable
from dataclasses import dataclass

from hil.vocab.motion import MotionEntry

NO_RAMP = 99900
"""Acceleration in hundredths from which on, and at 0, there is no ramp (manual, Accel)."""
WORD = 1 << 32
MIN_CYCLE_US = 2
"""Minimum period: a driver takes no shorter one (manual, slow speed)."""


class Text:
    """Line that is read from left to right."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0

    def peek(self) -> str:
        """Answer the next character, "" at the end."""
        return self._text[self._at : self._at + 1]

    def take(self) -> str:
        """Take the next character; "" at the end."""
        character = self.peek()
        self._at += 1
        return character

    def takes(self, letters: str) -> bool:
        """Take the next character if it is one of these; answers whether it was."""
        character = self._text[self._at : self._at + 1]
        if character and character in letters:
            self._at += 1
            return True
        return False

    def is_digit(self) -> bool:
        return self._at < len(self._text) and self._text[self._at] in "0123456789"

    def number(self) -> int | None:
        """Read digits, as the board's 32 bits hold them; None where there are none."""
        digits = self._digits()
        return int(digits) % WORD if digits else None

    def hundredths(self) -> int | None:
        """Read a number with two decimals up to 100, whole from there on; further digits are cut."""
        whole = self.number()
        has_point = self.takes(".")
        if whole is None and not has_point:
            return None
        decimals = self._digits() if has_point else ""
        whole = whole or 0
        if whole >= 100:
            return min(whole * 100, NO_RAMP)
        return whole * 100 + int((decimals + "00")[:2])

    def acceleration(self) -> int:
        """Read the hundredths of an ``a`` or a ``d``; -1 without a number: the system's default."""
        hundredths = self.hundredths()
        return -1 if hundredths is None else hundredths

    def _digits(self) -> str:
        start = self._at
        while self.is_digit():
            self._at += 1
        return self._text[start : self._at]

    def rest(self) -> str:
        return self._text[self._at :]


@dataclass(frozen=True)
class Velocity:
    """Target speed, as RPM or as the cycle of a full step; the other one follows."""

    rpm: int
    cycle_us: int


def f_of(steps_per_rev: int) -> int:
    """Microseconds of a full step at 1 RPM: 300,000 for 200 steps a turn."""
    return 60_000_000 // max(steps_per_rev, 1)


def from_rpm(rpm: int, steps_per_rev: int) -> Velocity:
    """Velocity that ``v`` sets."""
    return Velocity(rpm, max(f_of(steps_per_rev) // rpm, MIN_CYCLE_US))


def from_cycle(cycle_us: int, steps_per_rev: int) -> Velocity:
    """Velocity that ``vc`` sets."""
    cycle_us = max(cycle_us, MIN_CYCLE_US)
    return Velocity(f_of(steps_per_rev) // cycle_us, cycle_us)


@dataclass
class Attributes:
    """Attributes of a motion command in a line; None: not given. ``acc``, ``dec`` -1: the default."""

    steps: int | None = None
    is_ccw: bool | None = None
    velocity: Velocity | None = None
    acc: int | None = None
    dec: int | None = None
    is_linear: bool | None = None
    extra_pulses: int | None = None
    is_sync: bool | None = None
    wait_us: int | None = None
    is_pulses: bool | None = None

    def apply(self, entry: MotionEntry, ramp: Callable[[bool], tuple[int, int]]) -> MotionEntry:
        """Apply what was said to an entry. A change of ramp brings that ramp's defaults first: ``ramp`` gets
        whether it is linear, and gives its acceleration and deceleration."""
        is_linear = entry.is_linear if self.is_linear is None else self.is_linear
        default_acc, default_dec = acc, dec = ramp(is_linear)
        if is_linear == entry.is_linear:
            acc, dec = entry.acc_hundredths, entry.dec_hundredths
        if self.acc is not None:
            acc = default_acc if self.acc < 0 else self.acc
        if self.dec is not None:
            dec = default_dec if self.dec < 0 else self.dec
        velocity = self.velocity or entry
        return MotionEntry(
            steps=entry.steps if self.steps is None else self.steps,
            rpm=velocity.rpm,
            cycle_us=velocity.cycle_us,
            wait_us=entry.wait_us if self.wait_us is None else self.wait_us,
            acc_hundredths=acc,
            dec_hundredths=dec,
            is_ccw=entry.is_ccw if self.is_ccw is None else self.is_ccw,
            is_linear=is_linear,
            extra_pulses=entry.extra_pulses if self.extra_pulses is None else self.extra_pulses,
            is_sync=entry.is_sync if self.is_sync is None else self.is_sync,
            is_pulses=entry.is_pulses if self.is_pulses is None else self.is_pulses,
        )


def read_steps(text: Text, said: Attributes) -> None:
    """Read what follows an m: a sign, a number."""
    minus = text.takes("-")
    said.steps = text.number()
    if minus:
        said.is_ccw = True
    elif said.steps is not None:
        said.is_ccw = False


def read_attributes(text: Text, steps_per_rev: int, *, with_steps: bool = False) -> Attributes:
    """Read the attributes up to the line's end, in any order; letters that mean nothing are skipped.

    ``with_steps``: an m among them sets the steps, and s0 clears the sync, as in a queue's edit.
    """
    said = Attributes()
    while letter := text.take():
        match letter.lower():
            case "m" if with_steps:
                read_steps(text, said)
            case "v":
                by_cycle = text.takes("cC")
                if number := text.number():
                    said.velocity = (from_cycle if by_cycle else from_rpm)(number, steps_per_rev)
            case "a":
                said.acc = text.acceleration()
            case "d":
                said.dec = text.acceleration()
            case "l":
                if (number := text.number()) is not None:
                    said.is_linear = number != 0
            case "u":
                if (number := text.number()) is not None:
                    said.extra_pulses = number % 256
            case "t":
                if (number := text.number()) is not None:
                    said.wait_us = number
            case "f":
                said.is_pulses = False
            case "p":
                said.is_pulses = True
            case "s":
                said.is_sync = text.number() != 0 if with_steps else True
    return said
