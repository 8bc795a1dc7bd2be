"""Terminal of a port, as Linux keeps one: its settings, what waits, who has it open."""

import socket
import termios
from collections.abc import Callable
from typing import Any

from hil.testing.serial_ports.line_ends import LineEnd
from hil.testing.serial_ports.port_lines import AT_OPENING, PortLines
from hil.vocab.line_format import EIGHT_N_1, format_named
from hil.vocab.ports import ADAPTER
from hil.vocab.time import FOREVER, SimTimeNs

XON, XOFF = b"\x11", b"\x13"
CUSTOM_BAUD = 0x1000
"""BOTHER, asm-generic/termbits.h: the speed stands in a field of its own."""
MARK_OR_SPACE = 0x40000000
"""CMSPAR, asm-generic/termbits.h."""
_DATA_BITS = {termios.CS5: 5, termios.CS6: 6, termios.CS7: 7, termios.CS8: 8}
BAUD_OF_CODE = {
    getattr(termios, name): int(name[1:]) for name in dir(termios) if name[:1] == "B" and name[1:].isdigit()
}
_FRESH = [
    termios.ICRNL | termios.IXON,
    termios.OPOST | termios.ONLCR,
    termios.B38400 | termios.CS8 | termios.CREAD | termios.HUPCL,
    termios.ISIG | termios.ICANON | termios.ECHO | termios.ECHOE | termios.ECHOK | termios.IEXTEN,
    termios.B38400,
    termios.B38400,
]
"""Settings of a terminal that nobody has set (tty_std_termios of Linux, drivers/tty/tty_io.c)."""


class PortTerminal:
    """Terminal of a port. ``lines``: its modem lines; None: it has none, as a pty."""

    def __init__(self, name: str, end: LineEnd, lines: PortLines | None = None) -> None:
        self.name, self.end, self.lines = name, end, lines
        self.identity = ADAPTER
        """Identity on a USB."""
        self.opens = 0
        """Number of times that it is open."""
        self.lock: object = None
        """Holder of its lock; None: nobody."""
        self.lock_outside: Callable[[bool], bool] = lambda is_locked: True
        """Locks it against other processes that may have it, or unlocks it; False: one has the lock."""
        self.settings: list[Any] = [*_FRESH, [b"\0"] * 32]
        self.custom_baud = 0
        self.is_stopped = False
        """True while it takes nothing to send, by XOFF or by request."""
        self._input = bytearray()
        self._to_send = bytearray()
        self._watched: tuple[socket.socket, socket.socket] | None = None
        self._shows_input = False

    # ---- open and closed ----

    def open(self, now_ns: SimTimeNs) -> None:
        """Open it once more. What came while nobody had it open is lost."""
        if not self.opens:
            self.end.collect(now_ns)
            self._input.clear()
            self._set_line(now_ns)
            if self.lines:
                self.lines.set(AT_OPENING, now_ns)
            else:
                self.end.opened()
        self.opens += 1

    def close(self, now_ns: SimTimeNs) -> None:
        """Close it once. The last client takes with it what was not sent."""
        self.opens -= 1
        if not self.opens:
            self._to_send.clear()
            self._input.clear()
            self.is_stopped = False
            if self.lines:
                self.lines.set(0, now_ns)
            self.end.closed()
            if self._watched:
                for each in self._watched:
                    each.close()
                self._watched = None

    # ---- in ----

    def waiting(self, now_ns: SimTimeNs) -> int:
        """Number of bytes that have come and were not read."""
        if self.end.next_ns <= now_ns:
            data = self.end.collect(now_ns)
            self._input += self._without_flow_control(data) if self.settings[0] & termios.IXON else data
        return len(self._input)

    def _without_flow_control(self, data: bytes) -> bytes:
        """Obey XON and XOFF, and leave them out."""
        last = max((XON, XOFF), key=data.rfind)
        if last in data:
            self.is_stopped = last == XOFF
        return data.translate(None, XON + XOFF)

    def peek(self, now_ns: SimTimeNs) -> bytes:
        """Bytes that have come and were not read, to the first end of a line; they stay."""
        self.waiting(now_ns)
        return bytes(self._input[: self._input.find(b"\n") + 1 or None])

    def read(self, count: int, now_ns: SimTimeNs) -> bytes:
        """Read so many bytes at most; none: there are none."""
        self.waiting(now_ns)
        data = bytes(self._input[:count])
        del self._input[:count]
        self.show()
        return data

    def flush_input(self, now_ns: SimTimeNs) -> None:
        """Throw away what has come."""
        self.waiting(now_ns)
        self._input.clear()
        self.show()

    # ---- out ----

    @property
    def unsent(self) -> int:
        """Number of bytes that wait until the board takes more."""
        return len(self._to_send)

    def write(self, data: bytes, now_ns: SimTimeNs) -> None:
        """Send bytes; those that find no room now wait."""
        self._to_send += data
        self.send(now_ns)

    def send(self, now_ns: SimTimeNs) -> None:
        """Send what waits and finds room now."""
        while self._to_send and (room := self.end.room(now_ns)):
            piece = bytes(self._to_send[:room])
            del self._to_send[:room]
            self.end.feed(piece)

    def flush_output(self) -> None:
        """Throw away what waits to be sent."""
        self._to_send.clear()

    # ---- settings ----

    def set(self, settings: list[Any], now_ns: SimTimeNs) -> None:
        """Set speed, format and the rest, in the form of ``termios.tcgetattr``."""
        self.settings = [*settings[:6], [*settings[6]]]
        self._set_line(now_ns)

    def set_custom_baud(self, baud: int, now_ns: SimTimeNs) -> None:
        """Set a speed for which there is no code."""
        self.custom_baud = baud
        self.settings[4] = self.settings[5] = CUSTOM_BAUD
        self._set_line(now_ns)

    def _set_line(self, now_ns: SimTimeNs) -> None:
        flags, code = self.settings[2], self.settings[5]
        baud = self.custom_baud if code == CUSTOM_BAUD else BAUD_OF_CODE.get(code, 0)
        parity = "N"
        if flags & termios.PARENB:
            parity = ("MO" if flags & termios.PARODD else "SE")[not flags & MARK_OR_SPACE]
        data_bits = _DATA_BITS[flags & termios.CSIZE]
        made = format_named(f"{data_bits}{parity}{2 if flags & termios.CSTOPB else 1}")
        self.end.set_line(baud, made or EIGHT_N_1)
        if self.lines:
            self.lines.set_baud(baud, now_ns)

    @property
    def due_ns(self) -> SimTimeNs:
        """Time at which something happens here by itself."""
        return self.lines.due_ns if self.lines else FOREVER

    # ---- for select ----

    def descriptor(self) -> int:
        """File descriptor that is readable while there is something to read, from now on."""
        if self._watched is None:
            self._watched = ours, theirs = socket.socketpair()
            ours.setblocking(False)
            theirs.setblocking(False)
            self._shows_input = False
            self.show()
        return self._watched[1].fileno()

    @property
    def is_watched(self) -> bool:
        """True if somebody may wait for it in a ``select`` of his own."""
        return self._watched is not None

    def show(self) -> None:
        """Let the descriptor be readable or not."""
        if self._watched and self._shows_input != bool(self._input):
            self._shows_input = bool(self._input)
            if self._shows_input:
                self._watched[0].send(b"x")
            else:
                self._watched[1].recv(1)

    def passed(self, now_ns: SimTimeNs) -> None:
        """Note that time has passed."""
        if self.lines:
            self.lines.passed(now_ns)
        if self._to_send:
            self.send(now_ns)
        self.waiting(now_ns)
        self.show()
