"""The thermal printer: its bytes, and how long the board waits for it."""

from collections.abc import Iterable

from device_profiles.walter.board_loop import US_PER_MS, BoardLoop, Steps
from device_profiles.walter.logger import Logger
from hil.vocab.firmware import Uart

BYTE_US = 1146
"""Time for a byte: 11 bits at 9600 baud."""
_DOT_PRINT_US, _DOT_FEED_US = 30_000, 2_100
_SPACING_DOTS = 6
_LF = ord("\n")
_ESC = 0x1B
_WAKE = bytes((0xFF,))
_WAKE_MS = 50
_SET_UP = (
    bytes((_ESC, 0x38, 0, 0)),
    bytes((_ESC, 0x40)),
    bytes((_ESC, 0x44)),
    bytes((4, 8, 12, 16)),
    bytes((20, 24, 28, 0)),
    bytes((_ESC, 0x37)),
    bytes((11, 120, 40)),
    bytes((0x12, 0x23, 0x4A)),
    bytes((_ESC, 0x7B, 1)),
)
"""Groups of bytes, each of which waits for the one before: wake, reset, tabs, heat, density, upside down."""
_MODES = {"b": ("b", 0x08), "h": ("2", 0x10), "w": ("w", 0x20)}
"""Tags on the logger and bits of the print mode, by the letter behind a backslash."""


class ThermalPrinter:
    """Printer at its UART. There is no handshake: the board waits as long as a line takes."""

    def __init__(self, uart: Uart, loop: BoardLoop, logger: Logger) -> None:
        self._uart, self._loop, self._logger = uart, loop, logger
        self._free_us = 0
        self._before, self._column, self._mode = _LF, 0, 0
        self._is_on = dict.fromkeys("bhwu", False)

    def set_up(self) -> Steps:
        """Send what a printer is woken with."""
        yield from self._send(_WAKE)
        yield from self._loop.pause(_WAKE_MS * US_PER_MS)
        for group in _SET_UP:
            yield from self._send(group)

    def text(self, text: str) -> Steps:
        """Print a piece of text, and tell the logger. A backslash with a letter turns a style on or off."""
        self._logger.write('print "')
        place = 0
        while place < len(text):
            letter = text[place + 1 : place + 2]
            if text[place] == "\\" and letter:
                place += 1
                if letter in "bhwul":
                    yield from self._toggle(letter)
                    place += 1
                continue
            self._logger.write(text[place])
            yield from self.write(text[place].encode("latin-1"))
            place += 1
        self._logger.line('"')

    def write(self, data: bytes) -> Steps:
        """Send bytes of text, each when the one before is printed."""
        for byte in data:
            yield from self._wait()
            self._uart.write(bytes((byte,)))
            wait_us = BYTE_US
            if byte == _LF or self._column == self._columns:
                wait_us += self._line_us()
                self._column, self._before = 0, _LF
            else:
                self._column, self._before = self._column + 1, byte
            self._free_us = self._loop.us + wait_us

    @property
    def _columns(self) -> int:
        return 16 if self._mode & 0x20 else 32

    def _line_us(self) -> int:
        height = 48 if self._mode & 0x10 else 24
        if self._before == _LF:
            return (height + _SPACING_DOTS) * _DOT_FEED_US
        return height * _DOT_PRINT_US + _SPACING_DOTS * _DOT_FEED_US

    def _toggle(self, letter: str) -> Steps:
        """Turn a style on or off. The picture (l) is not printed; it turns the note of bold, as on the
        board."""
        style = "b" if letter == "l" else letter
        is_on = self._is_on[style] = not self._is_on[style]
        if letter == "l":
            return
        if letter == "u":
            self._logger.write("<u>" if is_on else "</u>")
            yield from self._send(bytes((_ESC, 0x2D, int(is_on))))
            return
        tag, bit = _MODES[letter]
        self._logger.write(f"<{tag}>" if is_on else f"</{tag}>")
        self._mode = self._mode | bit if is_on else self._mode & ~bit
        yield from self._send(bytes((_ESC, 0x21, self._mode)))

    def _send(self, group: Iterable[int]) -> Steps:
        """Send bytes that are no text, together."""
        yield from self._wait()
        data = bytes(group)
        self._uart.write(data)
        self._free_us = self._loop.us + len(data) * BYTE_US

    def _wait(self) -> Steps:
        yield from self._loop.pause(self._free_us - self._loop.us)
