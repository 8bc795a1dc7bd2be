"""``SerialUSB`` of a sketch of a user's own: prints in the Arduino's formats, reads and parses."""

from collections.abc import Generator
from typing import Any

from hil.firmware.arduino import parse_float, print_float, print_int
from hil.firmware.sketch_waits import SketchWaits
from hil.vocab.firmware import ByteAvailable, Request, Uart


class SketchSerial:
    """Serial port of a sketch, by the Arduino's names. What waits is yielded: ``x = yield from
    serial.parseFloat()``."""

    def __init__(self, uart: Uart, waits: SketchWaits) -> None:
        self._uart, self._waits = uart, waits

    def begin(self, baud: int = 115_200) -> None:
        """Begin. A USB has no speed."""

    def print(self, value: object = "", form: int | None = None) -> None:
        """Print a text, or a number. ``form``: digits of a float, else 2, or base of an int, else 10."""
        self._uart.write(_text(value, form).encode("latin-1", "replace"))

    def println(self, value: object = "", form: int | None = None) -> None:
        """Print, and a CR LF."""
        self._uart.write((_text(value, form) + "\r\n").encode("latin-1", "replace"))

    def write(self, data: bytes | int) -> None:
        """Send bytes, or one."""
        self._uart.write(bytes((data & 0xFF,)) if isinstance(data, int) else data)

    def available(self) -> int:
        """Number of bytes that wait to be read."""
        return self._uart.available()

    def read(self) -> int:
        """The next byte, or -1."""
        return self._uart.read()

    def peek(self) -> int:
        """The next byte, which stays; or -1."""
        return self._uart.peek()

    def parseFloat(self) -> Generator[Request, Any, float]:
        """Wait for a number, a second for each character at most; 0 if none has come."""
        return self._waits.steps(parse_float(self._uart), "board.SerialUSB.parseFloat()")

    def wait(self) -> Generator[Request, Any, None]:
        """Wait for a byte: ``while (SerialUSB.available() == 0) {}``"""
        return self._waits.steps(_byte(), "board.SerialUSB.wait()")


def _byte() -> Generator[Request, Any, None]:
    yield ByteAvailable()


def _text(value: object, form: int | None) -> str:
    if isinstance(value, bool):
        return "1" if value else "0"
    if isinstance(value, int):
        return print_int(value, 10 if form is None else form)
    if isinstance(value, float):
        return print_float(value, 2 if form is None else form)
    return value.decode("latin-1") if isinstance(value, bytes) else str(value)
