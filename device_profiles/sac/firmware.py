"""The SAC's program: its command line, session and memory. The motion itself is the core's.

Sources: the SAC user manual, Appendix C and the chapters Command Detail, Configure and System Commands.
Where it leaves something open, ``README.md`` of this folder lists what was decided.
"""

from collections.abc import Callable, Generator
from dataclasses import replace
from typing import Any

from device_profiles.sac import screens
from device_profiles.sac.eeprom import BY_LETTER, CUSTOM, Eeprom, EepromError
from device_profiles.sac.line import Attributes, Text, Velocity, from_cycle, read_attributes, read_steps
from device_profiles.sac.session import Session
from device_profiles.sac.terminal import Terminal
from hil.vocab.firmware import Board, ByteAvailable, Commit, CoreEvent, Main, Request
from hil.vocab.motion import CONTINUOUS_SLOT, ONE_SHOT_SLOT, QUEUE_LEN, MotionEntry
from hil.vocab.time import NS_PER_MS

VERSION = "1.0"
COLD_START_NS = 1000 * NS_PER_MS
"""Between the version and the first prompt; a byte in it restores the factory's settings (manual,
bail-out)."""
MEMORY, ASIDE = "eeprom", "eeprom_damaged"
"""Sections of the board's memory: the EEPROM, and one that could not be read."""
RST_FACT = "rst"

Steps = Generator[Request, Any, None]


class Sac:
    """One power-up of the firmware."""

    def __init__(self, board: Board) -> None:
        if board.motion is None:
            raise TypeError("a SAC needs a board that makes step pulses (law: sac)")
        self.motion = board.motion
        self._uart = board.uart
        self._nvm = board.nvm
        self.terminal = Terminal(board.uart)
        self.eeprom = Eeprom()
        self.session = Session(self.eeprom.parameters)
        self._undo: tuple[int, MotionEntry] | None = None
        self._saved: bytes | None = None
        self._mode: Callable[[Text], bool] | None = None

    def main(self) -> Main:
        yield from self._load()
        self._uart.write(f"SAC {VERSION}\r\n".encode())
        wants_factory = yield ByteAvailable(COLD_START_NS)
        if wants_factory or self.motion.get("pin_rst") == 0:
            while self._uart.read() >= 0:
                pass
            self.eeprom = Eeprom()
            yield from self._save()
        self._reset()
        self._seed(self.eeprom.queue)
        if self.eeprom.parameters.autorun > 0:
            self.motion.loop_start(1)
            self.motion.loop_finish(self.eeprom.parameters.autorun)
        if not self.session.is_bricked:
            self.terminal.prompt()
        while True:
            if self.session.is_bricked:
                yield from self._silence()
            line = yield from self.terminal.read_line(self._single_pulse)
            yield from self._execute(line.partition(" ")[0])
            if not self.session.is_bricked:
                self.terminal.prompt()

    def interrupt(self, event: CoreEvent) -> None:
        """Nothing that the core reports concerns the terminal."""

    def _silence(self) -> Steps:
        """The other port is the terminal now, and nothing is there (manual, network: a bricked unit)."""
        while True:
            yield ByteAvailable()
            self._uart.read()

    # ---- memory ----

    def _load(self) -> Steps:
        stored = self._nvm.get(MEMORY)
        if stored is None:
            return
        try:
            self.eeprom = Eeprom.unpacked(stored)
        except EepromError:
            yield Commit(ASIDE, stored)
            yield from self._save()

    def _save(self) -> Steps:
        yield Commit(MEMORY, self.eeprom.packed())

    def _reset(self) -> None:
        """What a cold start and ``$R`` do: the EEPROM's parameters come into force."""
        parameters = self.eeprom.copy().parameters
        self.session.restart(parameters)
        self.motion.setup(parameters.setup())
        self.motion.gap(self.session.is_gap_on)
        self.motion.encoder_mode(self.session.is_throttle)

    def _seed(self, entries: list[MotionEntry] | None) -> None:
        default = self.session.parameters.default_entry()
        for position in range(1, QUEUE_LEN + 1):
            self.motion.write_entry(position, entries[position - 1] if entries else default)

    # ---- the command line ----

    def _single_pulse(self, byte: int) -> bool:
        if byte not in b"+-" or self._mode is not None:
            return False
        self.motion.pulse(byte == ord("-"))
        return True

    def _execute(self, line: str) -> Steps:
        text = Text(line)
        if self._mode is not None:
            if text.takes("xX") and not text.rest():
                self._mode = None
                return
            if self._mode(text):
                yield from self._save()
            return
        letter = text.take()
        command = EXACT.get(letter) or COMMANDS.get(letter.lower())
        if command is not None:
            yield from command(self, text) or ()
            if self.session.is_debug:
                self.terminal.println("0 us")  # parsing takes no simulated time

    def _stop_at_once(self, text: Text) -> None:
        self.motion.stop(None)

    def _stop_gracefully(self, text: Text) -> None:
        self.motion.stop(self.session.default.dec_hundredths)

    def _next_at_once(self, text: Text) -> None:
        self.motion.next(False)

    def _next_gracefully(self, text: Text) -> None:
        self.motion.next(True)

    def _release(self, text: Text) -> None:
        self.motion.release_sync()

    def _move(self, text: Text) -> None:
        said = Attributes()
        read_steps(text, said)
        attributes = self._attributes(text)
        attributes.steps, attributes.is_ccw = said.steps, said.is_ccw
        entry = self._entry(attributes)
        if not said.steps:
            self.motion.write_entry(CONTINUOUS_SLOT, replace(entry, steps=0))
            self.motion.run_continuous()
            return
        if int(self.motion.get("pending")) < QUEUE_LEN:
            position = self.session.next_position
            self._write(position, entry)
            self.session.next_position = position % QUEUE_LEN + 1
            self.motion.enqueue(position)
        self.session.default = replace(
            entry,
            steps=self.session.default.steps,
            is_ccw=self.session.default.is_ccw,
            is_sync=False,
            wait_us=0,
        )

    def _attributes(self, text: Text, *, with_steps: bool = False) -> Attributes:
        return read_attributes(text, self.session.parameters.steps_per_rev, with_steps=with_steps)

    def _entry(self, said: Attributes) -> MotionEntry:
        """A command as typed, on the session's defaults."""
        default_dir = self.session.parameters.default_entry().is_ccw
        if said.is_ccw is None:
            said.is_ccw = default_dir
        return said.apply(self.session.default, self.session.parameters.ramps())

    def _write(self, position: int, entry: MotionEntry) -> None:
        self._undo = (position, self.motion.entry(position))
        self.motion.write_entry(position, entry)

    def _acceleration(self, text: Text) -> None:
        acc = text.hundredths()
        self._default(Attributes(acc=-1 if acc is None else acc))

    def _deceleration(self, text: Text) -> None:
        dec = text.hundredths()
        self._default(Attributes(dec=-1 if dec is None else dec))

    def _default(self, said: Attributes) -> None:
        self.session.default = said.apply(self.session.default, self.session.parameters.ramps())

    def _velocity(self, text: Text) -> None:
        if text.takes("dD"):
            rpm, period_us = int(self.motion.get("speed_rpm")), int(self.motion.get("period_us"))
            self.terminal.println(f"{rpm}\t{period_us}")
            return
        if not text.peek():
            parameters = self.session.parameters
            velocity: Velocity | None = from_cycle(parameters.cycle_us, parameters.steps_per_rev)
        else:
            velocity = self._attributes(Text("v" + text.rest())).velocity
        if velocity:
            self._default(Attributes(velocity=velocity))
            self.motion.retarget(velocity.rpm, velocity.cycle_us)

    def _loop(self, text: Text) -> None:
        if not text.peek():
            self.motion.finish()
            return
        which = text.peek().lower()
        if which.isdigit():
            self.motion.loop_array((text.number() or 0) % 65536)
            return
        text.take()
        number = text.number() or 0
        if which == "a":
            self.motion.loop_start(1)
            self.motion.loop_finish(QUEUE_LEN)
        elif which == "s" and 1 <= number <= QUEUE_LEN:
            self.motion.loop_start(number)
        elif which == "f" and 1 <= number <= QUEUE_LEN:
            self.motion.loop_finish(number)
        elif which == "n":
            self.motion.loop_passes(number % 65536)

    def _debug(self, text: Text) -> None:
        self.session.is_debug = not self.session.is_debug

    def _show(self, text: Text) -> None:
        if text.takes("cC"):
            self.terminal.println(*screens.configuration(self.eeprom.parameters))
        elif text.takes("fF"):
            self.terminal.println(*self.session.lines())

    def _gap(self, text: Text) -> None:
        self.session.is_gap_on = not self.session.is_gap_on
        self.motion.gap(self.session.is_gap_on)

    def _undo_last(self, text: Text) -> None:
        if self._undo:
            position, entry = self._undo
            self._write(position, entry)

    # ---- queue and xRef ----

    def _list_queue(self) -> None:
        first = 0 if self.session.is_debug else 1
        entries = {position: self.motion.entry(position) for position in range(first, QUEUE_LEN + 1)}
        running = int(self.motion.get("queue_position"))
        at = running if 1 <= running <= QUEUE_LEN else self.session.next_position
        self.terminal.println(*screens.queue(entries, at))

    def _queue(self, text: Text) -> Steps:
        letter = text.peek().lower()
        if not letter:
            self._list_queue()
        elif letter.isdigit():
            self._edit(text)
        elif letter == "s":
            self.eeprom.queue = [self.motion.entry(position) for position in range(1, QUEUE_LEN + 1)]
            yield from self._save()
        elif letter == "r":
            self._seed(self.eeprom.queue)
        elif letter == "c":
            seed = self.session.parameters.default_entry()
            entry = replace(
                self.session.default,
                steps=seed.steps,
                is_ccw=seed.is_ccw,
                extra_pulses=0,
                is_sync=False,
                wait_us=0,
            )
            for position in range(1, QUEUE_LEN + 1):
                self.motion.write_entry(position, entry)
        elif letter == "p":
            self._list_queue()
            self._mode = self._edit

    def _edit(self, text: Text) -> bool:
        position = text.number()
        if position is not None and 1 <= position <= QUEUE_LEN:
            said = self._attributes(text, with_steps=True)
            self._write(position, said.apply(self.motion.entry(position), self.session.parameters.ramps()))
        return False

    def _xref(self, text: Text) -> None:
        letter = text.peek().lower()
        if letter == "d":
            self.terminal.println(*screens.xref(self.motion.xref()))
        elif letter == "p":
            self._mode = self._edit_xref
        elif letter == "l":
            text.take()
            self.motion.loop_array((text.number() or 0) % 65536)
        elif letter == "m":
            text.take()
            said = Attributes()
            read_steps(text, said)
            attributes = self._attributes(text)
            attributes.steps, attributes.is_ccw = said.steps, said.is_ccw
            entry = self._entry(attributes)
            if said.steps:
                self.motion.write_entry(ONE_SHOT_SLOT, entry)
                self.motion.run_once(ONE_SHOT_SLOT)
            else:
                self.motion.write_entry(CONTINUOUS_SLOT, replace(entry, steps=0))
                self.motion.run_continuous()
        elif (position := text.number()) is not None and 1 <= position <= QUEUE_LEN:
            self.motion.run_once(position)

    def _edit_xref(self, text: Text) -> bool:
        index = text.number()
        text.takes(",")
        position = text.number()
        if index is not None and position is not None and index <= QUEUE_LEN and position <= QUEUE_LEN:
            self.motion.write_xref(index, 0 if index == QUEUE_LEN else position)
        self.terminal.println(*screens.xref(self.motion.xref()))
        return False

    # ---- system commands ----

    def _system(self, text: Text) -> Steps:
        self.motion.stop(None)
        letter = text.take()
        session, number = self.session, None if letter == "C" else text.number()
        if letter == "C":
            yield from self._configure(text)
        elif letter == "E":
            stored = self._nvm.get(MEMORY, self.eeprom.packed())
            if session.is_debug:
                self.terminal.println(*screens.dump(stored))
            else:
                self.terminal.println(*screens.configuration(self.eeprom.parameters))
        elif letter == "R":
            self._reset()
        elif letter in "FPU" and letter:
            is_pulses = {"F": False, "P": True, "U": not session.default.is_pulses}[letter]
            session.default = replace(session.default, is_pulses=is_pulses)
        elif letter == "H":
            session.is_crc_on = number != 0
        elif letter == "K":
            session.is_ack_on = number != 0
        elif letter == "L" and number is not None:
            self._default(Attributes(is_linear=number != 0))
        elif letter == "O" and number is not None:
            session.is_soft_ops_on = number != 0
        elif letter == "n":
            session.is_throttle = not session.is_throttle
            self.motion.encoder_mode(session.is_throttle)

    def _configure(self, text: Text) -> Steps:
        if text.peek():
            if self._change(text):
                yield from self._save()
            return
        self.terminal.println(*screens.configuration(self.eeprom.parameters))

        def edit(line: Text) -> bool:
            changed = self._change(line)
            self.terminal.println(*screens.configuration(self.eeprom.parameters))
            return changed

        self._mode = edit

    def _change(self, text: Text) -> bool:
        """Set a parameter in the EEPROM; answers whether anything was."""
        letter = text.take()
        parameters = self.eeprom.parameters
        if letter == "u":
            number = text.number()
            if number is None:
                return False
            parameters.is_pulses = int(number != 0)
            return True
        if letter == "U":
            exponent, pins = text.take(), text.take()
            if not ("0" <= exponent <= "7" and "0" <= pins <= "7") or len(exponent + pins) != 2:
                return False
            parameters.pin_map[int(exponent)] = int(pins)
            return True
        parameter = BY_LETTER.get(letter)
        value = parameter.read(text) if parameter else None
        if parameter is None or value is None:
            return False
        if parameter.field == "driver_id" and value > CUSTOM:
            value = CUSTOM
        setattr(parameters, parameter.field, value)
        return True


EXACT: dict[str, Callable[[Sac, Text], Steps | None]] = {
    "S": Sac._stop_at_once,
    "s": Sac._stop_gracefully,
    "N": Sac._next_at_once,
    "n": Sac._next_gracefully,
    "y": Sac._release,
    "$": Sac._system,
}
"""Commands whose letter's case matters."""

COMMANDS: dict[str, Callable[[Sac, Text], Steps | None]] = {
    "m": Sac._move,
    "a": Sac._acceleration,
    "d": Sac._deceleration,
    "l": Sac._loop,
    "v": Sac._velocity,
    "b": Sac._debug,
    "c": Sac._show,
    "g": Sac._gap,
    "q": Sac._queue,
    "x": Sac._xref,
    "z": Sac._undo_last,
}
"""The others, by their small letters."""
