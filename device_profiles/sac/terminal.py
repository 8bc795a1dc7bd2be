"""The SAC's terminal: echo, line editing, prompt."""

from collections.abc import Generator
from typing import Any

from hil.vocab.firmware import ByteAvailable, Request, Uart

PROMPT = "SAC>"
LINE_BYTES = 80
"""Longer lines lose the rest (decision: the manual has no number)."""
_CR, _LF, _BS, _DEL = 13, 10, 8, 127
_A_BYTE = ByteAvailable()


class Terminal:
    """Lines in and out. ``immediate`` is asked for each first byte of an empty line: True takes it."""

    def __init__(self, uart: Uart) -> None:
        self._uart = uart
        self._after_cr = False

    def println(self, *lines: str) -> None:
        """Lines, each with CR LF."""
        self._uart.write("".join(f"{line}\r\n" for line in lines).encode("latin-1"))

    def prompt(self) -> None:
        self._uart.write(PROMPT.encode())

    def read_line(self, immediate: Any) -> Generator[Request, Any, str]:
        """The next line without its end; what is typed is echoed."""
        line = bytearray()
        while True:
            yield _A_BYTE
            byte = self._uart.read()
            after_cr, self._after_cr = self._after_cr, byte == _CR
            if byte == _LF and after_cr:
                continue
            if byte in (_CR, _LF):
                self._uart.write(b"\r\n")
                return line.decode("latin-1")
            if byte in (_BS, _DEL):
                if line:
                    line.pop()
                    self._uart.write(b"\b \b")
            elif not line and immediate(byte):
                continue
            elif len(line) < LINE_BYTES:
                line.append(byte)
                self._uart.write(bytes((byte,)))
