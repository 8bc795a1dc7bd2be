"""Routines of the menu that need no more than the axis: listings, the step response, anticogging."""

import math
from collections.abc import Iterable, Sequence

from device_profiles.mechaduino import text
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps, delay_ms
from hil.vocab.firmware import Axis


def print_parameters(axis: Axis, serial: SerialUSB, table: str) -> None:
    """Print the gains with 10 decimals and the look-up table."""

    def gain(name: str, comment: str = "") -> None:
        serial.print(f"volatile float {name} = ")
        serial.print_float(axis.get(name) if name != "Fs" else 6500.0, 10)
        serial.println(f";{comment}")

    serial.println(" ", "----Current Parameters-----", " ", " ")
    gain("Fs", "  //Sample frequency in Hz")
    serial.println(" ")
    gain("pKp", "      //position mode PID vallues.")
    for name in ("pKi", "pKd", "pLPF"):
        gain(name)
    serial.println(" ")
    gain("vKp", "      //velocity mode PID vallues.")
    for name in ("vKi", "vKd", "vLPF"):
        gain(name)
    serial.println("", "//This is the encoder lookup table (created by calibration routine)", "")
    serial.println("const float __attribute__((__aligned__(256))) lookup[16384] = {")
    serial.print(table)
    serial.println("", "};")


def print_sine(serial: SerialUSB) -> Steps:
    """Print the table that the firmware would make; the built-in one differs (it has pi = 3.1415)."""
    serial.println(*text.SINE_INTRO)
    yield delay_ms(3000)
    serial.println(*text.SINE_HEAD)
    values = (1024.0 * math.sin(3.14159265358979 * (x * 0.1 / 180.0)) for x in range(3601))
    serial.print("".join(f"{_round(value)}, " for value in values))


def _round(x: float) -> int:
    """C's round(): halves away from zero."""
    return math.floor(x + 0.5) if x >= 0 else -math.floor(-x + 0.5)


def step_response(axis: Axis, serial: SerialUSB) -> Steps:
    """Step the set-point by 97.65 degrees and back, while the control interrupt prints the angle."""
    serial.println(*text.STEP_RESPONSE_INTRO)
    axis.loop(True)
    axis.set("r", 0)
    for seconds in range(9, 0, -1):
        yield delay_ms(1000)
        serial.println(f"{seconds}...")
    yield delay_ms(1000)
    axis.set("print_yw", 1)
    yield delay_ms(100)
    axis.set("r", 97.65)  # 97.65 * 1024 is about 100,000
    yield delay_ms(400)
    axis.set("print_yw", 0)
    axis.set("r", 0)
    yield delay_ms(500)
    axis.loop(False)


def anticogging(axis: Axis, serial: SerialUSB, angles: Sequence[float]) -> Steps:
    """Hold 656 angles of the look-up table there and back, and print the effort that each takes."""
    serial.println(text.ANTICOGGING_BEGIN)
    axis.set("mode", ord("x"))
    axis.set("r", angles[1])
    axis.loop(True)
    yield delay_ms(1000)
    yield from _hold(axis, serial, (angles[count] for count in range(1, 657)))
    serial.println(text.ANTICOGGING_REVERSE)
    yield from _hold(axis, serial, (angles[count] for count in range(656, 0, -1)))
    serial.println(text.ANTICOGGING_DONE)
    axis.loop(False)


def _hold(axis: Axis, serial: SerialUSB, angles: Iterable[float]) -> Steps:
    for angle in angles:
        axis.set("r", angle)
        serial.print_float(axis.get("r"), 10)
        serial.print(" , ")
        yield delay_ms(100)
        serial.print_float(axis.get("u"), 10)
        serial.println("")
