"""Mechaduino firmware 0.1.5, written as the board's own setup() and loop().

What each letter does and when it prints is the behaviour of the public firmware, checked against its
output; the control interrupt itself runs in the core (``native/control/mechaduino.c``).
"""

import math
from array import array
from collections.abc import Callable, Generator, Iterable
from typing import Any, NamedTuple

from device_profiles.mechaduino import calibration, text
from device_profiles.mechaduino.menus import edit_parameters
from device_profiles.mechaduino.serial_usb import SerialUSB
from hil.firmware.arduino import float32, print_int
from hil.vocab.firmware import Board, Commit, CoreEvent, Delay, Main, Request
from hil.vocab.path import Path
from hil.vocab.time import NS_PER_MS

READ_ANGLE, READ_DIAAGC, READ_ERRFL, NOP = 0xFFFF, 0xFFFC, 0x4001, 0xC000
"""SPI frames: read bit 14, even parity bit 15, register (AS5047D data sheet)."""
STEP_DEG = float32(1.8)
LOOKUP = "lookup"
"""The section of the flash that holds the look-up table."""
DEFAULT_LOOKUP_ADDRESS = 0xB900
"""Where the linker put the table; it depends on the build."""

Steps = Generator[Request, Any, None]


def delay_ms(duration: int) -> Delay:
    """The board's delay()."""
    return Delay(duration * NS_PER_MS)


class Command(NamedTuple):
    """A letter of the main loop. ``label`` stands in the menu; None: not listed."""

    letter: str
    label: str | None
    run: Callable[["Mechaduino"], Steps | None]


class Mechaduino:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        self.axis = board.axis
        self.serial = SerialUSB(board.uart)
        self._nvm = board.nvm
        self._address = board.facts.get("lookup_address", DEFAULT_LOOKUP_ADDRESS)
        self._step_number = 0
        self._dir = False
        self._table_text = ""
        self._lookup: array[float] = array("f")
        self.path: Path = ()
        """What the set-point follows, or followed last, and since when."""
        self.path_from_ns = 0

    # ---- setup() and loop() ----

    def main(self) -> Main:
        if LOOKUP in self._nvm:
            self.axis.write_table(self._nvm[LOOKUP])
        else:
            self.axis.write_table(bytes(4 * calibration.COUNTS_PER_REV))
        self._use_table()
        yield delay_ms(3000)
        self.print_menu()
        self.serial.println(text.SPI_START)
        yield delay_ms(1000)
        if not self.has_table:
            self.serial.println(text.EMPTY_TABLE)
        while True:
            yield from self.serial.wait()
            command = COMMANDS_BY_LETTER.get(self.serial.read())
            steps = command.run(self) if command else None
            if steps:
                yield from steps

    @property
    def has_table(self) -> bool:
        """Whether the look-up table was ever written, as the firmware tells it."""
        return any(self._lookup[i] for i in (0, 128, 1024))

    def angle_deg(self) -> float:
        """The calibrated angle with turns, of a reading now, as the law's next step will count it."""
        angle_deg, turns = self._lookup[int(self.axis.get("raw"))], self.axis.get("wrap_count")
        since_deg = angle_deg - (self.axis.get("yw") - 360.0 * turns)
        if abs(since_deg) > 180.0:
            turns -= math.copysign(1.0, since_deg)
        return angle_deg + 360.0 * turns

    def interrupt(self, event: CoreEvent) -> None:
        if event.kind == "step_response":
            self.serial.println(str(int(event.value)) if math.isfinite(event.value) else "0")

    # ---- the commands, in the order of the menu ----

    def step(self) -> Steps:
        yield from self._one_step()
        yield from self.print_angle()

    def toggle_dir(self) -> None:
        self._dir = not self._dir

    def print_angle(self) -> Steps:
        self.serial.print(f"stepNumber: {self._step_number} , Angle: ")
        mean = yield from self._read_angle()
        self.serial.print_float(self._lookup[mean])
        self.serial.println(f", raw encoder: {self._read_encoder()}")

    def calibrate(self) -> Steps:
        """Steps through all 200 full steps and stores the table made from the readings."""
        self.serial.println(text.CALIBRATION_BEGIN)
        before = self._read_encoder()
        self._dir = True
        yield from self._one_step()
        yield delay_ms(500)
        if self._read_encoder() - before < 0:
            self.serial.println(text.WIRED_BACKWARDS)
            return
        while self._step_number != 0:
            self._dir = self._step_number > 0
            yield from self._one_step()
            yield delay_ms(100)
        self._dir = True
        means = []
        for step in range(calibration.STEPS_PER_REV):
            yield delay_ms(20)
            readings = []
            for _ in range(calibration.AVERAGED):
                readings.append(self._read_encoder())
                yield delay_ms(10)
            means.append(calibration.average(readings))
            self.serial.print(f"\r\n{step // 2}% " if step % 20 == 0 else ".")
            yield from self._one_step()
        yield from self._store_table(calibration.angles(means))

    def check_encoder(self) -> Steps:
        """The encoder's registers DIAAGC and ERRFL, four milliseconds."""
        self.serial.println(*text.DIAGNOSTICS_INTRO)
        self.axis.spi(READ_DIAAGC)
        yield delay_ms(1)
        frame = self.axis.spi(NOP)
        self._print_register(text.DIAAGC_HEAD, frame, text.DIAAGC_LINES, text.DIAAGC_FAULTS)
        yield delay_ms(1)
        self.axis.spi(READ_ERRFL)
        yield delay_ms(1)
        frame = self.axis.spi(NOP)
        self._print_register(text.ERRFL_HEAD, frame, text.ERRFL_LINES, text.ERRFL_LINES)
        yield delay_ms(1)

    def query(self) -> None:
        """Gains with 10 decimals, the look-up table with 2."""
        out = self.serial

        def gain(name: str, comment: str = "") -> None:
            out.print(f"volatile float {name} = ")
            out.print_float(self.axis.get(name) if name != "Fs" else 6500.0, 10)
            out.println(f";{comment}")

        out.println(" ", "----Current Parameters-----", " ", " ")
        gain("Fs", "  //Sample frequency in Hz")
        out.println(" ")
        gain("pKp", "      //position mode PID vallues.")
        for name in ("pKi", "pKd", "pLPF"):
            gain(name)
        out.println(" ")
        gain("vKp", "      //velocity mode PID vallues.")
        for name in ("vKi", "vKd", "vLPF"):
            gain(name)
        out.println("", "//This is the encoder lookup table (created by calibration routine)", "")
        out.println("const float __attribute__((__aligned__(256))) lookup[16384] = {")
        if not self._table_text:
            self._table_text = "".join(f"{out.format_float(angle)}, " for angle in self._lookup)
        out.print(self._table_text)
        out.println("", "};")

    def set_mode(self, letter: str) -> None:
        self.axis.set("mode", ord(letter))

    def enable(self) -> Steps:
        """Overwrites the set-point in every mode, then starts the control loop."""
        mean = yield from self._read_angle()
        self.axis.set("r", float32(self._lookup[mean] + 360.0 * self.axis.get("wrap_count")))
        self.serial.print("New setpoint ")
        self.serial.print_float(self.axis.get("r"))
        self.serial.println("")
        self.axis.loop(True)

    def disable(self) -> None:
        self.axis.loop(False)
        self.axis.vref(0, 0)

    def enter_setpoint(self) -> Steps:
        self.serial.println("Enter setpoint:")
        self.axis.set("r", (yield from self.serial.ask_float()))
        self.serial.print_float(self.axis.get("r"))
        self.serial.println("")

    def step_response(self) -> Steps:
        self.serial.println(*text.STEP_RESPONSE_INTRO)
        self.axis.loop(True)
        self.axis.set("r", 0)
        for seconds in range(9, 0, -1):
            yield delay_ms(1000)
            self.serial.println(f"{seconds}...")
        yield delay_ms(1000)
        self.axis.set("print_yw", 1)
        yield delay_ms(100)
        self.axis.set("r", 97.65)  # 97.65 * 1024 is about 100,000
        yield delay_ms(400)
        self.axis.set("print_yw", 0)
        self.axis.set("r", 0)
        yield delay_ms(500)
        self.axis.loop(False)

    def print_sine(self) -> Steps:
        """The table that the firmware would make; the built-in one differs (it has pi = 3.1415)."""
        self.serial.println(*text.SINE_INTRO)
        yield delay_ms(3000)
        self.serial.println(*text.SINE_HEAD)
        values = (1024.0 * math.sin(3.14159265358979 * (x * 0.1 / 180.0)) for x in range(3601))
        self.serial.print("".join(f"{_round(value)}, " for value in values))

    def print_menu(self) -> None:
        self.serial.println(*text.BANNER)
        for command in COMMANDS:
            if command.label is None:
                continue
            hint = f" -- note, {text.K_HINT}" if command.letter == "k" else ""
            self.serial.println(f" {command.letter}  -  {command.label}{hint}")
            if command.letter in "pqtrm":
                self.serial.println("")

    def anticogging(self) -> Steps:
        """Holds 656 angles there and back, and prints the effort that each takes."""
        self.serial.println(text.ANTICOGGING_BEGIN)
        self.set_mode("x")
        self.axis.set("r", self._lookup[1])
        self.axis.loop(True)
        yield delay_ms(1000)
        yield from self._hold_angles(range(1, 657))
        self.serial.println(text.ANTICOGGING_REVERSE)
        yield from self._hold_angles(range(656, 0, -1))
        self.serial.println(text.ANTICOGGING_DONE)
        self.axis.loop(False)

    def edit(self) -> Steps:
        yield from edit_parameters(self.axis, self.serial)

    # ---- what several commands use ----

    def _one_step(self) -> Steps:
        self._step_number += -1 if self._dir else 1
        effort = int(0.33 * self.axis.get("uMAX"))
        self.axis.output(float32(STEP_DEG * self._step_number), effort)
        yield delay_ms(10)

    def _read_encoder(self) -> int:
        return self.axis.spi(READ_ANGLE) & 0x3FFF

    def _read_angle(self) -> Generator[Request, Any, int]:
        """Stops the control loop; answers the mean of ten readings, wrong across the encoder's zero."""
        self.axis.loop(False)
        total = 0
        for _ in range(calibration.AVERAGED):
            total += self._read_encoder()
            yield delay_ms(10)
        return total // calibration.AVERAGED

    def _hold_angles(self, counts: Iterable[int]) -> Steps:
        for count in counts:
            self.axis.set("r", self._lookup[count])
            self.serial.print_float(self.axis.get("r"), 10)
            self.serial.print(" , ")
            yield delay_ms(100)
            self.serial.print_float(self.axis.get("u"), 10)
            self.serial.println("")

    def _store_table(self, new: "array[float]") -> Steps:
        self.serial.print(f"\r\nWriting to flash 0x{self._address:X} page size PSZ=3")
        table = calibration.written(self.axis.table(), new)
        if new:
            durable = yield Commit(LOOKUP, table)
            if durable:  # else the old table is what a read-back shows
                self.axis.write_table(table)
                self._use_table()
        self.serial.print(calibration.progress(new, self._address))
        self.serial.println(*text.CALIBRATION_DONE)

    def _use_table(self) -> None:
        self._lookup = array("f", self.axis.table())
        self._table_text = ""

    def _print_register(self, head: str, frame: int, lines: dict[int, str], faults: Iterable[int]) -> None:
        self.serial.println(head, print_int(frame | 0x70000, 2))
        for bit, line in lines.items():
            if frame & 1 << bit:
                self.serial.println(line)
        if not any(frame & 1 << bit for bit in faults):
            self.serial.println(text.LOOKS_GOOD)
        self.serial.println(" ")


def _round(x: float) -> int:
    """C's round(): halves away from zero."""
    return math.floor(x + 0.5) if x >= 0 else -math.floor(-x + 0.5)


COMMANDS = (
    Command("s", "step", Mechaduino.step),
    Command("d", "dir", Mechaduino.toggle_dir),
    Command("p", "print angle", Mechaduino.print_angle),
    Command("c", "write new calibration table", Mechaduino.calibrate),
    Command("e", "check encoder diagnositics", Mechaduino.check_encoder),
    Command("q", "parameter query", Mechaduino.query),
    Command("x", "position mode", lambda board: board.set_mode("x")),
    Command("v", "velocity mode", lambda board: board.set_mode("v")),
    Command("t", "torque mode", lambda board: board.set_mode("t")),
    Command("y", "enable control loop", Mechaduino.enable),
    Command("n", "disable control loop", Mechaduino.disable),
    Command("r", "enter new setpoint", Mechaduino.enter_setpoint),
    Command("j", "step response", Mechaduino.step_response),
    Command("k", "edit controller gains", Mechaduino.edit),
    Command("g", "generate sine commutation table", Mechaduino.print_sine),
    Command("m", "print main menu", Mechaduino.print_menu),
    Command("w", None, Mechaduino.calibrate),
    Command("a", None, Mechaduino.anticogging),
    Command("h", None, lambda board: board.set_mode("h")),
)
"""Every byte that the main loop knows; any other is ignored."""

COMMANDS_BY_LETTER = {ord(command.letter): command for command in COMMANDS}
