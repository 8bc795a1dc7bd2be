"""Dialogues with a real SAC's terminal, where a twin has a verb for the same."""

from typing import ClassVar, Literal

from device_profiles.sac.companion import BoardTerminal, stands_still
from device_profiles.sac.screen_reading import MICROSTEP_EXPONENT, SLOW_RPM, STEPS_PER_REV, number_on
from device_profiles.sac.verbs import one_shot
from hil.firmware.listening import wait_until
from hil.vocab.axis import How
from hil.vocab.dialogue import Dialogue, DialogueError, Refusal, Send
from hil.vocab.time import NS_PER_MS, NS_PER_S

ANSWER_NS = 800 * NS_PER_MS
"""Maximum silence in a run before a board is lost; a line and its echo take 20 ms at 38400 baud."""
LOOK_NS, LOOK_NEAR_NS = 500 * NS_PER_MS, 50 * NS_PER_MS
"""Interval of looks at the speed: on the way, where each costs the board time, and at the expected end."""
SPARE_NS = 10 * NS_PER_S
_STOPS_NS = 600 * NS_PER_S
_LOST = 3
"""Number of looks that may be garbled by what was broken off before a stop."""


class RunAxis:
    """Axis of runs: a board that takes targets, and is asked whether it stands. Its terminal tells no
    position: 0 is where it stood when it was reset, and what it was told since is counted."""

    kind: ClassVar[Literal["servo", "stepper"]] = "stepper"
    taken_by: ClassVar[str] = "reset"

    def __init__(self, line_delay_ns: int = 0) -> None:
        self.commanded_deg: float | None = None
        self._delay_ns = line_delay_ns
        self._pulses = 0
        self._pulses_per_rev = self._slow_rpm = 1

    def acquire(self) -> Dialogue[None]:
        """Reset warmly, ending all motion: parameters from the EEPROM come into force, the queue stays."""
        self.commanded_deg = None
        terminal = BoardTerminal()
        yield from terminal.sync()
        yield from terminal.ask("$R")
        screen = yield from terminal.screen("cc")
        self._pulses_per_rev = number_on(screen, STEPS_PER_REV) << number_on(screen, MICROSTEP_EXPONENT)
        self._slow_rpm = max(number_on(screen, SLOW_RPM), 1)
        self._pulses, self.commanded_deg = 0, 0.0

    def move_abs(self, position_deg: float, velocity_rpm: float, start_ns: int) -> Dialogue[None]:
        """Type the command at once, held by its sync; ``y`` at the start releases it. The speed is looked at
        until it is 0: never slower than ``slow``, it has to come to its end."""
        pulses = round(position_deg / 360 * self._pulses_per_rev) - self._pulses
        if pulses == 0:
            return
        rpm = int(velocity_rpm)
        self.commanded_deg = None
        terminal = BoardTerminal()
        yield from terminal.ask(f"xm{one_shot(pulses, f'v{rpm}')}s", ANSWER_NS + self._delay_ns)
        armed_ns = yield from wait_until(0)
        if armed_ns > start_ns:
            late_ms = (armed_ns - start_ns) / NS_PER_MS
            raise DialogueError(f"it took its command {late_ms:.0f} ms after the start; its line is too slow")
        yield from wait_until(start_ns)
        yield from terminal.ask("y", ANSWER_NS + self._delay_ns)
        turns_ns = abs(pulses) * 60 * NS_PER_S // self._pulses_per_rev
        give_up_ns = start_ns + turns_ns // min(rpm, self._slow_rpm) + SPARE_NS
        yield from self._until_it_stands(terminal, start_ns + turns_ns // rpm, give_up_ns)
        self._pulses += pulses
        self.commanded_deg = self._pulses * 360 / self._pulses_per_rev

    def stop(self, how: How, acceleration_rpm_per_s: float) -> Dialogue[None]:
        """Stop by ``s`` with the session's deceleration, or by ``S``: what is held is dropped too. Where a
        motion was cut short nobody knows."""
        yield Send(b"s\r" if how == "grace" else b"S\r")
        terminal = BoardTerminal()
        yield from terminal.quiet(LOOK_NEAR_NS + self._delay_ns)
        now_ns = yield from wait_until(0)
        yield from self._until_it_stands(terminal, now_ns, now_ns + _STOPS_NS, may_lose=_LOST)

    def _until_it_stands(
        self, terminal: BoardTerminal, expected_ns: int, give_up_ns: int, may_lose: int = 0
    ) -> Dialogue[None]:
        now_ns = yield from wait_until(0)
        while True:
            pause_ns = LOOK_NEAR_NS if now_ns >= expected_ns else min(LOOK_NS, expected_ns - now_ns)
            now_ns = yield from wait_until(now_ns + pause_ns)
            try:
                yield from stands_still(terminal, ANSWER_NS + self._delay_ns)
                return
            except Refusal:
                if now_ns > give_up_ns:
                    raise DialogueError("it does not come to its end") from None
            except DialogueError:
                if (may_lose := may_lose - 1) < 0:
                    raise
                terminal = BoardTerminal()


def reset() -> Dialogue[None]:
    """Reset warmly: parameters from the EEPROM come into force, the queue stays."""
    yield from RunAxis().acquire()


def stop(how: How) -> Dialogue[None]:
    """End all motion: the dialogue ends when the board stands."""
    yield from RunAxis().stop(how, 0.0)
