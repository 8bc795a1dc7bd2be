"""Terminal of the SAC: echo, line editing, prompt."""

from collections.abc import Callable, Generator, Iterable, Sequence
from typing import Any

from device_profiles.sac.typed_text import Text
from hil.vocab.firmware import ByteAvailable, Request, Uart
from hil.vocab.framing import Item
from hil.vocab.time import SimTimeNs

PROMPT = "SAC>"
LINE_BYTES = 80
"""Maximum length of a line; the rest of a longer one is dropped (decision)."""
_CR, _LF, _BS, _DEL = 13, 10, 8, 127

Steps = Generator[Request, Any, None]


class Terminal:
    """Lines in and out; ``now`` tells the simulated time."""

    def __init__(self, uart: Uart, now: Callable[[], SimTimeNs]) -> None:
        self.uart = uart
        self._now = now
        self._after_cr = False
        self.is_muted = False
        """True while a command from the network runs: nothing is printed."""
        self.mode: Callable[[Text], Steps | None] | None = None
        """Taker of lines instead of the command line: the configure screen or a program mode."""
        self.line_began_ns = SimTimeNs(0)
        """Time of the last line's first byte."""
        self._line = bytearray()
        """The typed part of the next line."""

    def println(self, lines: Iterable[str]) -> None:
        """Print lines, each with CR LF."""
        if not self.is_muted:
            self.uart.write("".join(f"{line}\r\n" for line in lines).encode("latin-1"))

    def prompt(self) -> None:
        self.uart.write(PROMPT.encode())

    def message(self, text: bytes) -> None:
        """Show what came over the network. The typed part of a line stays in force and is drawn again."""
        self.uart.write(b"\r\n" + text + b"\r\n" + PROMPT.encode() + self._line)

    def read_line(
        self,
        is_immediate: Callable[[int], bool],
        meanwhile: Callable[[], Steps],
        takes: Callable[[Sequence[Item]], bool],
    ) -> Generator[Request, Any, str]:
        """Read the next line without its end; what is typed is echoed.

        ``is_immediate`` is asked for each first byte of an empty line: True, and the byte has been acted on.
        ``meanwhile`` runs whenever a byte has come at any port, before the terminal's is read; ``takes`` as
        ``ByteAvailable``'s. BS and DEL erase (decision).
        """
        line = self._line = bytearray()
        a_byte = ByteAvailable(takes=takes)
        while True:
            yield a_byte
            yield from meanwhile()
            if not self.uart.available():
                continue
            byte = self.uart.read()
            after_cr, self._after_cr = self._after_cr, byte == _CR
            if byte == _LF and after_cr:
                continue
            if not line:
                self.line_began_ns = self._now()
            if byte in (_CR, _LF):
                self.uart.write(b"\r\n")
                self._line = bytearray()
                return line.decode("latin-1")
            if byte in (_BS, _DEL):
                if line:
                    line.pop()
                    self.uart.write(b"\b \b")
            elif not line and is_immediate(byte):
                self.uart.write(bytes((byte,)))
            elif len(line) < LINE_BYTES:
                line.append(byte)
                self.uart.write(bytes((byte,)))
