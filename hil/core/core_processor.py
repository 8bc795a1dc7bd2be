"""Processor of a bank of pins, as Python sees it: ``hil.vocab.firmware.Processor``."""

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple, cast

from hil.core._native import NativeCore
from hil.core.abi import ProcessorMemory
from hil.core.processor_debug import ProcessorDebug
from hil.vocab.axis_plan import ProcessorPlan
from hil.vocab.firmware import ProcessorPin, UartFrame
from hil.vocab.line_format import DATA_BITS, LineFormat, Parity, format_named

FLASH_BYTES, EEPROM_BYTES, DATA_BYTES = 32_768, 1_024, 2_304
"""Sizes of an ATmega328P's memories. The data space is registers, I/O and SRAM. Source: DS40002061, 8."""
UNO_FUSES = (0xFF, 0xDE, 0xFD, 0xCF)
"""Fuses low, high and extended, and lock bits, of a Uno. Source: boards.txt of the Arduino AVR core."""
UNO_CLOCK_Hz = 16_000_000
_BITS, _FRAMINGS = 1 << 10, 1 << 7
_DATA_BITS, _PARITY, _PARITIES, _TWO_STOPS = 0x0F, 0x30, {0x20: "E", 0x30: "O"}, 0x40
"""Framing of characters, by ``avr_framing`` of ``native/mcu/avr/atmega328p.h``."""
_EIGHT_AND = tuple(LineFormat(f"8{parity}1", parity, 1, 11) for parity in ("S", "M"))
"""Formats of frames of nine data bits, by the ninth. A parity bit behind it is not sent."""


class _Drive(NamedTuple):
    """Row of what drives a pin from the chip, by ``avr_drive`` of ``native/mcu/avr/avr.h``."""

    is_output: bool
    has_pull_up: bool


_DRIVES = (_Drive(True, False), _Drive(True, False), _Drive(False, False), _Drive(False, True))


class CoreProcessor:
    """Processor of a bank of pins. While it runs, its program drives the pins."""

    def __init__(self, native: NativeCore, axis: int, pins: Mapping[str, int]) -> None:
        self._native, self._axis, self._pins = native, axis, pins
        self.is_running = False
        """True from a reset on, until it is held, or the power goes."""
        self.fuses = UNO_FUSES
        """Fuses low, high, extended, and the lock bits."""
        self._worn: bytes | None = None
        """Content of an EEPROM that keeps it, whatever a program writes."""
        self.has_boot = False
        """True if a boot loader that is not in the flash goes before the program."""
        self.clock_Hz = UNO_CLOCK_Hz
        self.debug = ProcessorDebug(native, axis)

    # ---- its memories ----

    @property
    def flash(self) -> bytes:
        return self._native.processor_read(self._axis, ProcessorMemory.flash, 0, FLASH_BYTES)

    def load(self, at: int, data: bytes) -> None:
        self._check(at, data, FLASH_BYTES)
        self._native.processor_load(self._axis, at, data)

    @property
    def eeprom(self) -> bytes:
        return self._native.processor_read(self._axis, ProcessorMemory.eeprom, 0, EEPROM_BYTES)

    def load_eeprom(self, at: int, data: bytes) -> None:
        self._check(at, data, EEPROM_BYTES)
        self._native.processor_load_eeprom(self._axis, at, data)

    def wear_eeprom(self, is_worn: bool) -> None:
        """Let the EEPROM keep what it has, whatever a program writes, or be as new."""
        self._worn = self.eeprom if is_worn else None

    def note_written(self) -> None:
        """Note that a program has written into the EEPROM."""
        if self._worn is not None:
            self.load_eeprom(0, self._worn)

    def data(self, at: int, count: int) -> bytes:
        self._check(at, bytes(max(0, count)), DATA_BYTES)
        return self._native.processor_read(self._axis, ProcessorMemory.data, at, count)

    def poke(self, address: int, value: int) -> None:
        self._check(address, b"\0", DATA_BYTES)
        self._native.processor_poke(self._axis, address, value)

    @staticmethod
    def _check(at: int, data: bytes, room: int) -> None:
        if not 0 <= at <= at + len(data) <= room:
            raise ValueError(f"{len(data)} bytes at {at:#x}: the memory has {room}")

    # ---- its life ----

    def set_up(self, plan: ProcessorPlan) -> None:
        """Give it the clock, the voltages and the fuses of its board."""
        self.set_clock(plan.clock_Hz)
        self._native.processor_supply(self._axis, plan.supply_V, plan.aref_V)
        self.fuses = (*plan.fuses, UNO_FUSES[-1])

    @property
    def start_up_cycles(self) -> int:
        """Cycles of its clock from a reset to its first instruction, by its fuses. Source: DS40002061, 9."""
        return self._native.processor_start_up(self._axis)

    def name_of(self, number: int) -> str | None:
        """Board's name of a pin, by the chip's number for it; None: the board has none there."""
        return next((name for name, each in self._pins.items() if each == number), None)

    def set_fuses(self, low: int, high: int, extended: int, lock: int, *, has_boot: bool = False) -> None:
        self.fuses, self.has_boot = (low, high, extended, lock), has_boot
        self._native.processor_set_fuses(self._axis, low, high, extended, lock, has_boot)

    def reset(self, causes: int, start_up_cycles: int = 0) -> None:
        self._native.processor_reset(self._axis, causes, start_up_cycles)
        self.is_running = True

    def set_stack_floor(self, address: int) -> None:
        self._native.processor_stack_floor(self._axis, address)

    def hold(self) -> None:
        self._native.processor_hold(self._axis)
        self.is_running = False

    def lose_power(self) -> None:
        """Note that its power has gone, and its memories with it."""
        self.is_running = False

    def set_clock(self, clock_Hz: int) -> None:
        """Change its clock, as one that is off by some per cent has it."""
        self.clock_Hz = clock_Hz
        self._native.processor_clock(self._axis, clock_Hz)

    @property
    def cycles(self) -> int:
        return self._native.processor_cycles(self._axis)

    @property
    def program_counter(self) -> int:
        return self._native.processor_pc(self._axis)

    # ---- its pins ----

    def pin(self, name: str) -> ProcessorPin:
        drive, level, duty = self._native.processor_pin(self._axis, self._pins[name])
        of = _DRIVES[drive]
        return ProcessorPin(level, of.is_output, of.has_pull_up, None if duty < 0 else duty)

    def set_volts(self, channel: int, volts: float) -> None:
        """Set the voltage at an analogue pin, A0 to A7; where it follows a field, what is added to that."""
        self._native.processor_volts(self._axis, channel, volts)

    def measure(self, channel: int, axis: int, field: int, gain: float, volts: float) -> None:
        """Let the voltage at an analogue pin follow a field of an axis of its group, by the numbers of both:
        the field times ``gain``, and ``volts``."""
        self._native.processor_measure(self._axis, channel, axis, field, gain, volts)

    def smooth(self, channel: int, axis: int, pin: int, rc_s: float, gain: float, volts: float) -> None:
        """Let the voltage at an analogue pin follow the mean level of a pin of a bank of its group, in volts,
        through an RC low-pass: that times ``gain``, and ``volts``. Raises MemoryError: the bank has 16."""
        self._native.processor_smooth(self._axis, channel, axis, pin, rc_s, gain, volts)

    def drives_line(self, pin: str) -> None:
        """Let an output enable the driver of the line that it sends on (RS485): its changes are events."""
        self._native.processor_drives_line(self._axis, self._pins[pin])

    # ---- its serial interface ----

    @property
    def line_format(self) -> LineFormat:
        """Format of characters that its program has set: 5 to 9 data bits."""
        return _format_of(self._native.processor_framing(self._axis))

    @property
    def baud(self) -> int:
        """Speed of its serial interface, rounded to whole baud; 0: it is off."""
        return self._native.processor_baud(self._axis)

    def hear(self, start_ns: int, bit_ns: float, bits: int, length: int, *, is_broken: bool) -> bool:
        """Let a character come to its RX: ``length`` bits after the start bit, the first one lowest, without
        stop bits. ``is_broken``: its stop bit is low. False: too many wait."""
        return self._native.processor_hear(self._axis, start_ns, bit_ns, bits, length, is_broken)

    def retract(self, after_ns: int) -> None:
        """Take back characters that would begin after this time."""
        self._native.processor_retract(self._axis, after_ns)

    def frame(self, value: float) -> UartFrame:
        """Frame of an event ``sent``."""
        rest, bits = divmod(int(value), _BITS)
        bit_cycles_256, framing = divmod(rest, _FRAMINGS)
        line_format = _format_of(framing)
        if line_format.data_bits > DATA_BITS:
            line_format = _EIGHT_AND[bits >> DATA_BITS & 1]
        byte = bits & (1 << line_format.data_bits) - 1
        return UartFrame(byte, line_format, round(256 * self.clock_Hz / bit_cycles_256))


@cache
def _format_of(framing: int) -> LineFormat:
    data_bits, parity = framing & _DATA_BITS, _PARITIES.get(framing & _PARITY, "N")
    stop_bits = 2 if framing & _TWO_STOPS else 1
    name = f"{data_bits}{parity}{stop_bits}"
    bits = 1 + data_bits + (parity != "N") + stop_bits
    return format_named(name) or LineFormat(name, cast(Parity, parity), stop_bits, bits, data_bits)
