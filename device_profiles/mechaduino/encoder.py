"""The AS5047 encoder as the firmware reads it: angles and diagnostic registers, by SPI frames."""

from collections.abc import Generator, Iterable
from typing import Any

from device_profiles.mechaduino import text
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps, delay_ms
from hil.firmware.arduino import print_int
from hil.vocab.firmware import Axis, Request

READ_ANGLE, READ_DIAAGC, READ_ERRFL, NOP = 0xFFFF, 0xFFFC, 0x4001, 0xC000
"""SPI frames: read bit 14, even parity bit 15, register (AS5047D data sheet)."""
AVERAGED = 10
"""Number of readings of a mean."""


def read_count(axis: Axis) -> int:
    """Read the angle once, 0 to 16,383."""
    return axis.spi(READ_ANGLE) & 0x3FFF


def read_mean(axis: Axis) -> Generator[Request, Any, int]:
    """Stop the control loop and read the mean of ten readings, wrong across the encoder's zero."""
    axis.loop(False)
    total = 0
    for _ in range(AVERAGED):
        total += read_count(axis)
        yield delay_ms(10)
    return total // AVERAGED


def check(axis: Axis, serial: SerialUSB) -> Steps:
    """Print the registers DIAAGC and ERRFL; takes four milliseconds."""
    serial.println(*text.DIAGNOSTICS_INTRO)
    axis.spi(READ_DIAAGC)
    yield delay_ms(1)
    _print_register(serial, text.DIAAGC_HEAD, axis.spi(NOP), text.DIAAGC_LINES, text.DIAAGC_FAULTS)
    yield delay_ms(1)
    axis.spi(READ_ERRFL)
    yield delay_ms(1)
    _print_register(serial, text.ERRFL_HEAD, axis.spi(NOP), text.ERRFL_LINES, text.ERRFL_LINES)
    yield delay_ms(1)


def _print_register(
    serial: SerialUSB, head: str, frame: int, lines: dict[int, str], faults: Iterable[int]
) -> None:
    serial.println(head, print_int(frame | 0x70000, 2))
    for bit, line in lines.items():
        if frame & 1 << bit:
            serial.println(line)
    if not any(frame & 1 << bit for bit in faults):
        serial.println(text.LOOKS_GOOD)
    serial.println(" ")
