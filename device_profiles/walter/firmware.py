"""Program of Walter's Cortex: power-up, then a main loop whose passes the core runs by itself where there is
nothing to do in them."""

from device_profiles.walter.arm_parts import PARTS, STEPPERS
from device_profiles.walter.board_loop import US_PER_MS, BoardLoop, Steps
from device_profiles.walter.controller import Controller
from device_profiles.walter.cortex_commands import CortexCommands
from device_profiles.walter.late_save import LateSave
from device_profiles.walter.lights import READY
from device_profiles.walter.line_framing import LINES
from device_profiles.walter.logger import Logger
from device_profiles.walter.settings import SECTION
from device_profiles.walter.thermal_printer import ThermalPrinter
from hil.vocab.firmware import MAIN, Board, ByteAvailable, CoreEvent, Main

LOGGER, SERVO, PRINTER = "logger", "servo", "printer"
"""UARTs beside the command port."""
_CHANNEL_MS, _LIT_CHANNELS = 30, 16


class Cortex:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        missing = [part.name for part in PARTS if part.name not in board.joints]
        if missing or not {MAIN, LOGGER, SERVO, PRINTER} <= set(board.uarts):
            raise TypeError(f"Walter's Cortex needs the joints of its arm and four UARTs; missing: {missing}")
        self._board = board
        self._uart = board.uarts[MAIN]
        self._others = [board.uarts[name] for name in (LOGGER, PRINTER)]
        self._servo_uart = board.uarts[SERVO]
        self.loop = BoardLoop(board.joints[STEPPERS[0].name])
        self._late_save = LateSave(board.nvm, self._uart)
        memory = self._late_save.memory
        self._logger = Logger(board.uarts[LOGGER], memory)
        self._printer = ThermalPrinter(board.uarts[PRINTER], self.loop, self._logger)
        self.controller = Controller(board.joints, self._servo_uart, self.loop, memory, self._logger)
        self._commands = CortexCommands(
            self._uart, self.loop, self.controller, self._late_save, self._logger, self._printer
        )
        self.is_started = False
        """True once the prompt is there."""

    def main(self) -> Main:
        yield from self._power_up()
        if self._uart.baud is not None:
            self._uart.wake_on(LINES)
        while True:
            yield from self._wait()
            yield from self._pass()

    def interrupt(self, event: CoreEvent) -> None:
        """Write that a joint's encoder has not answered."""
        if event.kind == "reading_failed":
            part = next(part for part in STEPPERS if part.name == event.axis)
            self._logger.failed_reading(part, int(event.value))

    # ---- power-up ----

    def _power_up(self) -> Steps:
        self.loop.start()
        self._uart.write(b"WALTER's Cortex\r\n")
        self.controller.has_servo_power = True
        if self.controller.has_lights:
            yield from self.loop.pause(_LIT_CHANNELS * _CHANNEL_MS * US_PER_MS)
        yield from self._printer.set_up()
        if why := self._late_save.load():
            if self._board.nvm.get(SECTION):
                self._board.note("eeprom", f"the EEPROM was written again with what is built in: {why}")
            yield from self._late_save.save()
        yield from self.controller.set_up()
        self._uart.write(b">")
        self.controller.lights.show(READY, self.loop.ms)
        self.controller.start_timers(self.loop.ms)
        self.is_started = True
        self._tell()
        self.loop.go_on()

    # ---- main loop ----

    def _wait(self) -> Steps:
        """Wait for a command, or until something is due."""
        now_us = self.loop.us
        now_ms = now_us // US_PER_MS
        times = (self.controller.service_due_ms(now_ms), self._late_save.due_ms(now_ms))
        due_ms = min((time for time in times if time is not None), default=None)
        left_ns = None if due_ms is None else max(due_ms * US_PER_MS - now_us, 0) * 1000
        if left_ns != 0:
            yield ByteAvailable(left_ns)
        for uart in self._others:
            uart.read_all()
        if not self._uart.available():
            self._servo_uart.read_all()

    def _pass(self) -> Steps:
        before_ms, pass_ms = yield from self.loop.take_pass()
        self.controller.note_pass(before_ms)
        yield from self._read()
        yield from self._late_save.step(pass_ms)
        now_ms = self.loop.ms
        if not self.controller.is_service_due(now_ms):
            self.loop.go_on()
            return
        yield from self.loop.poll(is_first=True)
        yield from self.controller.service(now_ms)
        self.loop.finish()

    def _read(self) -> Steps:
        """Carry out what has come, and what comes meanwhile."""
        while data := self._uart.read_all():
            *lines, rest = data.split(b"\r")
            for line in lines:
                self._commands.feed(line)
                yield from self._commands.carry_out()
            self._commands.feed(rest)
            self._tell()

    def _tell(self) -> None:
        """Tell relays and state to those who look at the board."""
        of = self.controller
        self._board.tell("servo_relay", of.has_servo_power)
        self._board.tell("motor_relay", of.is_powered)
        self._board.tell("is_enabled", of.is_enabled)
        self._board.tell("error", of.error)

    # ---- for verbs ----

    def light_levels(self) -> dict[str, int]:
        """Level of the LED, and brightness of the channels of the light driver."""
        now_ms = self.loop.ms
        lights = self.controller.lights
        levels = lights.channels([self.controller.angle_deg(part.number) for part in PARTS], now_ms)
        return {"led": int(lights.led(now_ms))} | {
            f"channel_{each}": level for each, level in sorted(levels.items())
        }
