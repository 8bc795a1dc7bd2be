"""Persistent parameters of the SAC: factory values, the configure screen's table, and how one is changed."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from device_profiles.sac.typed_text import Text, from_cycle
from hil.vocab.motion import QUEUE_LEN, MotionEntry, MotionSetup

A4988, DRV8825 = 0, 1
PIN_MAPS = {A4988: (0, 1, 2, 3, 7, 0, 0, 0), DRV8825: (0, 1, 2, 3, 4, 5, 0, 0)}
"""Pin maps of the drivers: MS3 MS2 MS1 as three bits, by microstep exponent (data sheets)."""
OPS_FACTORY = 36
"""Factory value of ops. Bits 5 and 2: OP SA and OP SB (manual, ops)."""
FACTORY_BAUD = 38400
SOFTWARE_BAUD_LIMIT = 38400
"""Maximum baud of the port that is made in software (manual, communications)."""

BAUD_MINIMUM, BAUD_MAXIMUM = 488, 2_000_000
"""Range of the UART's divider at 16 MHz (ATmega328P data sheet); decision: values beyond are clamped."""


@dataclass
class Parameters:
    """Persistent parameters with their factory values (manual, Configure)."""

    autorun: int = 0
    is_linear: int = 0
    is_clock_internal: int = 1
    is_network_swapped: int = 0
    cw_level: int = 0
    dir_level: int = 0
    interrupt_overhead_us: int = 8
    clock_correction_us: int = 0
    microstep_exponent: int = 1
    pulse_us: int = 30
    slow_rpm: int = 10
    device_id: int = 85
    driver_id: int = A4988
    steps_per_rev: int = 200
    cycle_us: int = 3000
    external_clock_Hz: int = 1_000_000
    acc: int = 100
    dec: int = 100
    linear_acc: int = 1047
    linear_dec: int = 1047
    ops: int = OPS_FACTORY
    soft_ops: int = 0
    ack: int = 1
    crc: int = 1
    hardware_baud: int = FACTORY_BAUD
    software_baud: int = FACTORY_BAUD
    is_pulses: int = 0
    pin_map: list[int] = field(default_factory=lambda: [0] * 8)
    """Pin map of driver 2."""

    def ramp(self, is_linear: bool) -> tuple[int, int]:
        """Acceleration and deceleration of a kind of ramp, in hundredths."""
        return (self.linear_acc, self.linear_dec) if is_linear else (self.acc, self.dec)

    def bauds(self) -> tuple[int, int]:
        hardware, software = (
            min(max(baud, BAUD_MINIMUM), BAUD_MAXIMUM) for baud in (self.hardware_baud, self.software_baud)
        )
        return hardware, software

    def setup(self) -> MotionSetup:
        exponent = min(self.microstep_exponent, 7)
        pins = PIN_MAPS.get(self.driver_id, self.pin_map)[exponent]
        return MotionSetup(
            steps_per_rev=max(self.steps_per_rev, 1),
            slow_rpm=self.slow_rpm,
            microstep_exponent=exponent,
            pulse_us=self.pulse_us,
            interrupt_overhead_us=self.interrupt_overhead_us,
            clock_correction_us=self.clock_correction_us,
            is_clock_internal=bool(self.is_clock_internal),
            external_clock_Hz=self.external_clock_Hz,
            is_cw_high=bool(self.cw_level),
            ops=self.ops,
            mode_pins=pins,
        )

    def default_entry(self) -> MotionEntry:
        """Entry that an empty queue is seeded with."""
        velocity = from_cycle(self.cycle_us, self.steps_per_rev)
        acc, dec = self.ramp(bool(self.is_linear))
        return MotionEntry(
            steps=self.steps_per_rev,
            is_ccw=self.dir_level != self.cw_level,
            rpm=velocity.rpm,
            cycle_us=velocity.cycle_us,
            acc_hundredths=acc,
            dec_hundredths=dec,
            is_linear=bool(self.is_linear),
            extra_pulses=0,
            is_sync=False,
            wait_us=0,
            is_pulses=bool(self.is_pulses),
        )


class Parameter(NamedTuple):
    """Row of the configure screen: its letter, its name, the field behind it, its reader."""

    letter: str
    name: str
    field: str
    read: Callable[[Text], int | None]
    show: Callable[[Parameters, Any], str] = lambda parameters, value: str(value)


def _number(convert: Callable[[int], int]) -> Callable[[Text], int | None]:

    def read(text: Text) -> int | None:
        number = text.number()
        return None if number is None else convert(number)

    return read


_flag = _number(lambda number: int(number != 0))
_byte = _number(lambda number: number % 256)
_autorun = _number(lambda number: min(number % 256, QUEUE_LEN))
_word = _number(lambda number: number % 65536)


def _two_places(parameters: Parameters, value: int) -> str:
    return f"{value / 100:.2f}"


def _direction(parameters: Parameters, value: int) -> str:
    return "CW" if value == parameters.cw_level else "CCW"


LEFT = (
    Parameter("A", "autorun", "autorun", _autorun),
    Parameter("B", "ramp", "is_linear", _flag),
    Parameter("C", "clock", "is_clock_internal", _flag),
    None,
    Parameter("E", "network", "is_network_swapped", _flag),
    Parameter("F", "cw", "cw_level", _flag),
    Parameter("G", "dir", "dir_level", _flag, _direction),
    Parameter("H", "ihd", "interrupt_overhead_us", _byte),
    Parameter("I", "xclk", "clock_correction_us", _byte),
    Parameter("J", "ustep", "microstep_exponent", _byte),
    Parameter("K", "pulse", "pulse_us", _byte),
    Parameter("L", "slow", "slow_rpm", _byte),
    Parameter("M", "d_id", "device_id", _byte),
    Parameter("N", "r_id", "driver_id", _byte),
)
RIGHT = (
    Parameter("a", "sprf", "steps_per_rev", _word),
    Parameter("b", "cycle", "cycle_us", Text.number),
    Parameter("c", "xfreq", "external_clock_Hz", Text.number),
    Parameter("d", "acc", "acc", Text.hundredths, _two_places),
    Parameter("e", "dec", "dec", Text.hundredths, _two_places),
    Parameter("f", "l_acc", "linear_acc", Text.hundredths, _two_places),
    Parameter("g", "l_dec", "linear_dec", Text.hundredths, _two_places),
    Parameter("h", "ops", "ops", _byte, lambda parameters, value: f"{value:b}"),
    Parameter("i", "soft_ops", "soft_ops", _flag),
    Parameter("j", "ACK", "ack", _flag),
    Parameter("k", "CRC", "crc", _flag),
    None,
    Parameter("m", "hw", "hardware_baud", Text.number),
    Parameter("n", "sw", "software_baud", Text.number),
)
"""Columns of the configure screen, row by row."""
BY_LETTER = {p.letter: p for p in (*LEFT, *RIGHT) if p}


def change(parameters: Parameters, text: Text) -> bool:
    """Set a parameter by ``text``, a letter and a value as on the configure screen; False: it is no
    parameter."""
    letter = text.take()
    if letter == "u":
        if (is_pulses := _flag(text)) is not None:
            parameters.is_pulses = is_pulses
        return is_pulses is not None
    if letter == "U":
        return _map_pins(parameters, text)
    parameter = BY_LETTER.get(letter)
    value = parameter.read(text) if parameter else None
    if parameter is None or value is None:
        return False
    setattr(parameters, parameter.field, value)
    return True


def _map_pins(parameters: Parameters, text: Text) -> bool:
    """Set a pin map by ``Unx``: the custom driver's pins for microstep exponent n, a digit each."""
    if not text.is_digit():
        return False
    exponent = int(text.take())
    if not text.is_digit():
        return False
    pins = int(text.take())
    if exponent > 7 or pins > 7:
        return False
    parameters.pin_map[exponent] = pins
    return True
