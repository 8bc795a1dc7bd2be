"""Commands of the board: what each takes, does and replies."""

from collections.abc import Callable, Mapping

from device_profiles.walter import lights
from device_profiles.walter.arm_parts import PARTS, STEPPERS
from device_profiles.walter.board_loop import BoardLoop, Steps
from device_profiles.walter.command_text import CommandText, begins, is_same_name
from device_profiles.walter.controller import Controller
from device_profiles.walter.float32 import f32, long_of, real_text
from device_profiles.walter.late_save import LateSave
from device_profiles.walter.logger import Logger
from device_profiles.walter.thermal_printer import ThermalPrinter
from hil.vocab.firmware import Uart

WORD_WRONG, WORD_MISSING, UNKNOWN, NO_POWER_YET, NO_SET_UP = 3, 4, 5, 6, 7
_HELP = (
    "LED <on|off|blink>",
    'ECHO "hello"',
    "SETUP [force]",
    "ENABLE",
    "DISABLE",
    "POWER <on|off>",
    "KNOB <ActuatorNo>",
    "STEP <ActuatorNo> <incr>",
    "CHECKSUM <on|off>",
    "MEM (<reset>|<list>)",
    "SET <ActuatorNo> name=value ... : one setting after the other, of min max null speed acc P I D",
    "GET <ActuatorNo> : angle, limits and null of one actuator",
    "GET all : the same of all seven in one line",
    "MOVETO <angle1> <angle2> ... <angle7> <durationMS>",
    "LOG <setup|servo|stepper|encoder|loop> <on|off>",
    "INFO",
)
OWN_WORDS = frozenset(f"\t{line}" for line in _HELP if line.split()[0] in ("SET", "GET"))
"""Lines of the help that are in our own words."""
_LOG_CLASSES = {"setup": "setup", "servo": "servo", "stepp": "stepper", "encod": "encoder"}
"""Names of the flags by what a class begins with."""
_WHOLE_LOG_CLASSES = {b"LOOP": "loop", b"TEST": None}
"""Classes that are compared whole, with their flags."""
_SETTINGS: Mapping[str, tuple[str, Callable[[float], bool]]] = {
    "min": ("min_deg", lambda x: abs(x) < 180),
    "max": ("max_deg", lambda x: abs(x) < 180),
    "null": ("null_deg", lambda x: abs(x) < 360),
    "speed": ("speed_rpm", lambda x: abs(x) < 9999),
    "acc": ("acceleration_rpm_per_s", lambda x: abs(x) < 99999),
    "P": ("kP", lambda x: abs(x) <= 10),
    "I": ("kI", lambda x: abs(x) <= 1),
    "D": ("kD", lambda x: abs(x) <= 100),
}
"""Settings and what they may be, by their names, in the order in which they are read."""
_MOST_DEG, _MOST_STEP_DEG, _STEP_MS_PER_DEG = 360, 10, 50
_LEAST_MS, _MOST_MS = 20, 9999


class CortexCommands:
    """Commands at the command port.

    Long because it has a method for each command of the port.
    """

    def __init__(
        self,
        uart: Uart,
        loop: BoardLoop,
        controller: Controller,
        late_save: LateSave,
        logger: Logger,
        printer: ThermalPrinter,
    ) -> None:
        self._uart, self._loop, self._controller = uart, loop, controller
        self._late_save, self._memory = late_save, late_save.memory
        self._logger, self._printer = logger, printer
        self._text = CommandText()
        self._table: Mapping[str, Callable[[], Steps | None]] = {
            "LED": self._led,
            "HELP": self._help,
            "ECHO": self._echo,
            "ENABLE": self._enable,
            "DISABLE": self._disable,
            "SETUP": self._set_up,
            "POWER": self._power,
            "KNOB": self._knob,
            "STEP": self._step,
            "CHECKSUM": self._checksum,
            "MEM": self._mem,
            "SET": self._set,
            "GET": self._get,
            "MOVETO": self._moveto,
            "LOG": self._log,
            "INFO": self._info,
            "PRINT": self._print,
            "PRINTLN": self._println,
        }

    def feed(self, data: bytes) -> None:
        """Take what is typed before the end of a command."""
        self._text.feed(data)

    def carry_out(self) -> Steps:
        """Carry out the command that stands there."""
        word = self._text.begin()
        if word is not None:
            found = next((name for name in self._table if is_same_name(word, name)), None)
            if found is None:
                self._say(word.decode("ascii"))
                self._nok(UNKNOWN)
            else:
                self._text.error = 0
                yield from self._table[found]() or ()
                self._controller.error = 0
        self._text.clear()

    # ---- replies ----

    def _say(self, text: str) -> None:
        self._uart.write(text.encode("latin-1"))

    def _ok(self) -> None:
        self._say(">ok\r\n>")

    def _nok(self, number: int) -> None:
        if number == WORD_MISSING:
            number = self._text.error or number
        self._say(f">nok({number})\r\n>")

    def _answer(self, is_good: bool) -> None:
        if is_good:
            self._ok()
        else:
            self._nok(WORD_WRONG)

    def _ends(self) -> bool:
        """Check the checksum; say what is wrong with it."""
        said = self._text.check()
        self._say(said or "")
        return said is None

    def _only_word(self) -> bytes | None:
        """Take the one argument; None: it is missing, or the checksum is wrong, and the reply is given."""
        word = self._text.word()
        if self._ends() and word is not None:
            return word
        self._nok(WORD_MISSING)
        return None

    def _only_ends(self) -> bool:
        """Check that a command without arguments may be carried out; else give the reply."""
        if self._ends():
            return True
        self._nok(WORD_MISSING)
        return False

    # ---- commands without time ----

    def _led(self) -> None:
        if (word := self._only_word()) is None:
            return
        blink = lights.READY if self._controller.is_enabled else lights.IDLE
        patterns = (("on", lights.ON), ("off", lights.OFF), ("blink", blink))
        found = [pattern for prefix, pattern in patterns if begins(word, prefix)]
        for pattern in found:
            self._controller.lights.show(pattern, self._loop.ms)
        self._answer(bool(found))

    def _help(self) -> None:
        if self._only_ends():
            self._say("usage:\r\n" + "".join(f"\t{line}\r\n" for line in _HELP))
            self._ok()

    def _echo(self) -> None:
        if (word := self._only_word()) is not None:
            self._say(word.decode("ascii"))
            self._ok()

    def _checksum(self) -> None:
        word = self._text.word()
        if word is None:
            self._nok(WORD_MISSING)
            return
        for prefix, is_on in (("on", True), ("off", False)):
            if begins(word, prefix):
                self._text.is_checked = is_on
                self._ok()
                return
        self._nok(WORD_WRONG)

    def _mem(self) -> Steps:
        if (word := self._only_word()) is None:
            return
        if begins(word, "reset"):
            self._memory.reset()
            for part in STEPPERS:
                self._controller.apply(part.number)
            self._logger.settings()
            yield from self._late_save.save()
        elif begins(word, "list"):
            self._logger.configuration()
        else:
            self._nok(WORD_WRONG)
            return
        self._ok()

    def _set(self) -> None:
        number = self._text.int16()
        given = {name: self._text.named_real(name) for name in _SETTINGS}
        if not self._ends() or number is None:
            self._nok(WORD_MISSING)
            return
        stored = False
        if 0 <= number < len(PARTS):
            setting = self._controller.setting(number)
            for name, value in given.items():
                field, is_allowed = _SETTINGS[name]
                if value is None or not is_allowed(value):
                    continue
                stored = True
                if number < len(STEPPERS) or name in ("min", "max", "null"):
                    setattr(setting, field, value)
            self._controller.apply(number)
        if stored:
            self._late_save.begin(self._loop.ms)
        self._answer(stored)

    def _get(self) -> None:
        if (word := self._only_word()) is None:
            return
        if begins(word, "all"):
            numbers = range(len(PARTS))
        elif b"0" <= word[:1] <= b"6" and (number := long_of(word.decode("ascii"))) < len(PARTS):
            numbers = range(number, number + 1)
        else:
            self._nok(WORD_WRONG)
            return
        if not self._controller.is_set_up:
            self._controller.fail(NO_SET_UP)
            self._nok(self._controller.error)
            return
        for number in numbers:
            at, deg = self._controller.setting(number), self._controller.angle_deg(number)
            numbers_text = zip(
                ("ang", "min", "max", "null"), (deg, at.min_deg, at.max_deg, at.null_deg), strict=True
            )
            self._say(f" n={number} " + " ".join(f"{name}={real_text(x)}" for name, x in numbers_text))
        self._ok()

    def _moveto(self) -> None:
        angles = [self._text.real() for _ in PARTS]
        duration_ms = self._text.int16()
        is_good = all(deg is not None and abs(deg) <= _MOST_DEG for deg in angles)
        is_good &= duration_ms is not None and _LEAST_MS <= duration_ms <= _MOST_MS
        if not self._ends() or not is_good or duration_ms is None:
            self._nok(WORD_MISSING)
            return
        wanted = [deg for deg in angles if deg is not None]
        if self._memory.log.loop:
            self._logger.line(f"moveTo {','.join([*map(real_text, wanted), str(duration_ms)])}")
        for number, deg in enumerate(wanted):
            self._controller.move(number, deg, duration_ms)
        self._ok()

    def _log(self) -> None:
        kind, word = self._text.word(), self._text.word()
        if not self._ends() or kind is None or word is None:
            self._nok(WORD_MISSING)
            return
        self._logger.line(f"log {kind.decode('ascii')} {word.decode('ascii')}")
        is_on, is_off = begins(word, "on"), begins(word, "off")
        flag = next((flag for prefix, flag in _LOG_CLASSES.items() if begins(kind, prefix)), None)
        flag = flag or _WHOLE_LOG_CLASSES.get(kind.upper())
        is_known = flag is not None or kind.upper() in _WHOLE_LOG_CLASSES
        if flag and (is_on or is_off):
            setattr(self._memory.log, flag, is_on)
        self._answer(is_known and (is_on or is_off))

    def _info(self) -> None:
        if not self._only_ends():
            return
        of = self._controller
        words = (("powered", of.is_powered), ("setuped", of.is_set_up), ("enabled", of.is_enabled))
        self._say("".join(f" {word}" for word, is_so in words if is_so))
        if of.current is not None:
            self._say(f" curr={of.current}")
        for bus in (0, 1):
            found = ",".join(f"0x{address:02X}" for address in of.i2c_addresses(bus))
            self._say(f" i2c{bus}=({found})")
        self._ok()

    # ---- commands that take time ----

    def _enable(self) -> Steps:
        if not self._only_ends():
            return
        if not self._controller.is_powered:
            self._nok(self._controller.error)
            return
        yield from self._controller.enable()
        self._ok()

    def _disable(self) -> Steps:
        if self._only_ends():
            yield from self._controller.disable()
            self._ok()

    def _set_up(self) -> Steps:
        if not self._only_ends():
            return
        if (yield from self._controller.set_up()):
            self._ok()
        else:
            self._nok(self._controller.error)

    def _power(self) -> Steps:
        if (word := self._only_word()) is None:
            return
        if begins(word, "on") and self._controller.is_set_up:
            self._controller.power(True)
        elif begins(word, "off"):
            yield from self._controller.disable()
            self._controller.power(False)
        else:
            self._controller.fail(WORD_WRONG if self._controller.is_set_up else NO_POWER_YET)
            self._nok(self._controller.error)
            return
        self._ok()

    def _knob(self) -> Steps:
        number = self._text.int16()
        if not self._ends() or number is None:
            self._nok(WORD_MISSING)
        elif 0 <= number <= len(PARTS):
            if number < len(STEPPERS) and not self._controller.is_powered:
                self._controller.power(True)
            yield from self._controller.select(number)
            self._controller.use_knob(True)
            self._ok()
        elif number == -1:
            self._controller.use_knob(False)
            self._controller.power(False)
            self._ok()
        else:
            self._nok(WORD_WRONG)

    def _step(self) -> Steps:
        number = self._text.int16()
        by_deg = None if number is None else self._text.real()
        if not self._ends() or number is None or by_deg is None:
            self._nok(WORD_MISSING)
        elif 0 <= number < len(PARTS) and abs(by_deg) < _MOST_STEP_DEG:
            yield from self._controller.select(number)
            self._controller.move_by(number, by_deg, int(f32(abs(by_deg) * _STEP_MS_PER_DEG)))
            self._ok()
        else:
            self._nok(WORD_WRONG)

    def _print(self) -> Steps:
        """Print words. Afterwards a checksum is needed: what is put back is that of the command's word."""
        needs_check = bool(self._text.checksum)
        self._text.is_checked = False
        yield from self._print_words(has_banners=True)
        self._text.is_checked = needs_check
        self._ok()

    def _println(self) -> Steps:
        needs_check = bool(self._text.checksum)
        self._text.is_checked = False
        yield from self._print_words(has_banners=False)
        self._text.is_checked = needs_check
        yield from self._printer.write(b"\r\n")
        self._ok()

    def _print_words(self, *, has_banners: bool) -> Steps:
        while (text := self._text.text()) is not None:
            yield from self._printer.text(" ")
            if has_banners and text[:2].upper() in ("T1", "T2"):
                continue  # banners of the firmware's author are left out
            if text[:3].upper() == "CHK":
                self._text.put_back()
                return
            yield from self._printer.text(text)
