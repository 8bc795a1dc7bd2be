"""A model of the SAC's motion, written from its manual for clarity: the judge of the native engine.

It plans each command as a list of the durations of its pulses, in half-microseconds, and plays the list.
It imports nothing of the project. Numbers are the board's: periods are whole microseconds, rounded down.

Choices, where the manual leaves it open:

- A command that comes in STANDBY has its first pulse at once; one that waited while another ran has it one
  period after the last pulse if the other ended without a ramp down and it has neither start wait nor
  sync, else 16 us later.
- A command is cut by another, or begins to ramp down by s or n, at the end of the present pulse's period.
  In a ramp the speed in play is then F // period of the present step; in CRUISE it is the command's.
- Durations within a linear ramp come from the recurrence in double precision, each rounded down when used.
"""

import math
from collections import deque
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

LOAD = 32  # half-us


@dataclass(frozen=True)
class Setup:
    sprf: int = 200
    slow: int = 10
    exponent: int = 0
    correction_us: int = 0


@dataclass(frozen=True)
class Command:
    steps: int
    ccw: bool = False
    rpm: int = 100
    cycle: int = 3000
    acc: int = 100
    dec: int = 100
    linear: bool = False
    extra: int = 0
    sync: bool = False
    wait_us: int = 0
    in_pulses: bool = False
    continuous: bool = False


def no_ramp(hundredths: int) -> bool:
    return hundredths == 0 or hundredths >= 99900


def linear_steps(rpm: int, acc: int, sprf: int) -> int:
    speed = rpm * 2 * math.pi / 60
    return int(speed * speed / (2 * (2 * math.pi / sprf) * (acc / 100)))


def linear_list(first: float, index: int, length: int) -> list[float]:
    values = [first]
    while len(values) < length:
        index += 1
        values.append(values[-1] - 2 * values[-1] / (4 * index + 1))
    return values[:length]


def first_of_stop(acc: int, sprf: int) -> float:
    return 0.676 * 1_000_000 * math.sqrt(2 * (2 * math.pi / sprf) / (acc / 100))


def acceleration(c: Command, from_rpm: int, setup: Setup) -> list[int]:
    """Periods of the steps of the ramp up."""
    f = 60_000_000 // setup.sprf
    if c.rpm <= setup.slow or no_ramp(c.acc):
        return []
    stopped = from_rpm <= setup.slow
    v1 = max(from_rpm, setup.slow) if stopped else from_rpm
    v1 = setup.slow if stopped else v1
    if not c.linear:
        n = 100 * abs(c.rpm - v1) // c.acc
        sign = 1 if c.rpm > v1 else -1
        return [f * 100 // max(100 * v1 + sign * k * c.acc, 1) for k in range(n)]
    n1 = 0 if stopped else linear_steps(v1, c.acc, setup.sprf)
    n2 = linear_steps(c.rpm, c.acc, setup.sprf)
    if n2 >= n1:
        first = first_of_stop(c.acc, setup.sprf) if stopped else float(f // v1)
        return [int(x) for x in linear_list(first, n1, n2 - n1)]
    return [int(x) for x in reversed(linear_list(float(f // c.rpm), n2, n1 - n2))]


def deceleration(c: Command, from_rpm: int, dec: int, setup: Setup) -> list[int]:
    """Periods of the steps down to a stop."""
    f = 60_000_000 // setup.sprf
    if from_rpm <= setup.slow or no_ramp(dec):
        return []
    if c.linear:
        length = linear_steps(from_rpm, dec, setup.sprf)
        return [int(x) for x in reversed(linear_list(first_of_stop(dec, setup.sprf), 0, length))]
    length = 100 * (from_rpm - setup.slow) // dec
    return [f * 100 // max(100 * setup.slow + j * dec, 1) for j in reversed(range(length))]


def pulses_of_step(period_us: int, exponent: int) -> list[int]:
    """Durations of a step's pulses."""
    twice = 2 * max(period_us, 2 << exponent)  # no pulse is shorter than 2 us
    ends = [(i * twice) >> exponent for i in range(2**exponent + 1)]
    return [b - a for a, b in pairwise(ends)]


@dataclass
class Pulse:
    duration: int
    period_us: int
    phase: str


class TooManyPulses(Exception):
    """Plan or play of more pulses than were allowed."""


RAMP_PULSES_MAX = 1_000_000
"""Maximum number of pulses of a ramp: a linear one of 1 rad/s2 to 600 RPM has 8 million, a gigabyte."""


def flat(periods: list[int], phase: str, exponent: int) -> list[Pulse]:
    if len(periods) << exponent > RAMP_PULSES_MAX:
        raise TooManyPulses
    return [Pulse(d, p, phase) for p in periods for d in pulses_of_step(p, exponent)]


def plan(c: Command, from_rpm: int, setup: Setup) -> tuple[list[Pulse], bool]:
    """The command's pulses, and whether it ends with a ramp down. A continuous one ends its plan in
    CRUISE."""
    j = setup.exponent
    up = acceleration(c, from_rpm, setup)
    if c.continuous:
        return flat(up, "ACCEL", j), False
    down = deceleration(c, c.rpm, c.dec, setup)
    unit = 1 if c.in_pulses else 2**j
    total, a, d = c.steps, (len(up) << j) // unit, (len(down) << j) // unit
    if a + d > total:
        a, d = a * total // (a + d), d * total // (a + d)
        if d >= 1:
            d = total - a
        else:
            a = total
        accelerating = flat(up[: (a * unit >> j) + 1], "ACCEL", j)[: a * unit]
        decelerating = flat(down[-((d * unit >> j) + 1) :], "DECEL", j)[-d * unit :] if d else []
        return accelerating + decelerating, d > 0
    cruise_pulses = (total - a - d) * unit + c.extra
    step = pulses_of_step(c.cycle, j)
    cruise = [Pulse(step[i % 2**j], c.cycle, "CRUISE") for i in range(cruise_pulses)]
    return flat(up, "ACCEL", j) + cruise + flat(down, "DECEL", j), d > 0


@dataclass
class Model:
    """Plays commands; times in half-microseconds."""

    setup: Setup
    pulses_max: int = 1 << 60
    """Maximum number of pulses; ``TooManyPulses`` at the next one."""
    gap: bool = True
    pulses: list[tuple[int, int]] = field(default_factory=list)
    """Pulses as (time, +1 or -1)."""
    op_sa: list[tuple[int, int]] = field(default_factory=list)
    waiting: list[Command] = field(default_factory=list)
    command: Command | None = None
    state: str = "idle"  # idle, held, start, run
    at: int = -1
    held_base: int = 0
    todo: deque[Pulse] = field(default_factory=deque)
    last: Pulse | None = None
    ramps_down: bool = False
    in_play: int = 0
    in_play_until: int = 0
    once: Command | None = None
    once_at: int | None = None

    def __post_init__(self) -> None:
        self.in_play = self.setup.slow

    # ---- playing ----

    def next_time(self) -> int | None:
        times = [self.at] if self.state in ("start", "run") else []
        if self.state != "run" and self.once_at is not None:
            times.append(self.once_at)
        return min(times, default=None)

    def play_until(self, until: int) -> None:
        """Play everything up to and at this time."""
        while (at := self.next_time()) is not None and at <= until:
            self._happen(at)

    def _happen(self, now: int) -> None:
        if self.once_at is not None and self.once_at <= now:
            if self.state == "run":
                self._end(now, self.speed())
            assert self.once
            self.command, self.once, self.once_at = self.once, None, None
            self.state, self.at = "start", now
        elif self.state == "start":
            self._start(now)
        elif self.todo or (self.command and self.command.continuous):
            self._pulse(now)
        else:
            assert self.command
            self._end(now, self.setup.slow if self.ramps_down else self.command.rpm)
            self._load_waiting(now, seamless=not self.ramps_down)

    def _pulse(self, now: int) -> None:
        assert self.command
        if len(self.pulses) >= self.pulses_max:
            raise TooManyPulses
        if not self.todo:
            step = pulses_of_step(self.command.cycle, self.setup.exponent)
            self.todo = deque(Pulse(d, self.command.cycle, "CRUISE") for d in step)
        self.last = self.todo.popleft()
        self.pulses.append((now, -1 if self.command.ccw else 1))
        duration = self.last.duration + 2 * self.setup.correction_us
        if self.setup.correction_us < 0:
            duration = max(duration, 4)
        self.at = now + duration

    def _start(self, now: int) -> None:
        assert self.command
        v0 = self.setup.slow if self.gap and now > self.in_play_until else self.in_play
        self.op_sa.append((now, 1))
        pulses, self.ramps_down = plan(self.command, v0, self.setup)
        self.todo = deque(pulses)
        self.last = None
        self.state = "run"
        if not self.todo and not self.command.continuous:
            self.at = now + LOAD

    def _end(self, now: int, in_play: int) -> None:
        self.op_sa.append((now, 0))
        self.in_play, self.in_play_until = in_play, now
        self.state, self.command = "idle", None

    def _load_waiting(self, now: int, *, seamless: bool) -> None:
        if not self.waiting:
            return
        c = self.waiting.pop(0)
        base = now if seamless and not c.sync and not c.wait_us else now + LOAD
        self._load(c, base)

    def _load(self, c: Command, base: int) -> None:
        self.command, self.held_base = c, base
        self.state, self.at = ("held", -1) if c.sync else ("start", base + 2 * c.wait_us)

    def speed(self) -> int:
        """RPM at this moment."""
        assert self.command
        if self.last is None or self.last.phase == "CRUISE":
            return self.command.rpm
        return 60_000_000 // self.setup.sprf // max(self.last.period_us, 2 << self.setup.exponent)

    # ---- what the terminal does ----

    def act(self, now: int, what: str, value: Any = None) -> None:
        self.play_until(now)
        getattr(self, "_do_" + what)(now, value)

    def _do_enqueue(self, now: int, c: Command) -> None:
        if len(self.waiting) == 30:
            return
        self.waiting.append(c)
        if self.state == "idle":
            self._load(self.waiting.pop(0), now)

    def _do_once(self, now: int, c: Command) -> None:
        self.once = c
        self.once_at = None if c.sync else now + 2 * c.wait_us

    def _do_release(self, now: int, _: None) -> None:
        if self.once and self.once_at is None:
            self.once_at = now + 2 * self.once.wait_us
        if self.state == "held":
            assert self.command
            self.state, self.at = "start", max(now, self.held_base) + 2 * self.command.wait_us

    def _do_stop(self, now: int, dec: int | None) -> None:
        self.waiting.clear()
        self.once = self.once_at = None
        if dec is None or not self._ramp_down(dec):
            self._cut(now)

    def _do_next(self, now: int, graceful: bool) -> None:
        if self.state == "idle":
            return
        if graceful and self.command and self._ramp_down(self.command.dec):
            return
        self._cut(now)
        self._load_waiting(now, seamless=False)

    def _do_finish(self, now: int, _: None) -> None:
        self.waiting.clear()
        self.once = self.once_at = None
        if self.state != "run" or (
            self.command and self.command.continuous and not self._ramp_down(self.command.dec)
        ):
            self._cut(now)

    def _do_gap(self, now: int, on: bool) -> None:
        self.gap = on

    def _cut(self, now: int) -> None:
        if self.state == "run":
            self._end(now, self.setup.slow)
        self.in_play = self.setup.slow
        self.state, self.command = "idle", None

    def _ramp_down(self, dec: int) -> bool:
        if self.state != "run" or no_ramp(dec):
            return False
        assert self.command
        if self.last and self.last.phase == "DECEL":
            return True
        down = flat(deceleration(self.command, self.speed(), dec, self.setup), "DECEL", self.setup.exponent)
        if not down:
            return False
        self.command = replace(self.command, continuous=False, dec=dec)
        self.todo, self.ramps_down = deque(down), True
        return True
