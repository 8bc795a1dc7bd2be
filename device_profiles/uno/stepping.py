"""Work of the sketch: moves at its pins, lines that it prints, constants that it keeps."""

from collections.abc import Generator
from typing import Any

from device_profiles.uno.constants import Constants, boot_text, counts_of, ramp_of
from device_profiles.uno.memory import SECTION, packed, read_constants
from device_profiles.uno.ramp import duration_ns, paused, pulses_of
from hil.vocab.firmware import Board, Commit, Request
from hil.vocab.time import NS_PER_S

PAUSE_NS = NS_PER_S
"""Pause of a move to and fro. Source: manual, delay(1000)."""
PINS = (*(f"D{number}" for number in range(2, 14)), *(f"A{number}" for number in range(6)))
Steps = Generator[Request, Any, None]
"""Part of the main loop."""


class Stepping:
    """Moves of one power-up, and what is said about them."""

    def __init__(self, board: Board) -> None:
        self.pins = board.pins
        self.constants = read_constants(board.nvm.get(SECTION))
        self._uart = board.uart
        self._is_line_open = False
        """True while the last line that was printed has no end."""
        self._steps = 0
        """Steps of the move under way, negative with the direction pin low; 0: none."""
        self._counts = 0
        self._swings = False
        self._board = board
        self._next_swing_ns: int | None = None
        """Time at which the sketch's own motion goes the other way; None: a command has ended it."""
        self._swing_steps = 0

    # ---- lines ----

    def say(self, line: str) -> None:
        """Print a line of its own."""
        self._uart.write((b"\r\n" if self._is_line_open else b"") + line.encode() + b"\r\n")
        self._is_line_open = False

    def print_boot(self) -> None:
        """Print the lines of boot; the last has no end."""
        self._uart.write((b"\r\n" if self._is_line_open else b"") + boot_text(self.constants))
        self._is_line_open = True

    # ---- moves ----

    @property
    def is_moving(self) -> bool:
        return self._steps != 0

    @property
    def step_pin(self) -> str:
        return f"D{self.constants.step_pin:.0f}"

    @property
    def dir_pin(self) -> str:
        return f"D{self.constants.dir_pin:.0f}"

    @property
    def counts(self) -> int:
        """Timer2's counts at the speed that the coils allow."""
        return counts_of(self.constants.delay_us)

    def set_up(self) -> None:
        """Drive the pins of step and direction."""
        for pin in (self.step_pin, self.dir_pin):
            self.pins.write(pin, 0)

    def begin(self, steps: int, counts: int, *, swings: bool, pause_ns: int = 0) -> None:
        """Begin a move at Timer2's counts. ``swings``: it goes back when it has ended."""
        self._steps, self._counts, self._swings = steps, counts, swings
        rows = pulses_of(abs(steps), ramp_of(counts, int(self.constants.accel_steps)))
        self.pins.write(self.dir_pin, int(steps > 0))
        self.pins.pulse(self.step_pin, paused(rows, pause_ns) if pause_ns else rows)

    # ---- the sketch's own motion: there and back, from power-up on, until a command comes ----

    def begin_by_itself(self) -> None:
        """Let the motor swing from a pause after now on, as the manual's loop() does."""
        self._swing_steps = self.constants.swing_steps
        if self._swing_steps:
            self._next_swing_ns = self._board.now_ns + PAUSE_NS

    @property
    def swing_in_ns(self) -> int | None:
        """Time until ``swing_on`` is due; None: never."""
        return None if self._next_swing_ns is None else max(self._next_swing_ns - self._board.now_ns, 0)

    def swing_on(self) -> None:
        """Begin the next way of the sketch's own motion, if it is due; it prints nothing."""
        if self.swing_in_ns != 0:
            return
        steps, self._swing_steps = self._swing_steps, -self._swing_steps
        rows = pulses_of(abs(steps), ramp_of(self.counts, int(self.constants.accel_steps)))
        self.pins.write(self.dir_pin, int(steps > 0))
        self.pins.pulse(self.step_pin, rows)
        self._next_swing_ns = self._board.now_ns + duration_ns(rows) + PAUSE_NS

    def end_by_itself(self) -> int:
        """End the sketch's own motion at once. Return how many of the steps under way were not made."""
        if self._next_swing_ns is None:
            return 0
        self._next_swing_ns = None
        return self.stop()

    # ---- the end of moves ----

    def end(self) -> None:
        """Say that a move has ended, and begin the way back of one to and fro."""
        steps, self._steps = self._steps, 0
        if not steps:
            return
        self.say(f"moved {steps} steps")
        if self._swings:
            self.begin(-steps, self._counts, swings=True, pause_ns=PAUSE_NS)

    def stop(self) -> int:
        """End the move at once. Return how many of its steps were not made."""
        left = self.pins.pulses_left
        self.pins.pulse(self.step_pin, ())
        self._steps, self._swings = 0, False
        return left

    def end_all(self) -> None:
        """End the move, and drive no pin any more: as a reset does."""
        self.stop()
        for pin in PINS:
            self.pins.let_go(pin)

    # ---- constants ----

    def keep(self, constants: Constants) -> Steps:
        """Use other constants, and write them to the EEPROM."""
        for pin in (self.step_pin, self.dir_pin):
            self.pins.let_go(pin)
        self.constants = constants
        self.set_up()
        self.print_boot()
        if not (yield Commit(SECTION, packed(constants))):
            self.say("error: the EEPROM could not be written; the constants are lost without power")
