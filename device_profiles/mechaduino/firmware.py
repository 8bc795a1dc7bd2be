"""Mechaduino firmware 0.1.5, written as the board's own setup() and loop().

Each letter does and prints what the public firmware does and prints, at the same times, checked against its
output; the control interrupt itself runs in the core (``hil/core/native/control/mechaduino.c``).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from device_profiles.mechaduino import calibration, encoder, routines, text
from device_profiles.mechaduino.firmware_build import FirmwareBuild
from device_profiles.mechaduino.lookup_table import LookupTable
from device_profiles.mechaduino.menus import edit_parameters
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps, delay_ms
from hil.firmware.arduino import float32
from hil.vocab.firmware import Board, CoreEvent, Main
from hil.vocab.path import Path

DEFAULT_LOOKUP_ADDRESS = 0xB900
"""Default address of the look-up table, which the linker sets; it depends on the build."""


class Command(NamedTuple):
    """Letter of the main loop. ``label`` stands in the menu; None: not listed."""

    letter: str
    label: str | None
    run: Callable[["Mechaduino"], Steps | None]


class Mechaduino:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        self.axis = board.axis
        self.build = FirmwareBuild(board)
        self.serial = SerialUSB(board.uart)
        address = board.facts.get("lookup_address", DEFAULT_LOOKUP_ADDRESS)
        self.table = LookupTable(board.axis, board.nvm, address)
        self._step_number = 0
        self.path: Path = ()
        """Path that the set-point follows, or followed last."""
        self.path_from_ns = 0
        self.is_busy = True
        """True while the main program starts, runs a routine or asks for a number."""
        self.letter = ""
        """Command that it carries out, or carried out last; empty: it starts, or none has come."""

    # ---- setup() and loop() ----

    def main(self) -> Main:
        self._begin()
        yield from self.boot()
        while True:
            self.is_busy = False
            yield from self.serial.wait()
            self.is_busy = True
            yield from self.command(self.serial.read())

    def _begin(self) -> None:
        """Initialise variables and pins."""
        self.build.set_up()
        self.axis.set("dir", 0)  # whatever the level at D0 is
        self.table.load()

    @property
    def lacks(self) -> tuple[str, str] | None:
        """Thing that it lacks to hold an angle, and the verb that makes it; None: nothing."""
        return None if self.table.is_written else ("its look-up table is empty", "calibrate")

    def boot(self) -> Steps:
        """Run setup(), from the wait for a terminal on."""
        yield delay_ms(3000)
        self.print_menu()
        yield from self.set_up_encoder()
        if not self.table.is_written:
            self.serial.println(text.EMPTY_TABLE)
        self.build.start_loop()

    def set_up_encoder(self) -> Steps:
        self.serial.println(text.SPI_START)
        yield delay_ms(1000)

    def command(self, letter: int) -> Steps:
        """Carry out the command of a byte; any other is none."""
        self.letter = chr(letter) if letter >= 0 else ""
        command = COMMANDS_BY_LETTER.get(letter)
        steps = command.run(self) if command else None
        if steps:
            yield from steps

    def interrupt(self, event: CoreEvent) -> None:
        if event.kind == "step_response":
            self.serial.println(str(int(event.value)) if math.isfinite(event.value) else "0")

    # ---- the commands, in the order of the menu ----

    def step(self) -> Steps:
        yield from self.one_step()
        yield from self.print_angle()

    def toggle_dir(self) -> None:
        self.axis.set("dir", not self.axis.get("dir"))

    def print_angle(self) -> Steps:
        self.serial.print(f"stepNumber: {self._step_number} , Angle: ")
        mean = yield from encoder.read_mean(self.axis)
        self.serial.print_float(self.table.angles[mean])
        self.serial.println(f", raw encoder: {encoder.read_count(self.axis)}")

    @property
    def calibration_ns(self) -> int:
        """Time that ``calibrate`` takes from now on: the pauses in it, in order."""
        back = abs(self._step_number - 1)
        return 1_000_000 * (510 + 110 * back + (30 + 10 * encoder.AVERAGED) * self.build.spr)

    def calibrate(self) -> Steps:
        """Step through all full steps of a turn and store the table made from the readings."""
        self.serial.println(text.CALIBRATION_BEGIN)
        before = encoder.read_count(self.axis)
        self.axis.set("dir", 1)
        yield from self.one_step()
        yield delay_ms(500)
        if encoder.read_count(self.axis) - before < 0:
            self.serial.println(text.WIRED_BACKWARDS)
            return
        while self._step_number != 0:
            self.axis.set("dir", self._step_number > 0)
            yield from self.one_step()
            yield delay_ms(100)
        self.axis.set("dir", 1)
        means = []
        spr = self.build.spr
        for step in range(spr):
            yield delay_ms(20)
            readings = []
            for _ in range(encoder.AVERAGED):
                readings.append(encoder.read_count(self.axis))
                yield delay_ms(10)
            means.append(calibration.average(readings))
            self.serial.print(f"\r\n{100 * step // spr}% " if step % 20 == 0 else ".")
            yield from self.one_step()
        yield from self.table.store(calibration.angles(means), self.serial)
        self.serial.println(*text.CALIBRATION_DONE)

    def one_step(self) -> Steps:
        """Take a full step in open loop."""
        self._step_number += -1 if self.axis.get("dir") else 1
        effort = int(0.33 * self.axis.get("uMAX"))
        self.axis.output(float32(self.build.step_deg * self._step_number), effort)
        yield delay_ms(10)

    def set_mode(self, letter: str) -> None:
        self.axis.set("mode", ord(letter))

    def enable(self) -> Steps:
        """Overwrite the set-point in every mode, then start the control loop."""
        mean = yield from encoder.read_mean(self.axis)
        self.axis.set("r", float32(self.table.angles[mean] + 360.0 * self.axis.get("wrap_count")))
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

    def print_menu(self) -> None:
        self.serial.println(*text.BANNER, f"Identifier: {self.build.identifier}", *text.MENU_HEAD)
        for command in COMMANDS:
            if command.label is None:
                continue
            hint = f" -- note, {text.K_HINT}" if command.letter == "k" else ""
            self.serial.println(f" {command.letter}  -  {command.label}{hint}")
            if command.letter in "pqtrm":
                self.serial.println("")


COMMANDS = (
    Command("s", "step", Mechaduino.step),
    Command("d", "dir", Mechaduino.toggle_dir),
    Command("p", "print angle", Mechaduino.print_angle),
    Command("c", "write new calibration table", Mechaduino.calibrate),
    Command("e", "check encoder diagnositics", lambda board: encoder.check(board.axis, board.serial)),
    Command(
        "q",
        "parameter query",
        lambda board: routines.print_parameters(board.axis, board.serial, board.table.text()),
    ),
    Command("x", "position mode", lambda board: board.set_mode("x")),
    Command("v", "velocity mode", lambda board: board.set_mode("v")),
    Command("t", "torque mode", lambda board: board.set_mode("t")),
    Command("y", "enable control loop", Mechaduino.enable),
    Command("n", "disable control loop", Mechaduino.disable),
    Command("r", "enter new setpoint", Mechaduino.enter_setpoint),
    Command("j", "step response", lambda board: routines.step_response(board.axis, board.serial)),
    Command("k", "edit controller gains", lambda board: edit_parameters(board.axis, board.serial)),
    Command("g", "generate sine commutation table", lambda board: routines.print_sine(board.serial)),
    Command("m", "print main menu", Mechaduino.print_menu),
    Command("w", None, Mechaduino.calibrate),
    Command("a", None, lambda board: routines.anticogging(board.axis, board.serial, board.table.angles)),
    Command("h", None, lambda board: board.set_mode("h")),
)
"""Every byte that the main loop knows; any other is ignored."""

COMMANDS_BY_LETTER = {ord(command.letter): command for command in COMMANDS}
