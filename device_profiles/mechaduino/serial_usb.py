"""Sketch's ``SerialUSB``: prints in the Arduino's formats, waits and parses."""

from collections.abc import Generator
from typing import Any

from hil.firmware.arduino import parse_float, print_float
from hil.vocab.firmware import ByteAvailable, Delay, Request, Uart
from hil.vocab.time import NS_PER_MS

_A_BYTE = ByteAvailable()
Steps = Generator[Request, Any, None]


def delay_ms(duration: int) -> Delay:
    """Make the board's delay()."""
    return Delay(duration * NS_PER_MS)


class SerialUSB:
    """Print and Stream over the board's UART."""

    def __init__(self, uart: Uart) -> None:
        self._uart = uart

    def print(self, text: str) -> None:
        self._uart.write(text.encode("latin-1"))

    def println(self, *lines: str) -> None:
        """Print lines, each with CR LF."""
        self._uart.write("".join(f"{line}\r\n" for line in lines).encode("latin-1"))

    def print_float(self, value: float, digits: int = 2) -> None:
        self.print(print_float(value, digits))

    def available(self) -> int:
        return self._uart.available()

    def wait(self) -> Steps:
        """Wait for input: ``while (SerialUSB.available() == 0) {}``"""
        yield _A_BYTE

    def read(self) -> int:
        return self._uart.read()

    def ask_float(self) -> Generator[Request, Any, float]:
        """Wait for a first byte forever, then parse a number as Stream::parseFloat does."""
        yield from self.wait()
        return (yield from parse_float(self._uart))
